// Cases over processes, and the journal that keeps their answers.
#include "experiments/workers.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>

#include "core/error.hpp"
#include "experiments/output.hpp"

namespace mss {
namespace {

namespace fs = std::filesystem;

/// A file that does not outlive the test.
struct File {
  fs::path path = fs::temp_directory_path() / ("mss-journal-test-" + std::to_string(getpid()));
  File() = default;
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  ~File() { fs::remove(path); }
};

std::vector<std::string> numbers(int count) {
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) names.push_back("case " + std::to_string(i));
  return names;
}

Json square(std::size_t i) { return {{"square", i * i}, {"text", std::string(i * 100, 'x')}}; }

/// Stops once so many answers are in.
class StopAfter final : public Progress {
 public:
  explicit StopAfter(int answers) : left_(answers) {}
  void report(double, std::string_view) override { --left_; }
  bool stopped() const override { return left_ <= 0; }

 private:
  int left_;
};

TEST(Workers, AnswerEveryCaseOnce) {
  for (const int processes : {1, 2, 4, 100}) {
    Journal journal;
    Progress progress;
    ASSERT_TRUE(find_answers(numbers(60), square, processes, journal, progress));
    ASSERT_EQ(journal.size(), 60U);
    for (std::size_t i = 0; i < 60; ++i)
      EXPECT_EQ(*journal.find("case " + std::to_string(i)), square(i)) << processes;
  }
}

TEST(Workers, ReportWhatGoesWrong) {
  Journal journal;
  Progress progress;
  const auto throws = [](std::size_t i) -> Json {
    if (i == 3) throw InputError("no such thing");
    return square(i);
  };
  try {
    find_answers(numbers(5), throws, 2, journal, progress);
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "case 3: no such thing");
  }
  const auto dies = [](std::size_t i) {
    if (i == 2) std::raise(SIGKILL);
    return square(i);
  };
  Journal other;
  EXPECT_THROW(find_answers(numbers(5), dies, 2, other, progress), std::runtime_error);
}

TEST(Workers, NumbersThatAreNotFiniteBecomeNull) {
  Journal journal;
  Progress progress;
  const auto nothing = [](std::size_t) { return Json{{"x", std::numeric_limits<double>::quiet_NaN()}}; };
  ASSERT_TRUE(find_answers({"one"}, nothing, 1, journal, progress));
  EXPECT_TRUE((*journal.find("one"))["x"].is_null());
}

TEST(Workers, InterruptedTheyGoOnFromTheJournal) {
  const File file;
  const Json what{{"what", "squares"}};
  {
    Journal journal(file.path, what);
    StopAfter progress(7);
    EXPECT_FALSE(find_answers(numbers(40), square, 2, journal, progress));
  }
  std::ofstream(file.path, std::ios::app) << R"({"case":"case 39","ans)";  // as a crash would leave it
  Journal journal(file.path, what);
  const std::size_t kept = journal.size();
  EXPECT_GE(kept, 7U);
  EXPECT_LT(kept, 40U);
  std::vector<std::string> known;
  for (const std::string& name : numbers(40))
    if (journal.find(name) != nullptr) known.push_back(name);
  Progress progress;
  const auto refuse = [](std::size_t) -> Json { throw InputError("asked again"); };
  EXPECT_TRUE(find_answers(known, refuse, 2, journal, progress));
  ASSERT_TRUE(find_answers(numbers(40), square, 2, journal, progress));
  const Journal read_again(file.path, what);
  EXPECT_EQ(read_again.size(), 40U);
  for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(*read_again.find("case " + std::to_string(i)), square(i));
}

TEST(Journal, BelongsToWhatBeganIt) {
  const File file;
  { Journal journal(file.path, {{"cells", 3}}); }
  EXPECT_THROW(Journal(file.path, {{"cells", 4}}), InputError);
  EXPECT_NO_THROW(Journal(file.path, {{"cells", 3}}));
  write_atomically(file.path, "something else\n");
  EXPECT_THROW(Journal(file.path, {{"cells", 3}}), InputError);
  EXPECT_EQ(read_file(file.path), "something else\n");
}

}  // namespace
}  // namespace mss

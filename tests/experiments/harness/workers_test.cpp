// Cases over processes, and the journal that keeps their results.
#include "experiments/harness/workers.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>

#include "core/base/error.hpp"
#include "experiments/harness/case_rows.hpp"
#include "experiments/io/output.hpp"
#include "tests/experiments/stop_after.hpp"

namespace mss {
namespace {

namespace fs = std::filesystem;

/// A file that is removed after the test.
struct File {
  fs::path path = fs::temp_directory_path() / ("mss-journal-test-" + std::to_string(getpid()));
  File() = default;
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  ~File() { fs::remove(path); }
};

Json square(std::size_t i) { return {{"square", i * i}, {"text", std::string(i * 100, 'x')}}; }

std::string name(std::size_t i) { return "case " + std::to_string(i); }

std::vector<Case> numbers(std::size_t count, Json (*compute)(std::size_t) = square) {
  std::vector<Case> cases;
  for (std::size_t i = 0; i < count; ++i) cases.push_back({name(i), [i, compute] { return compute(i); }});
  return cases;
}

TEST(Workers, ComputeEveryCaseOnce) {
  for (const int processes : {1, 2, 4, 100}) {
    Journal journal;
    Progress progress;
    ASSERT_TRUE(compute_cases(numbers(60), processes, journal, progress));
    ASSERT_EQ(journal.size(), 60U);
    for (std::size_t i = 0; i < 60; ++i) EXPECT_EQ(*journal.find(name(i)), square(i)) << processes;
  }
}

TEST(Workers, ReportErrors) {
  Journal journal;
  Progress progress;
  const auto throws = [](std::size_t i) -> Json {
    if (i == 3) throw std::range_error("no such thing");
    return square(i);
  };
  try {
    compute_cases(numbers(5, throws), 2, journal, progress);
    FAIL() << "nothing was thrown";
  } catch (const InputError&) {
    FAIL() << "the user is blamed";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "case 3: no such thing");
  }
  const auto dies = [](std::size_t i) {
    if (i == 2) std::raise(SIGKILL);
    return square(i);
  };
  const auto leaves = [](std::size_t i) {
    if (i == 2) std::_Exit(0);
    return square(i);
  };
  Journal other;
  EXPECT_THROW(compute_cases(numbers(5, dies), 2, other, progress), std::runtime_error);
  Journal third;
  EXPECT_THROW(compute_cases(numbers(5, leaves), 2, third, progress), std::runtime_error);
}

TEST(Workers, RefuseWhatACaseRefuses) {
  Journal journal;
  Progress progress;
  const auto refuses = [](std::size_t i) -> Json {
    if (i == 3) throw InputError("dt is not a step");
    return square(i);
  };
  try {
    compute_cases(numbers(5, refuses), 2, journal, progress);
    FAIL() << "nothing was thrown";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "case 3: dt is not a step");
  }
}

TEST(Workers, NumbersThatAreNotFiniteBecomeNull) {
  Journal journal;
  Progress progress;
  const auto nothing = [] { return Json{{"x", std::numeric_limits<double>::quiet_NaN()}}; };
  ASSERT_TRUE(compute_cases({{"one", nothing}}, 1, journal, progress));
  EXPECT_TRUE((*journal.find("one"))["x"].is_null());
}

/// Of parts each computes its own; what the journal has of others is passed on too.
TEST(Workers, GatherResultsInTheOrderOfTheCases) {
  const File file;
  std::vector<Case> cases = numbers(20);
  for (Case& one : cases) one.group = one.name;
  Journal journal(file.path, {}, {.index = 1, .count = 2});
  journal.add(name(19), square(19));
  Progress progress;
  std::vector<std::size_t> found;
  const auto take = [&](const Json& result) { found.push_back(result["square"]); };
  EXPECT_EQ(gather_cases(cases, 4, journal, progress, take), Status::ok);
  std::vector<std::size_t> expected;
  for (std::size_t i = 0; i < 20; ++i)
    if (i == 19 || journal.part().has(name(i))) expected.push_back(i * i);
  EXPECT_EQ(found, expected);
  EXPECT_LT(found.size(), 20U);
  StopAfter stopped(0);
  Journal empty;
  EXPECT_EQ(gather_cases(cases, 1, empty, stopped, take), Status::interrupted);
}

TEST(Workers, RowsOfATableAreTheSameAsAResult) {
  Table table({{"name"}, {"count"}, {"value"}, {"status"}});
  for (const double value : {1.0, -0.0, 1e300, 0.1 + 0.2, no_value})
    table.add({std::string("a, \"b\""), 7, value, std::string(std::isnan(value) ? "failed" : "ok")});
  Table again = table.select({"name", "count", "value", "status"});
  add_rows(Json::parse(rows_of(table).dump()), again);
  ASSERT_EQ(again.size(), 2 * table.size());
  EXPECT_EQ(again.csv(), table.csv() + table.csv().substr(table.csv().find('\n') + 1));
}

TEST(Workers, ContinueFromTheJournalAfterAnInterruption) {
  const File file;
  const Json what{{"what", "squares"}};
  {
    Journal journal(file.path, what);
    StopAfter progress(7);
    EXPECT_FALSE(compute_cases(numbers(40), 2, journal, progress));
  }
  std::ofstream(file.path, std::ios::app) << R"({"case":"case 39","res)";  // as a crash would leave it
  Journal journal(file.path, what);
  const std::size_t kept = journal.size();
  EXPECT_GE(kept, 7U);
  EXPECT_LT(kept, 40U);
  std::vector<Case> known;
  for (const Case& c : numbers(40, [](std::size_t) -> Json { throw InputError("computed twice"); }))
    if (journal.find(c.name) != nullptr) known.push_back(c);
  Progress progress;
  EXPECT_TRUE(compute_cases(known, 2, journal, progress));
  ASSERT_TRUE(compute_cases(numbers(40), 2, journal, progress));
  const Journal read_again(file.path, what);
  EXPECT_EQ(read_again.size(), 40U);
  for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(*read_again.find(name(i)), square(i));
}

TEST(Journal, RejectsAnotherConfiguration) {
  const File file;
  { Journal journal(file.path, {{"cells", 3}}); }
  EXPECT_THROW(Journal(file.path, {{"cells", 4}}), InputError);
  EXPECT_NO_THROW(Journal(file.path, {{"cells", 3}}));
  std::ofstream(file.path, std::ios::app) << "{}\n";  // JSON, but no result
  EXPECT_EQ(Journal(file.path, {{"cells", 3}}).size(), 0U);
  write_atomically(file.path, "something else\n");
  EXPECT_THROW(Journal(file.path, {{"cells", 3}}), InputError);
  EXPECT_EQ(read_file(file.path), "something else\n");
}

TEST(Journal, OfAnotherBuildIsKeptAside) {
  const File file;
  {
    Journal journal(file.path, {{"cells", 3}});
    journal.add(name(1), square(1));
  }
  std::string text = read_file(file.path);
  const std::string version = "\"version\":\"";
  text.insert(text.find(version) + version.size(), "1");
  write_atomically(file.path, text);
  EXPECT_EQ(Journal(file.path, {{"cells", 3}}).size(), 0U);
  EXPECT_EQ(read_file(file.path.string() + ".before"), text);
  fs::remove(file.path.string() + ".before");
}

}  // namespace
}  // namespace mss

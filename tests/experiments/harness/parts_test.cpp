// Parts of an experiment that are computed apart, and what is made of them together.
#include "experiments/harness/parts.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "experiments/io/output.hpp"

namespace mss {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

TEST(Parts, EveryGroupBelongsToOneOfThem) {
  for (const int count : {1, 2, 3, 7})
    for (int group = 0; group < 50; ++group) {
      int owners = 0;
      for (int index = 1; index <= count; ++index)
        owners += CasePart{index, count}.has("group " + std::to_string(group)) ? 1 : 0;
      EXPECT_EQ(owners, 1);
      EXPECT_TRUE((CasePart{1 + group % count, count}.has("")));
    }
}

TEST(Parts, AreWrittenAsIOfN) {
  EXPECT_EQ(parse_part("2/5").index, 2);
  EXPECT_EQ(parse_part("2/5").count, 5);
  for (const char* text : {"", "2", "0/3", "4/3", "1/0", "-1/3", "1/3x", "1 / 3", "a/b", "1/1000000"})
    EXPECT_THROW(parse_part(text), InputError) << text;
}

/// Cases of `mss stability failures` by one method.
const ExperimentOptions few{.quick = true, .integrators = {"verlet"}, .processes = 2};

void run_parts(const fs::path& folder, int count, int seed = 1) {
  for (int i = 1; i <= count; ++i) {
    ExperimentOptions options = few;
    options.part = {i, count};
    options.seed = std::uint64_t(seed);
    const Report report = run_part(find_experiment("failures"), options, folder / std::to_string(i));
    ASSERT_EQ(report.status, Status::ok);
  }
}

/// Two parts, `1` and `2`, which are computed once.
void copy_two_parts(const fs::path& folder) {
  static const TemporaryDirectory computed;
  if (!fs::exists(computed.path() / "2")) run_parts(computed.path(), 2);
  fs::copy(computed.path(), folder, fs::copy_options::recursive);
}

std::string complaint_about(const std::vector<fs::path>& parts, const fs::path& out) {
  try {
    merge_parts(parts, out);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// Replaces a text in a part's part.json.
void plant(const fs::path& part, const std::string& before, const std::string& after) {
  std::string text = read_file(part / "part.json");
  const std::size_t at = text.find(before);
  ASSERT_NE(at, std::string::npos) << before;
  write_atomically(part / "part.json", text.replace(at, before.size(), after));
}

TEST(Parts, TogetherAreTheRunOfTheWhole) {
  const TemporaryDirectory folder;
  const fs::path& root = folder.path();
  run_parts(root, 3);
  EXPECT_FALSE(fs::exists(root / "1" / "failures.csv"));
  const PartsFound found = merge_parts({root / "3", root / "1", root / "2"}, root / "merged");
  run_and_write(*found.info, found.options, root / "merged");
  run_and_write(find_experiment("failures"), few, root / "whole");
  for (const char* table : {"failures.csv", "failures_random.csv"}) {
    EXPECT_GT(read_file(root / "whole" / table).size(), 1000U);
    EXPECT_EQ(read_file(root / "merged" / table), read_file(root / "whole" / table));
  }
  EXPECT_FALSE(fs::exists(root / "merged" / "failures.journal"));
}

TEST(Parts, ThatDoNotBelongTogetherAreRefused) {
  const TemporaryDirectory folder;
  const fs::path& root = folder.path();
  const fs::path out = root / "merged", one = root / "1", two = root / "2";
  copy_two_parts(root);
  EXPECT_THAT(complaint_about({one}, out), HasSubstr("of failures a part is missing: 2/2"));
  EXPECT_THAT(complaint_about({one, two, one}, out), HasSubstr("are both part 1/2"));
  EXPECT_THAT(complaint_about({one, root}, out), HasSubstr("it has no part.json"));
  fs::copy(one, root / "a", fs::copy_options::recursive);
  plant(root / "a", "\"program\": \"", "\"program\": \"9.9 of ");
  EXPECT_THAT(complaint_about({root / "a", two}, out), HasSubstr("they were computed by 9.9 of "));
  fs::copy(one, root / "b", fs::copy_options::recursive);
  plant(root / "b", "\"seed\": 1", "\"seed\": 2");
  EXPECT_THAT(complaint_about({root / "b", two}, out), HasSubstr("their options are"));
  fs::copy(two, root / "c", fs::copy_options::recursive);
  plant(root / "c", "\"part\"", "\"prat\"");
  EXPECT_THAT(complaint_about({one, root / "c"}, out), HasSubstr("part.json is damaged"));
  EXPECT_EQ(complaint_about({one, two}, out), "");
  EXPECT_FALSE(fs::exists(out / "failures.csv"));
}

TEST(Parts, WithTimesOfDifferentMachinesAreRefused) {
  const TemporaryDirectory folder;
  const fs::path& root = folder.path();
  copy_two_parts(root);
  for (const char* part : {"1", "2"})  // as if it compared times
    plant(root / part, "\"experiment\": \"failures\"", "\"experiment\": \"regimes\"");
  plant(root / "2", "\"cpu\": \"", "\"cpu\": \"another ");
  EXPECT_THAT(complaint_about({root / "1", root / "2"}, root / "merged"),
              HasSubstr("their times are of different machines, "));
}

}  // namespace
}  // namespace mss

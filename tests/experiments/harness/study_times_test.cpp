// What `mss reproduce` says about its time.
#include "experiments/harness/study_times.hpp"

#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/io/output.hpp"

namespace mss {
namespace {

namespace fs = std::filesystem;

TEST(StudyTimes, AreThoseOfTheStudies) {
  EXPECT_EQ(study_times().size(), experiments().size());
  for (const ExperimentInfo& info : experiments()) {
    EXPECT_GT(expected_seconds(info.name, true), 0) << info.name;
    EXPECT_GT(expected_seconds(info.name, false), expected_seconds(info.name, true)) << info.name;
  }
  EXPECT_EQ(expected_seconds("a study of tomorrow", true), 0);
}

TEST(StudyTimes, OfAFileMustBeSeconds) {
  const fs::path file = fs::path(::testing::TempDir()) / "mss_study_times.csv";
  EXPECT_TRUE(read_study_times(file).empty());
  write_atomically(file, "study,quick,full,machine\nenergy,10,103.5,a processor\n");
  EXPECT_EQ(read_study_times(file).at(0).full, 103.5);
  EXPECT_EQ(read_study_times(file).at(0).machine, "a processor");
  write_atomically(file, "study,quick,full,machine\nshape,9,99,a processor\nenergy,10,,a processor\n");
  EXPECT_THROW(read_study_times(file), InputError);
  write_atomically(file, "study,quick,full,machine\nenergy,10\n");
  EXPECT_THROW(read_study_times(file), InputError);
  fs::remove(file);
}

TEST(StudyTimes, AreSaidInWords) {
  EXPECT_EQ(duration_text(0.4), "0 s");
  EXPECT_EQ(duration_text(99.4), "99 s");
  EXPECT_EQ(duration_text(99.6), "2 min");
  EXPECT_EQ(duration_text(99 * 60), "99 min");
  EXPECT_EQ(duration_text(112 * 60), "1 h 52 min");
}

TEST(StudyClock, SaysBeforeAndAfterEachStudyHowLongItTakes) {
  const std::vector<std::string> names{"timing", "energy", "volume"};
  const auto sum = [&](bool quick) {
    double seconds = 0;
    for (const std::string& name : names) seconds += expected_seconds(name, quick);
    return duration_text(seconds);
  };
  StudyClock clock(names, false);
  EXPECT_TRUE(clock.announcement().starts_with("3 studies, about " + sum(false) + " on two cores"));
  EXPECT_TRUE(clock.announcement().ends_with("; with --quick about " + sum(true)));
  EXPECT_TRUE(StudyClock(names, true).announcement().ends_with("; without --quick about " + sum(false)));
  EXPECT_EQ(clock.comparison(), ": about " + sum(true) + " on two cores instead of " + sum(false));
  const double first = expected_seconds("timing", false), second = expected_seconds("energy", false),
               third = expected_seconds("volume", false);
  // A machine on which all takes twice as long, then the second study takes no time.
  EXPECT_EQ(clock.finished(2 * first), "1 of 3 done in " + duration_text(2 * first) + ", about " +
                                           duration_text(2 * (second + third)) + " left");
  EXPECT_EQ(clock.finished(0), "2 of 3 done in " + duration_text(2 * first) + ", about " +
                                   duration_text(third * 2 * first / (first + second)) + " left");
  EXPECT_EQ(clock.finished(1000), "3 of 3 done in " + duration_text(2 * first + 1000));
}

TEST(StudyClock, TakesStudiesWithoutATimeForNothing) {
  StudyClock clock({"a study of tomorrow", "energy"}, true);
  EXPECT_EQ(clock.finished(5),
            "1 of 2 done in 5 s, about " + duration_text(expected_seconds("energy", true)) + " left");
  EXPECT_EQ(StudyClock({"a study of tomorrow"}, true).comparison(), "");
}

}  // namespace
}  // namespace mss

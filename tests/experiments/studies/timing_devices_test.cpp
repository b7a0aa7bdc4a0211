// `mss timing --devices`: what it judges and concludes; and its rows, where a device is.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "core/base/error.hpp"
#include "core/springs/spring_system.hpp"
#include "experiments/studies/timing/devices.hpp"
#include "experiments/studies/timing/timing.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::timing {
namespace {

/// Particles that all move a metre, but the last, which ends so far from there.
double error_of_one_stray(double stray) {
  const Body body(timing_cube(2));
  const SpringSystem<double> system(body, {});
  const State<double> start = system.rest_state();
  State<double> expected = start;
  for (const std::ptrdiff_t site : body.sites()) expected.x.set(site, start.x.at(site) + Vec3(0, 1, 0));
  State<double> found = expected;
  found.x.set(body.sites().back(), found.x.at(body.sites().back()) + Vec3(0, 0, stray));
  return error_over_motion(body, start, expected, found);
}

TEST(DevicesTiming, JudgesTheWorstParticle) {
  EXPECT_EQ(error_of_one_stray(0), 0);
  EXPECT_NEAR(error_of_one_stray(1e-3), 1e-3, 1e-15);
  EXPECT_FALSE(is_right(error_of_one_stray(1e-3), true));
  EXPECT_TRUE(is_right(error_of_one_stray(1e-5), true));
  EXPECT_FALSE(is_right(error_of_one_stray(1e-5), false));
  EXPECT_TRUE(is_right(error_of_one_stray(1e-12), false));
  for (const double none : {std::nan(""), HUGE_VAL}) {
    EXPECT_TRUE(std::isnan(error_of_one_stray(none)));
    EXPECT_FALSE(is_right(error_of_one_stray(none), true));
  }
}

/// Beside two threads that take 1e-8 n^3 s, a device that takes a n s; of NaN, a wrong one.
Table rows_of_device(const std::vector<int>& cells, double a, int threads = 2) {
  Table rows({{"device"},
              {"solve_device"},
              {"precision"},
              {"threads"},
              {"method"},
              {"cells"},
              {"springs"},
              {"seconds_per_step"},
              {"q1"},
              {"q3"},
              {"status"}});
  for (const int n : cells) {
    const std::int64_t springs = 13LL * n * n * n;
    const auto add = [&](const char* device, const char* choice, int count, double s) {
      rows.add({device, choice, "single", count, "semi_implicit_euler", n, springs, s, s, s,
                std::isnan(s) ? wrong_motion : "ok"});
    };
    add("processor", "cpu", threads, 1e-8 * n * n * n);
    add("a card", "gpu:1", 0, a * n);
  }
  return rows;
}

TEST(DevicesTiming, FindsTheSizeFromWhichADeviceIsFaster) {
  const Table crossing = devices_summary(rows_of_device({10, 20, 50, 100}, 1e-5));
  ASSERT_EQ(crossing.size(), 1U);
  EXPECT_EQ(crossing.text(0, "device"), "a card");
  EXPECT_NEAR(crossing.number(0, "faster_from_cells"), std::sqrt(1e3), 1e-9);  // 1e-5 n = 1e-8 n^3
  EXPECT_EQ(crossing.text(0, "how"), "interpolated");
  EXPECT_NEAR(crossing.number(0, "springs_per_second"), 13e6 / 1e-3, 1);
  EXPECT_EQ(crossing.number(0, "at_cells"), 100);
  const Table always = devices_summary(rows_of_device({10, 20}, 1e-8));
  EXPECT_EQ(always.number(0, "faster_from_cells"), 10);
  EXPECT_EQ(always.text(0, "how"), "every size");
}

TEST(DevicesTiming, SaysWhyNoSizeIsKnown) {
  const auto how = [](const Table& summary) {
    EXPECT_TRUE(std::isnan(summary.number(0, "faster_from_cells")));
    EXPECT_EQ(summary.text(0, "status"), summary.text(0, "how"));
    return summary.text(0, "how");
  };
  EXPECT_EQ(how(devices_summary(rows_of_device({10, 20}, 1e-5))), "not at the largest size timed on both");
  EXPECT_EQ(how(devices_summary(rows_of_device({50}, 1e-5, 1))), "two threads were not timed");
  EXPECT_EQ(how(devices_summary(rows_of_device({50}, 1e-5), 0.5)),
            "withheld: other work took 50 % of the cores");
  const Table wrong = rows_of_device({50}, std::nan(""));
  EXPECT_EQ(how(devices_summary(wrong)), "no size was timed on both");
  EXPECT_NE(devices_text(wrong, devices_summary(wrong)).find("n = 50: wrong, so it has no time"),
            std::string::npos);
}

TEST(DevicesTiming, CountsTheLeastBytesOfAStep) {
  EXPECT_EQ(least_bytes_per_step(1, true), 52);  // 12 numbers and a kind
  EXPECT_EQ(least_bytes_per_step(1, false), 100);
}

/// The device that is there, or why there is none.
std::optional<TimedDevice> first_device(std::string& why) {
  try {
    return timed_devices().front();
  } catch (const InputError& error) {
    why = error.what();
    return std::nullopt;
  }
}

TEST(DevicesTiming, FindsTheLargestCube) {
  std::string why;
  const auto device = first_device(why);
  if (!device) GTEST_SKIP() << why;
  EXPECT_EQ(largest_cube_on(*device, 3, 3), 3);
  EXPECT_EQ(largest_cube_on(*device, 3, 11), 11);  // fits on all
  EXPECT_GT(copy_bandwidth(*device), 1e6);
}

/// Small cubes of the device that is there, on which rows are judged, not times.
TEST(DevicesTiming, TimesWhatComputesTheSameMotion) {
  std::string why;
  if (!first_device(why)) GTEST_SKIP() << why;
  Progress silent;
  const ExperimentInfo& info = find_experiment("timing");
  const ExperimentResult result = info.run({.quick = true, .threads = 1, .devices = true}, silent);
  EXPECT_EQ(result.status, Status::ok);
  const Table& rows = find_table(result.tables, "devices");
  int on_device = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    EXPECT_EQ(rows.text(r, "status"), "ok") << r;
    EXPECT_TRUE(is_right(rows.number(r, "error"), rows.text(r, "precision") == "single")) << r;
    EXPECT_GT(rows.number(r, "seconds_per_step"), 0);
    EXPECT_NEAR(rows.number(r, "springs_per_second") * rows.number(r, "seconds_per_step"),
                rows.number(r, "springs"), 1e-6 * rows.number(r, "springs"));
    EXPECT_GT(rows.number(r, "share_of_bandwidth"), 0);
    if (rows.text(r, "solve_device") == "cpu") continue;
    ++on_device;
    EXPECT_EQ(rows.number(r, "threads"), 0);
    EXPECT_GT(rows.number(r, "carry_seconds"), 0);
    EXPECT_GT(rows.number(r, "error"), 0);  // its sums have another order
  }
  EXPECT_GE(on_device, 6);  // two precisions of two sizes, and of another method
  EXPECT_TRUE(result.configuration["faster_than_two_threads_from"].is_array());
  expect_same_drawings(info, result.tables);
}

}  // namespace
}  // namespace mss::studies::timing

// `mss stability atlas`: fates that are known beforehand, boundaries where they are predicted, and the same
// tables however the work is split.
#include "experiments/studies/atlas/atlas.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "tests/experiments/stop_after.hpp"

namespace mss::studies::atlas {
namespace {

namespace fs = std::filesystem;

AtlasConfig small_atlas(const std::vector<std::string>& integrators) {
  AtlasConfig config = atlas_config({.quick = true, .integrators = integrators});
  std::erase_if(config.planes, [](const AtlasPlane& plane) { return plane.name != "ratio"; });
  config.planes[0].values = {0, 0.1, 0.5};
  config.planes[0].set = [](AtlasBody& body, double value) {
    body.cells = 2;
    body.ratio = value;
  };
  config.finest = 1;
  return config;
}

AtlasTables run(const AtlasConfig& config, int processes) {
  Journal journal;
  Progress progress;
  return measure_atlas(config, processes, journal, progress);
}

/// The fates of one method and damping, by dt omega_max.
std::map<double, std::string> fates(const Table& points, const std::string& integrator, double ratio) {
  std::map<double, std::string> out;
  for (std::size_t r = 0; r < points.size(); ++r)
    if (points.text(r, "integrator") == integrator && points.number(r, "ratio") == ratio)
      out[points.number(r, "dt_omega")] = points.text(r, "status");
  return out;
}

TEST(Atlas, ExplicitMethodsBlowUpWherePredicted) {
  const AtlasTables tables =
      run(small_atlas({"semi_implicit_euler", "verlet", "velocity_verlet", "damped_verlet", "rk4"}), 2);
  ASSERT_EQ(tables.limits.size(), 5U * 3);
  for (std::size_t r = 0; r < tables.limits.size(); ++r) {
    const std::string name = tables.limits.text(r, "integrator");
    SCOPED_TRACE(name + ", row " + std::to_string(r));
    double largest = 0;
    for (const auto& [step, fate] : fates(tables.points, name, tables.limits.number(r, "value")))
      if (fate != "blows_up") largest = std::max(largest, step);
    const double octaves = std::log2(largest / tables.limits.number(r, "predicted"));
    EXPECT_GT(octaves, -1.3 / octave_parts);
    EXPECT_LT(octaves, 0.3 / octave_parts);
  }
}

TEST(Atlas, FailuresHaveTheirNames) {
  const AtlasTables tables =
      run(small_atlas({"explicit_euler", "rk4", "backward_euler", "implicit_midpoint", "cvode_adams"}), 2);
  EXPECT_GE(fates(tables.points, "explicit_euler", 0).size(), 5U);
  for (const auto& [step, fate] : fates(tables.points, "explicit_euler", 0))
    EXPECT_TRUE(step < 0.1 || fate == "blows_up") << step;
  const auto backward = fates(tables.points, "backward_euler", 0);
  EXPECT_EQ(backward.at(4), "loses_energy");
  // Within the stability limit too: near it Runge and Kutta's method damps what it does not resolve.
  const auto rk4 = fates(tables.points, "rk4", 0);
  EXPECT_EQ(rk4.at(0.25), "holds");
  EXPECT_EQ(rk4.at(2), "loses_energy");
  EXPECT_GE(fates(tables.points, "implicit_midpoint", 0).size(), 5U);
  for (const auto& [step, fate] : fates(tables.points, "implicit_midpoint", 0))
    EXPECT_EQ(fate, "holds") << step;
  const auto adams = fates(tables.points, "cvode_adams", 0);
  EXPECT_EQ(adams.at(0.5), "holds");
  EXPECT_EQ(adams.at(512), "too_many_steps");
}

TEST(Atlas, TheCompressedCubeFolds) {
  AtlasConfig config = small_atlas({"verlet"});
  config.planes[0].name = "strain";
  config.planes[0].values = {-0.95, 0.01};
  config.planes[0].set = [](AtlasBody& body, double value) { body.strain = value; };
  const Table points = run(config, 1).points;
  int judged = 0;
  for (std::size_t r = 0; r < points.size(); ++r) {
    const bool folds = points.number(r, "strain") == -0.95 && points.number(r, "dt_omega") <= 0.25;
    const bool holds = points.number(r, "strain") == 0.01 && points.number(r, "dt_omega") <= 1;
    if (folds || holds) {
      ++judged;
      EXPECT_EQ(points.text(r, "status"), folds ? "folds" : "holds");
    }
  }
  EXPECT_GE(judged, 5);
}

TEST(Atlas, MoreRowsWhereFatesChange) {
  AtlasConfig config = small_atlas({"verlet"});
  config.planes[0].halvings = 2;
  const AtlasPlane& plane = config.planes[0];
  EXPECT_EQ(plane.levels(), 8);
  EXPECT_EQ(plane.value(8), 0.5);
  EXPECT_DOUBLE_EQ(plane.value(1), 0.025);
  EXPECT_DOUBLE_EQ(plane.value(6), 0.3);
  const AtlasTables tables = run(config, 2);
  // The limit falls by a fifth from 0 to 0.1, by more than an octave's half from there to 0.5.
  bool between_first = false, between_last = false;
  for (std::size_t r = 0; r < tables.limits.size(); ++r) {
    const double value = tables.limits.number(r, "value");
    between_first |= value > 0 && value < 0.1;
    between_last |= value > 0.1 && value < 0.5;
  }
  EXPECT_FALSE(between_first);
  EXPECT_TRUE(between_last);
}

TEST(Atlas, IsTheSameHoweverItIsSplitAndInterrupted) {
  const AtlasConfig config = small_atlas({"verlet", "backward_euler_linear"});
  const AtlasTables whole = run(config, 1);
  EXPECT_EQ(whole.status, Status::ok);
  for (const int processes : {2, 4}) {
    const AtlasTables split = run(config, processes);
    EXPECT_EQ(split.points.csv(), whole.points.csv());
    EXPECT_EQ(split.limits.csv(), whole.limits.csv());
  }
  const fs::path file = fs::temp_directory_path() / ("mss-atlas-test-" + std::to_string(getpid()));
  const Json what{{"test", 1}};
  for (const int answers : {2, 9, 20}) {
    Journal journal(file, what);
    StopAfter progress(answers);
    const AtlasTables part = measure_atlas(config, 2, journal, progress);
    EXPECT_EQ(part.status, Status::interrupted);
    EXPECT_LT(part.points.size(), whole.points.size());
  }
  Journal journal(file, what);
  EXPECT_GE(journal.size(), 31U);
  Progress progress;
  EXPECT_EQ(measure_atlas(config, 4, journal, progress).points.csv(), whole.points.csv());
  fs::remove(file);
}

}  // namespace
}  // namespace mss::studies::atlas

// `mss stability atlas`: known outcomes, boundaries where they are predicted, and the same tables however the
// work is split.
#include "experiments/studies/atlas/atlas.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "tests/experiments/stop_after.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::atlas {
namespace {

namespace fs = std::filesystem;

AtlasConfig small_atlas(const std::vector<std::string>& integrators) {
  AtlasConfig config = atlas_config({.quick = true, .integrators = integrators});
  std::erase_if(config.parameters, [](const AtlasParameter& parameter) { return parameter.name != "ratio"; });
  config.parameters[0].values = {0, 0.1, 0.5};
  config.parameters[0].set = [](AtlasBody& body, double value) {
    body.cells = 2;
    body.ratio = value;
  };
  config.finest = 1;
  config.finest_without_limit = octave_parts / 4;
  return config;
}

AtlasTables run(const AtlasConfig& config, int processes) {
  Journal journal;
  Progress progress;
  return measure_atlas(config, processes, journal, progress);
}

/// The outcomes of one method and damping, by dt omega_max.
std::map<double, std::string> outcomes(const Table& points, const std::string& integrator, double ratio) {
  std::map<double, std::string> out;
  for (std::size_t r = 0; r < points.size(); ++r)
    if (points.text(r, "integrator") == integrator && points.number(r, "ratio") == ratio)
      out[points.number(r, "dt_omega")] = points.text(r, "status");
  return out;
}

/// Undamped central differences of a motion of finite size, here 1 percent, take up energy at 1.915 by a
/// resonance with the step, short of their limit, 2; at a tenth of the size they do not.
bool resonates(const std::string& integrator, double ratio) {
  return ratio == 0 && integrator != "rk4" && integrator != "explicit_euler";
}

// Bisected to 1/32 octave: to 1.1 percent on either side. Explicit Euler grows slowly just beyond its limit.
TEST(Atlas, ExplicitMethodsBlowUpWherePredicted) {
  const AtlasTables tables = run(small_atlas({"explicit_euler", "semi_implicit_euler", "verlet",
                                              "velocity_verlet", "damped_verlet", "rk4"}),
                                 2);
  ASSERT_EQ(tables.limits.size(), 6U * 3);
  for (std::size_t r = 0; r < tables.limits.size(); ++r) {
    const std::string name = tables.limits.text(r, "integrator");
    SCOPED_TRACE(name + ", row " + std::to_string(r));
    if (name == "explicit_euler" && tables.limits.number(r, "value") == 0) continue;  // at no step
    ASSERT_EQ(tables.limits.text(r, "status"), "ok");
    const double expected = resonates(name, tables.limits.number(r, "value")) ? 1.915 / 2 : 1;
    EXPECT_NEAR(tables.limits.number(r, "limit_over_predicted"), expected,
                name == "explicit_euler" ? 0.05 : 0.015);
  }
}

TEST(Atlas, UndampedExplicitEulerIsStableAtNoStep) {
  const AtlasTables tables = run(small_atlas({"explicit_euler"}), 2);
  const auto found = outcomes(tables.points, "explicit_euler", 0);
  EXPECT_GE(found.size(), 4U);
  EXPECT_LT(found.begin()->first, 0.07);
  for (const auto& [step, outcome] : found) EXPECT_EQ(outcome, "blows_up") << step;
  EXPECT_EQ(tables.limits.text(0, "status"), "stable at no step tried");
  EXPECT_TRUE(std::isnan(tables.limits.number(0, "stable_to")));
}

// Steps of many periods: nothing is left. Undamped, all should be; damped, the reference has lost all but a
// rounding error in the longest steps.
TEST(Atlas, BackwardEulerLosesEnergyAtEveryLongStep) {
  const Table points = run(small_atlas({"backward_euler_linear"}), 2).points;
  for (const auto& [ratio, last] : {std::pair(0.0, 128.0), std::pair(0.1, 32.0)}) {
    const auto found = outcomes(points, "backward_euler_linear", ratio);
    EXPECT_GE(found.rbegin()->first, 64);
    for (const auto& [step, outcome] : found)
      if (step >= 1 && step <= last) {
        EXPECT_EQ(outcome, "loses_energy") << ratio << ", " << step;
      }
  }
}

TEST(Atlas, MethodsThatChooseTheirStepsAreMappedWhereTheyAreNamed) {
  const std::vector<std::string> usual = atlas_config({}).integrators,
                                 named = atlas_config({.integrators = {"cvode_adams"}}).integrators;
  EXPECT_EQ(std::count(usual.begin(), usual.end(), "semi_implicit_euler"), 1);
  EXPECT_EQ(std::count_if(usual.begin(), usual.end(), chooses_its_steps), 0);
  EXPECT_EQ(named, std::vector<std::string>{"cvode_adams"});
}

TEST(Atlas, FailuresHaveTheirNames) {
  const AtlasTables tables =
      run(small_atlas({"rk4", "backward_euler", "implicit_midpoint", "cvode_adams"}), 2);
  const auto backward = outcomes(tables.points, "backward_euler", 0);
  EXPECT_EQ(backward.at(4), "loses_energy");
  // Within the stability limit too: near it Runge and Kutta's method damps what it does not resolve.
  const auto rk4 = outcomes(tables.points, "rk4", 0);
  EXPECT_EQ(rk4.at(0.25), "stable");
  EXPECT_EQ(rk4.at(2), "loses_energy");
  EXPECT_GE(outcomes(tables.points, "implicit_midpoint", 0).size(), 4U);
  for (const auto& [step, outcome] : outcomes(tables.points, "implicit_midpoint", 0))
    EXPECT_EQ(outcome, "stable") << step;
  const auto adams = outcomes(tables.points, "cvode_adams", 0);
  EXPECT_EQ(adams.at(0.5), "stable");
  EXPECT_EQ(adams.at(512), "too_many_steps");
}

TEST(Atlas, MethodsForAnyStepAreTriedAtLongOnes) {
  const AtlasTables tables = run(small_atlas({"xpbd", "vbd:5"}), 2);
  for (const char* method : {"xpbd", "vbd:5"}) {
    const auto found = outcomes(tables.points, method, 0);
    EXPECT_GE(found.rbegin()->first, 64) << method;
    EXPECT_EQ(found.at(1), "loses_energy") << method;
    for (const auto& [step, outcome] : found)
      EXPECT_TRUE(outcome == "stable" || outcome == "loses_energy") << method << " " << step;
  }
}

TEST(Atlas, AMethodWithoutAStepForABodyRefuses) {
  AtlasConfig config = small_atlas({"xpbd"});
  config.parameters[0].set = [](AtlasBody& body, double) {
    body.cells = 2;
    body.poisson = 0.1;
  };
  const auto found = outcomes(run(config, 1).points, "xpbd", AtlasBody{}.ratio);
  ASSERT_FALSE(found.empty());
  for (const auto& [step, outcome] : found) EXPECT_EQ(outcome, "refused") << step;
}

TEST(Atlas, TheCompressedCubeFolds) {
  AtlasConfig config = small_atlas({"verlet"});
  config.parameters[0].name = "strain";
  config.parameters[0].values = {-0.95, 0.01};
  config.parameters[0].set = [](AtlasBody& body, double value) { body.strain = value; };
  const Table points = run(config, 1).points;
  int compared = 0;
  for (std::size_t r = 0; r < points.size(); ++r) {
    const bool folds = points.number(r, "strain") == -0.95 && points.number(r, "dt_omega") <= 0.25;
    const bool stable = points.number(r, "strain") == 0.01 && points.number(r, "dt_omega") <= 1;
    if (folds || stable) {
      ++compared;
      EXPECT_EQ(points.text(r, "status"), folds ? "folds" : "stable");
    }
  }
  EXPECT_GE(compared, 5);
}

TEST(Atlas, MoreRowsWhereTheOutcomeChanges) {
  AtlasConfig config = small_atlas({"verlet"});
  config.parameters[0].halvings = 2;
  const AtlasParameter& parameter = config.parameters[0];
  EXPECT_EQ(parameter.levels(), 8);
  EXPECT_EQ(parameter.value(8), 0.5);
  EXPECT_DOUBLE_EQ(parameter.value(1), 0.025);
  EXPECT_DOUBLE_EQ(parameter.value(6), 0.3);
  const AtlasTables tables = run(config, 2);
  // The limit falls by a fifth from 0 to 0.1, by more than an octave's half from there to 0.5. Undamped
  // motion gains energy just below it, so that rows differ near the first.
  bool between_middle = false, between_last = false;
  for (std::size_t r = 0; r < tables.limits.size(); ++r) {
    const double value = tables.limits.number(r, "value");
    between_middle |= value > 0.05 && value < 0.1;
    between_last |= value > 0.1 && value < 0.5;
  }
  EXPECT_FALSE(between_middle);
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
  for (const int results : {2, 9, 20}) {
    Journal journal(file, what);
    StopAfter progress(results);
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

TEST(Atlas, DrawsTheSameFromItsFiles) {
  expect_same_drawings(find_experiment("atlas"),
                       atlas_files(run(small_atlas({"explicit_euler", "backward_euler"}), 2)));
}

TEST(Atlas, DrawsWhatAnInterruptedRunHas) {
  const AtlasConfig config = small_atlas({"verlet", "backward_euler_linear"});
  Journal journal;
  StopAfter progress(12);
  AtlasTables part = measure_atlas(config, 2, journal, progress);
  EXPECT_EQ(part.status, Status::interrupted);
  EXPECT_GT(part.points.size(), 0U);
  expect_same_drawings(find_experiment("atlas"), atlas_files(std::move(part)));
  Journal nothing;
  StopAfter at_once(0);
  const Drawings drawings = draw_atlas(atlas_files(measure_atlas(config, 2, nothing, at_once)));
  ASSERT_EQ(drawings.maps.size(), 1U);
  EXPECT_FALSE(has_cells(drawings.maps[0].chart));
}

}  // namespace
}  // namespace mss::studies::atlas

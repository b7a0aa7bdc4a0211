// `mss stability`: that steps found by bisection are those predicted, and that failures have names.
#include "experiments/studies/stability/stability.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "core/spring_system.hpp"
#include "experiments/simulation/cubes.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::stability {
namespace {

StabilityConfig small_config() {
  StabilityConfig config = stability_config({.quick = true});
  config.cells = {2, 3};
  config.ratios = {0, 1};
  return config;
}

TEST(Stability, MeasuredStepsAreThosePredicted) {
  Progress progress;
  const StabilityConfig config = small_config();
  const StabilityTables tables = measure_stability(config, progress);
  ASSERT_EQ(tables.status, Status::ok);
  const Table& rows = tables.rows;
  ASSERT_EQ(rows.size(), 2 * 2 * config.integrators.size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::string name = rows.text(r, "integrator");
    SCOPED_TRACE(name + ", row " + std::to_string(r));
    EXPECT_LE(rows.number(r, "guaranteed"), rows.number(r, "predicted"));
    if (name == "explicit_euler" && rows.number(r, "ratio") == 0) {
      EXPECT_EQ(rows.text(r, "status"), "no step is stable");
      EXPECT_EQ(rows.number(r, "predicted"), 0);
      EXPECT_TRUE(std::isnan(rows.number(r, "measured")));
      continue;
    }
    ASSERT_EQ(rows.text(r, "status"), "ok");
    EXPECT_NEAR(rows.number(r, "measured_over_predicted"), 1, 0.005);
    EXPECT_GT(rows.number(r, "real_time_factor"), 0);
  }
}

TEST(Stability, DrawsFromItsFiles) {
  StabilityConfig config = small_config();
  config.cells = {2};
  config.integrators = {"explicit_euler", "verlet", "velocity_verlet"};
  Progress progress;
  const StabilityTables tables = measure_stability(config, progress);
  expect_same_drawings(find_experiment("stability"), stability_files(config, tables.rows));
}

// A poor guess costs time only.
TEST(Stability, BisectionDoesNotNeedAGoodGuess) {
  const StabilityConfig config = small_config();
  const Body body(unit_cube({.young = config.young, .poisson = config.poisson}, config.density, 2, 0.5));
  SpringSystem<double> system(body, {}, {.threads = 1});
  const IntegratorInfo& verlet = find_integrator("verlet");
  const MeasuredStep good = measure_step(config, verlet, system, 0.1);
  ASSERT_GT(good.stable, 0);
  EXPECT_LE(good.unstable, good.stable * (1 + config.resolution));
  for (const double factor : {0.06, 15.0}) {
    const MeasuredStep other = measure_step(config, verlet, system, factor * good.stable);
    EXPECT_NEAR(other.stable / good.stable, 1, 2 * config.resolution) << factor;
  }
}

TEST(Stability, ComparesMethodsWithALimitOnly) {
  const StabilityConfig all = stability_config({});
  EXPECT_GE(all.integrators.size(), 6U);
  for (const std::string& name : all.integrators) EXPECT_TRUE(find_integrator(name).limit) << name;
  EXPECT_THROW(stability_config({.integrators = {"backward_euler"}}), InputError);
}

}  // namespace
}  // namespace mss::studies::stability

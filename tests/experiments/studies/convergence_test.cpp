// `mss convergence`: every solver tends to the same minimum, and free bodies keep their momentum on the way.
#include "experiments/studies/convergence/convergence.hpp"

#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::convergence {
namespace {

ConvergenceConfig small_config() {
  ConvergenceConfig config = convergence_config({.quick = true, .cells = {3}});
  config.dt_omega = {30};
  config.iterations = {1, 50};
  return config;
}

TEST(Convergence, EverySolverTendsToTheSameMinimum) {
  ConvergenceConfig config = small_config();
  config.starts = {"crushed", "heavy_corner"};
  Progress progress;
  const ConvergenceTables tables = measure_convergence(config, progress);
  ASSERT_EQ(tables.status, Status::ok);
  ASSERT_EQ(tables.rows.size(), 4 * config.solvers.size());
  for (std::size_t r = 0; r < tables.rows.size(); ++r) {
    const std::string& solver = tables.rows.text(r, "solver");
    if (tables.rows.number(r, "iterations") != 50 || solver == "projective" || solver == "xpbd") continue;
    EXPECT_LT(tables.rows.number(r, "gap"), solver == "vbd" ? 0.01 : 1e-4) << solver;
    EXPECT_LT(tables.rows.number(r, "residual"), solver == "vbd" ? 0.1 : 0.02) << solver;
  }
}

TEST(Convergence, ConstantMatricesKeepTheMomentumInEveryIteration) {
  ConvergenceConfig config = small_config();
  config.starts = {"twisted"};
  config.solvers = {{"projective", ""}, {"lbfgs", ""}};
  config.iterations = {1, 2, 5};
  Progress progress;
  const Table rows = measure_convergence(config, progress).rows;
  ASSERT_EQ(rows.size(), 6U);
  for (std::size_t r = 0; r < rows.size(); ++r)
    EXPECT_LT(rows.number(r, "momentum_change"), 1e-11) << rows.text(r, "solver");
}

TEST(Convergence, XpbdKeepsTheMomentumAndVbdDoesNot) {
  ConvergenceConfig config = small_config();
  config.starts = {"twisted"};
  config.solvers = {{.method = "xpbd"}, {.method = "vbd"}};
  config.iterations = {1, 300};
  Progress progress;
  const Table rows = measure_convergence(config, progress).rows;
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_LT(rows.number(0, "momentum_change"), 1e-14);
  EXPECT_LT(rows.number(1, "momentum_change"), 1e-14);
  EXPECT_GT(rows.number(2, "momentum_change"), 1e-4);
  EXPECT_LT(rows.number(3, "momentum_change"), rows.number(2, "momentum_change") / 10);
}

TEST(Convergence, SummarySaysFromWhereOnTheGapStaysSmall) {
  Table rows({{"start"}, {"dt_omega"}, {"solver"}, {"iterations"}, {"seconds", "s"}, {"gap"}, {"status"}});
  const auto add = [&](int iterations, double gap) {
    rows.add({std::string("twisted"), 30.0, std::string("lbfgs"), iterations, 1e-3 * iterations, gap,
              std::string("ok")});
  };
  add(1, 0.005);
  add(2, 0.5);
  add(5, 0.009);
  add(10, 1e-5);
  const Table summary = convergence_summary(rows);
  ASSERT_EQ(summary.size(), 1U);
  EXPECT_EQ(summary.number(0, "iterations"), 5);
  EXPECT_EQ(summary.number(0, "seconds"), 5e-3);
  EXPECT_EQ(summary.text(0, "status"), "ok");
  add(20, 0.2);
  EXPECT_EQ(convergence_summary(rows).text(0, "status"), "gap above 1 percent after 20 iterations");
}

TEST(Convergence, DrawsFromItsFiles) {
  ConvergenceConfig config = small_config();
  config.starts = {"twisted"};
  config.dt_omega = {300};
  Progress progress;
  expect_same_drawings(find_experiment("convergence"),
                       convergence_files(config, measure_convergence(config, progress).rows));
}

TEST(Convergence, TakesOneSize) { EXPECT_THROW(convergence_config({.cells = {3, 4}}), InputError); }

}  // namespace
}  // namespace mss::studies::convergence

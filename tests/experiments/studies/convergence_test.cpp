// `mss convergence`: every solver tends to the same minimum, and free bodies keep their momentum on the way.
#include "experiments/studies/convergence/convergence.hpp"

#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "experiments/studies/convergence/scenes.hpp"
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

StepsConfig small_steps() {
  StepsConfig config = steps_config({.quick = true});
  config.bodies.scenes = {StepBody{"missing_corner", 3}.scene(), StepBody{"ball", 4, 0.45}.scene()};
  config.scenes.scenes.clear();
  config.frames = 3;
  config.rounds = 2;
  return config;
}

TEST(ConvergenceSteps, BodiesComeToTheConvergedStepThatNewtonFindsToo) {
  Progress progress;
  const StepTables tables = measure_steps(small_steps(), progress);
  ASSERT_EQ(tables.status, Status::ok);
  ASSERT_EQ(tables.references.size(), 2U);
  for (std::size_t r = 0; r < 2; ++r) {
    EXPECT_EQ(tables.references.text(r, "status"), "ok");
    EXPECT_LT(tables.references.number(r, "uncertainty"), 1e-7);
    EXPECT_EQ(tables.references.number(r, "frames"), 3);
  }
  ASSERT_EQ(tables.bodies.size(), 8U);  // by projective, lbfgs and both conjugate gradients
  for (std::size_t r = 0; r < 8; ++r) {
    const std::string& solver = tables.bodies.text(r, "solver");
    SCOPED_TRACE(tables.bodies.text(r, "scene") + ": " + solver);
    EXPECT_EQ(tables.bodies.number(r, "poisson"), r < 4 ? 0.3 : 0.45);
    EXPECT_GT(tables.bodies.number(r, "application"), 0);
    EXPECT_GT(tables.bodies.number(r, "set_up"), tables.bodies.number(r, "application"));
    if (solver == "projective") continue;
    EXPECT_EQ(tables.bodies.text(r, "status"), "ok");
    const double percent = tables.bodies.number(r, "iterations_to_1_percent"),
                 permille = tables.bodies.number(r, "iterations_to_1_permille");
    EXPECT_GE(percent, 1);
    EXPECT_GE(permille, percent);
    EXPECT_LE(permille, tables.bodies.number(r, "most_to_1_permille"));
  }
  // The mean over frames is that of the first iteration which is near enough: no row before the fewest is.
  const Table lbfgs = tables.rows.where("scene", "missing_corner_3").where("solver", "lbfgs");
  const Table body = tables.bodies.where("scene", "missing_corner_3").where("solver", "lbfgs");
  for (std::size_t r = 0; r < lbfgs.size(); ++r) {
    EXPECT_LE(lbfgs.number(r, "error"), lbfgs.number(r, "worst_error"));
    EXPECT_EQ(lbfgs.number(r, "worst_error") <= 0.01,
              lbfgs.number(r, "iterations") >= body.number(0, "most_to_1_percent"));
  }
}

TEST(ConvergenceSteps, ScenesAreSolvedByEverySolver) {
  StepsConfig config = small_steps();
  config.bodies.scenes.clear();
  config.scenes.scenes = steps_config({.quick = true, .scenes = {"ball_medium"}}).scenes.scenes;
  ASSERT_EQ(config.scenes.scenes.size(), 1U);
  Progress progress;
  const StepTables tables = measure_steps(config, progress);
  EXPECT_EQ(tables.references.text(0, "status"), "ok");
  ASSERT_EQ(tables.scenes.size(), all_solvers().size());
  for (const char* solver : {"newton/cholmod", "lbfgs", "nonlinear_cg"}) {
    const Table row = tables.scenes.where("solver", solver);
    EXPECT_EQ(row.text(0, "status"), "ok") << solver;
    EXPECT_GT(row.number(0, "seconds"), 0);
  }
}

TEST(ConvergenceSteps, AreDrawnFromTheirFiles) {
  StepsConfig config = small_steps();
  config.bodies.scenes = {StepBody{"box", 2}.scene(), StepBody{"l_shape", 3}.scene()};
  config.scenes.scenes = steps_config({.quick = true, .scenes = {"held_box_soft"}}).scenes.scenes;
  config.scenes.solvers = {{.nonlinear = "lbfgs"}};
  Progress progress;
  const StepTables steps = measure_steps(config, progress);
  ConvergenceConfig none = small_config();
  none.starts.clear();
  std::vector<NamedTable> tables = convergence_files(none, measure_convergence(none, progress).rows);
  for (NamedTable& table : step_files(steps)) tables.push_back(std::move(table));
  expect_same_drawings(find_experiment("convergence"), tables);
  const std::vector<NamedChart> charts = step_charts(tables);
  ASSERT_EQ(charts.size(), 2U);
  EXPECT_EQ(charts[0].name, "convergence_bodies_box_2");
  EXPECT_EQ(charts[0].chart.series.size(), 2 * config.bodies.solvers.size());
}

TEST(ConvergenceSteps, TakeTheScenesThatAreNamed) {
  const ExperimentOptions named{.quick = true, .scenes = {"crushed", "ball_20", "slope_soft"}};
  EXPECT_EQ(convergence_config(named).starts, std::vector<std::string>{"crushed"});
  const StepsConfig steps = steps_config(named);
  ASSERT_EQ(steps.bodies.scenes.size(), 1U);
  EXPECT_EQ(steps.bodies.scenes[0].name, "ball_20");
  ASSERT_EQ(steps.scenes.scenes.size(), 1U);
  EXPECT_EQ(steps.scenes.scenes[0].name, "slope_soft");
  EXPECT_THROW(convergence_config({.scenes = {"slope"}}), InputError);
  EXPECT_EQ(steps_config({}).bodies.scenes.size(), 15U);
  EXPECT_EQ(steps_config({}).scenes.scenes.size(), 4U);
}

TEST(Convergence, TakesOneSize) { EXPECT_THROW(convergence_config({.cells = {3, 4}}), InputError); }

}  // namespace
}  // namespace mss::studies::convergence

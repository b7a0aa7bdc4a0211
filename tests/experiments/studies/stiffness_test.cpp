// `mss stiffness`: all methods reach the same state, and crossings are found where they are.
#include "experiments/studies/stiffness/stiffness.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "integrators/linear/linear_solver.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::stiffness {
namespace {

/// All but `automatic`, which is one of the others, and `separable`, which takes springs only.
const std::size_t solvers = linear_solvers().size() - 2;

TEST(Stiffness, AllMethodsReachTheSameState) {
  StiffnessConfig config = stiffness_config({.quick = true});
  config.cells = {2};
  config.young = {1e5, 1e8};
  config.repetitions = 1;
  Progress progress;
  const StiffnessTables tables = measure_stiffness(config, progress);
  ASSERT_EQ(tables.status, Status::ok);
  ASSERT_EQ(tables.rows.size(), 2 * (solvers + 4));
  for (std::size_t r = 0; r < tables.rows.size(); ++r) {
    EXPECT_EQ(tables.rows.text(r, "status"), "ok");
    const bool coarse = tables.rows.text(r, "method") == "damped_verlet";  // a few steps of the safe size
    EXPECT_LT(tables.rows.number(r, "difference"), coarse ? 0.02 : 1e-3) << tables.rows.text(r, "method");
    EXPECT_GT(tables.rows.number(r, "seconds"), 0);
  }
  config.model = "corotational";
  expect_same_drawings(find_experiment("stiffness"), stiffness_files(config, tables.rows));
}

TEST(Stiffness, LeavesKluOutOfLargeBodies) {
  StiffnessConfig config = stiffness_config({.cells = {8}});
  config.young = {1e5};
  config.repetitions = 1;
  Progress progress;
  const StiffnessTables tables = measure_stiffness(config, progress);
  const auto methods = tables.rows.distinct("method");
  EXPECT_EQ(methods.size(), solvers + 3);
  EXPECT_EQ(std::count(methods.begin(), methods.end(), "cvode_bdf_klu"), 0);
}

/// Rows with CHOLMOD at 1 s and GMRES as given, by decades of stiffness.
Table planted(const std::vector<double>& gmres) {
  Table rows({{"method"}, {"cells"}, {"young"}, {"seconds"}, {"q1"}, {"q3"}, {"status"}});
  for (std::size_t i = 0; i < gmres.size(); ++i) {
    const double young = std::pow(10.0, double(i));
    rows.add({std::string("cvode_bdf/cholmod"), 5, young, 1.0, 1.0, 1.0, std::string("ok")});
    rows.add({std::string("cvode_bdf_gmres"), 5, young, gmres[i], gmres[i], gmres[i], std::string("ok")});
  }
  return rows;
}

TEST(StiffnessSummary, FindsTheLastCrossing) {
  EXPECT_NEAR(stiffness_summary(planted({0.1, 0.5, 2, 4})).number(0, "slower_from"), std::sqrt(1000), 1e-9);
  EXPECT_NEAR(stiffness_summary(planted({2, 0.5, 2})).number(0, "slower_from"), std::sqrt(1000), 1e-9);
  EXPECT_EQ(stiffness_summary(planted({2, 3})).number(0, "slower_from"), 0);
  const Table never = stiffness_summary(planted({0.1, 0.2}));
  EXPECT_TRUE(std::isnan(never.number(0, "slower_from")));
  EXPECT_NE(never.text(0, "status"), "ok");
}

LinearSolveConfig small_solves() {
  return {.cells = {2, 6},
          .dt_omega = {charted_dt_omega},
          .poisson_cells = 6,
          .more_poisson = {0.49},
          .repetitions = 1};
}

TEST(LinearSolves, AllSolversSolveEveryCase) {
  const LinearSolveConfig config = small_solves();
  Progress progress;
  const Table rows = measure_linear_solves(config, progress);
  ASSERT_EQ(rows.size(), config.solvers.size() * (2 * 2 * 2 + 1));
  for (std::size_t r = 0; r < rows.size(); ++r) {
    EXPECT_EQ(rows.text(r, "status"), "ok");
    EXPECT_LT(rows.number(r, "residual"), 1.01e-6) << rows.text(r, "solver");
    EXPECT_EQ(rows.number(r, "products") > 0, rows.text(r, "solver") != "cholmod");
    EXPECT_GT(rows.number(r, "repeated_setup_seconds"), 0);
    EXPECT_NEAR(rows.number(r, "seconds"), rows.number(r, "setup_seconds") + rows.number(r, "solve_seconds"),
                1e-12);
  }
  const Table ratios = linear_solve_ratios(rows);
  EXPECT_EQ(ratios.size(), rows.size() - (2 * 2 * 2 + 1));
  EXPECT_EQ(linear_solve_chart(rows).series.size(), config.solvers.size());
}

TEST(LinearSolves, SayWhatIsTooLarge) {
  EXPECT_FALSE(is_too_large("cholmod", 20, false));
  EXPECT_TRUE(is_too_large("cholmod", 40, false));
  EXPECT_TRUE(is_too_large("cholmod", 40, true));
  EXPECT_FALSE(is_too_large("pcg", 40, true));
  LinearSolveConfig config = small_solves();
  config.cells = {41};
  config.poisson = {charted_poisson};
  config.solvers = {"cholmod"};
  Progress progress;
  const Table rows = measure_linear_solves(config, progress);
  EXPECT_GT(rows.size(), 0U);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    EXPECT_EQ(rows.text(r, "status"), "skipped: too large");
    EXPECT_EQ(rows.number(r, "repeats"), 0);
    EXPECT_TRUE(std::isnan(rows.number(r, "seconds")));
  }
}

CrossoverConfig small_crossover() { return {.cells = {2}, .dt_omega = {10, 300}, .repetitions = 1}; }

TEST(Crossover, ComparesTimeAndErrorOfTheSameFrame) {
  Progress progress;
  const Table rows = measure_crossover(small_crossover(), progress);
  ASSERT_EQ(rows.size(), 2U);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    EXPECT_EQ(rows.text(r, "status"), "ok");
    EXPECT_EQ(rows.text(r, "implicit").rfind("backward_euler_linear/", 0), 0U);
    EXPECT_EQ(rows.number(r, "implicit_steps"), 1);
    // A safe step is at most 0.9 times the limit of the undamped oscillator, dt omega = 2.
    EXPECT_GE(rows.number(r, "explicit_steps"), rows.number(r, "dt_omega") / 1.8);
    EXPECT_LT(rows.number(r, "explicit_steps"), rows.number(r, "dt_omega"));
    EXPECT_LT(rows.number(r, "explicit_error"), rows.number(r, "implicit_error"));
    EXPECT_GT(rows.number(r, "ratio"), 0);
  }
  // omega grows as the root of Young's modulus
  EXPECT_NEAR(rows.number(1, "young") / rows.number(0, "young"), 900, 1e-6);
}

TEST(Crossover, IsWhereRatiosBeginToStayAboveOne) {
  Table rows({{"cells"},
              {"dt_omega"},
              {"ratio"},
              {"ratio_q1"},
              {"ratio_q3"},
              {"first_ratio"},
              {"first_ratio_q1"},
              {"first_ratio_q3"},
              {"status"}});
  for (const auto& [dt_omega, ratio] : {std::pair{10.0, 0.1}, {100.0, 10.0}})
    rows.add({4, dt_omega, ratio, ratio, ratio, ratio / 100, ratio / 100, ratio / 100, "ok"});
  const Table summary = crossover_summary(rows);
  ASSERT_EQ(summary.size(), 2U);
  EXPECT_EQ(summary.text(0, "step"), "later");
  EXPECT_NEAR(summary.number(0, "cheaper_from_dt_omega"), std::sqrt(1000), 1e-9);
  EXPECT_EQ(summary.text(1, "step"), "first");
  EXPECT_TRUE(std::isnan(summary.number(1, "cheaper_from_dt_omega")));
  EXPECT_NE(summary.text(1, "status"), "ok");
  EXPECT_EQ(crossover_chart(rows).series.size(), 2U);
}

TEST(Stiffness, DrawsSolversAndCrossoverFromTheirTables) {
  StiffnessConfig config = stiffness_config({.quick = true});
  config.cells = {2};
  config.young = {1e5};
  config.repetitions = 1;
  Progress progress;
  std::vector<NamedTable> tables = stiffness_files(config, measure_stiffness(config, progress).rows);
  const std::size_t before = find_experiment("stiffness").draw(tables).charts.size();
  tables.push_back({"stiffness_solvers", measure_linear_solves(small_solves(), progress)});
  tables.push_back({"stiffness_crossover", measure_crossover(small_crossover(), progress)});
  EXPECT_EQ(find_experiment("stiffness").draw(tables).charts.size(), before + 2);
  expect_same_drawings(find_experiment("stiffness"), tables);
}

}  // namespace
}  // namespace mss::studies::stiffness

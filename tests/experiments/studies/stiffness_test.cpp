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

TEST(StiffnessChart, MarksWhatFailed) {
  Table rows = planted({0.5, 2});
  rows.add({std::string("cvode_bdf_gmres"), 5, 100.0, 3.0, 3.0, 3.0, std::string("linear_stalled")});
  const Chart chart = stiffness_chart(rows, 5);
  ASSERT_EQ(chart.series.size(), 3U);
  EXPECT_EQ(chart.series[1].points.size(), 2U);  // the failed run is no point of the curve
  EXPECT_EQ(chart.series[2].label, "cvode_bdf_gmres: linear_stalled");
  EXPECT_FALSE(chart.series[2].lines);
}

}  // namespace
}  // namespace mss::studies::stiffness

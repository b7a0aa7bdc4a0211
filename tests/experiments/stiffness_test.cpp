// `mss stiffness`: all methods end alike, and crossings are found where they are.
#include "experiments/stiffness.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "integrators/linear/linear_solver.hpp"

namespace mss {
namespace {

TEST(Stiffness, AllMethodsEndAlike) {
  StiffnessConfig config = stiffness_config({.quick = true});
  config.cells = {2};
  config.young = {1e5, 1e8};
  config.repetitions = 1;
  Progress progress;
  const StiffnessTables tables = measure_stiffness(config, progress);
  ASSERT_EQ(tables.status, Status::ok);
  ASSERT_EQ(tables.rows.size(), 2 * (linear_solvers().size() + 3));
  for (std::size_t r = 0; r < tables.rows.size(); ++r) {
    EXPECT_EQ(tables.rows.text(r, "status"), "ok");
    EXPECT_LT(tables.rows.number(r, "difference"), 1e-3) << tables.rows.text(r, "method");
    EXPECT_GT(tables.rows.number(r, "seconds"), 0);
  }
}

TEST(Stiffness, LeavesKluOutOfLargeBodies) {
  StiffnessConfig config = stiffness_config({.cells = {8}});
  config.young = {1e5};
  config.repetitions = 1;
  Progress progress;
  const StiffnessTables tables = measure_stiffness(config, progress);
  const auto methods = tables.rows.distinct("method");
  EXPECT_EQ(methods.size(), linear_solvers().size() + 2);
  const Table summary = stiffness_summary(tables.rows);
  EXPECT_NE(summary.text(0, "status").find("KLU left out"), std::string::npos);
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
  EXPECT_NEAR(stiffness_summary(planted({0.1, 0.5, 2, 4})).number(0, "beats_gmres_from"), std::sqrt(1000),
              1e-9);
  EXPECT_NEAR(stiffness_summary(planted({2, 0.5, 2})).number(0, "beats_gmres_from"), std::sqrt(1000), 1e-9);
  EXPECT_EQ(stiffness_summary(planted({2, 3})).number(0, "beats_gmres_from"), 0);
  const Table never = stiffness_summary(planted({0.1, 0.2}));
  EXPECT_TRUE(std::isnan(never.number(0, "beats_gmres_from")));
  EXPECT_NE(never.text(0, "status"), "ok");
}

}  // namespace
}  // namespace mss

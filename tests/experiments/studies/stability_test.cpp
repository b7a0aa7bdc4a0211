// `mss stability`: that steps found by bisection are those predicted, and that failures have names.
#include "experiments/studies/stability/stability.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::stability {
namespace {

StabilityConfig small_config() {
  StabilityConfig config = stability_config({.quick = true});
  config.cells = {2};
  config.ratios = {0, 1};
  config.deformations.clear();
  return config;
}

/// Measured limits are in the middle of an interval 0.4 percent wide.
constexpr double resolution = 0.0025;

void expect_measured_as_predicted(const StabilityConfig& config) {
  Progress progress;
  Journal journal;
  const StabilityTables tables = measure_stability(config, 1, journal, progress);
  ASSERT_EQ(tables.status, Status::ok);
  const Table& rows = tables.rows;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::string name = rows.text(r, "integrator");
    SCOPED_TRACE(name + ", row " + std::to_string(r));
    if (name == "explicit_euler" && rows.number(r, "ratio") == 0) {
      EXPECT_EQ(rows.text(r, "status"), "no step is stable");
      EXPECT_EQ(rows.number(r, "predicted"), 0);
      EXPECT_TRUE(std::isnan(rows.number(r, "measured")));
      continue;
    }
    if (find_integrator(name).resonant_limit && rows.number(r, "ratio") == 0) {
      EXPECT_EQ(rows.text(r, "status"), "grows in too few steps to be found");
      EXPECT_NEAR(rows.number(r, "predicted") * rows.number(r, "omega_max"), 3.14, 0.01);
      EXPECT_TRUE(std::isnan(rows.number(r, "measured")));
      continue;
    }
    ASSERT_EQ(rows.text(r, "status"), "ok");
    EXPECT_NEAR(rows.number(r, "measured_over_predicted"), 1, resolution);
    if (rows.text(r, "deformation") == "none") {
      EXPECT_LE(rows.number(r, "guaranteed"), rows.number(r, "predicted"));
    }
  }
}

TEST(Stability, MeasuredStepsAreThosePredicted) { expect_measured_as_predicted(small_config()); }

TEST(Stability, AboutDeformedStatesToo) {
  StabilityConfig config = small_config();
  config.cells = {};
  config.deformations = {Deformation::stretched, Deformation::compressed, Deformation::bent};
  config.deformed_cells = 2;
  config.deformed_ratios = {0, 0.5};
  config.integrators = {"explicit_euler", "velocity_verlet"};
  expect_measured_as_predicted(config);
}

// One cell: all eight particles move away from the middle, which extends every spring in proportion.
/// The fastest motion does not limit its step there: by that alone it is predicted 1.2 and 1.4 times too
/// long.
TEST(Stability, OfWeaklyDampedPefrlIsNotPredictedTooLong) {
  StabilityConfig config = small_config();
  config.cells.clear();
  config.integrators = {"pefrl"};
  config.deformations = {Deformation::compressed, Deformation::bent};
  config.deformed_cells = 3;
  config.deformed_ratios = {0.05};
  Progress progress;
  Journal journal;
  const Table rows = measure_stability(config, 1, journal, progress).rows;
  ASSERT_EQ(rows.size(), 2);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    EXPECT_GT(rows.number(r, "measured_over_predicted"), 0.99) << rows.text(r, "deformation");
    EXPECT_LT(rows.number(r, "measured_over_predicted"), 1.1) << rows.text(r, "deformation");
  }
}

TEST(Stability, OfOneCellIsThatOfItsClosedForm) {
  StabilityConfig config = small_config();
  Specimen cell(config, Deformation::none, 1, 0);
  const SpringConstants& k =
      cell.body.config().springs;  // a cell alone has a quarter of an edge, half a face
  const double radius_squared = 0.75, mass = config.density / 8;
  const double stiffness = 12 * k.edge / 4 * 1 + 12 * k.face / 2 * 2 + 4 * k.body * 3 + 9 * k.volume;
  const double breathing = std::sqrt(stiffness / (8 * mass * radius_squared));
  EXPECT_NEAR(cell.omega / breathing, 1, 1e-6);
}

TEST(Stability, DeformedBodiesAreDeformed) {
  const StabilityConfig config = small_config();
  const Specimen rest(config, Deformation::none, 2, 0), stretched(config, Deformation::stretched, 2, 0),
      compressed(config, Deformation::compressed, 2, 0), bent(config, Deformation::bent, 2, 0);
  const auto extent = [](const Specimen& s, int axis) {
    double least = 1e9, most = -1e9;
    for (const std::ptrdiff_t site : s.body.sites()) {
      least = std::min(least, s.equilibrium.x.axis(axis)[site]);
      most = std::max(most, s.equilibrium.x.axis(axis)[site]);
    }
    return most - least;
  };
  for (const Specimen* s : {&rest, &stretched, &compressed, &bent}) ASSERT_EQ(s->status, Status::ok);
  EXPECT_NEAR(extent(stretched, 0), 1.3, 1e-9);
  EXPECT_NEAR(extent(compressed, 0), 0.8, 1e-9);
  EXPECT_LT(extent(stretched, 1), 1 + 1e-9);
  EXPECT_GT(extent(compressed, 1), 1.01);
  EXPECT_GT(extent(bent, 2), 1.5);  // a quarter of a circle of radius 1.9
  EXPECT_LT(extent(bent, 0), 2.7);
  EXPECT_NE(stretched.omega, rest.omega);
}

TEST(Stability, DrawsFromItsFiles) {
  StabilityConfig config = small_config();
  config.deformations = {Deformation::stretched};
  config.deformed_cells = 2;
  config.deformed_ratios = {1};
  config.integrators = {"explicit_euler", "verlet", "velocity_verlet"};
  Progress progress;
  Journal journal;
  const StabilityTables tables = measure_stability(config, 1, journal, progress);
  const std::vector<NamedTable> files = stability_files(config, tables.rows);
  expect_same_drawings(find_experiment("stability"), files);
  const Chart chart = find_experiment("stability").draw(files).charts[0].chart;
  EXPECT_EQ(chart.y.names, config.integrators);
  ASSERT_EQ(chart.series.size(), 2U);  // at rest and stretched
  std::size_t found = 0;
  for (const ChartSeries& series : chart.series) found += series.points.size();
  EXPECT_EQ(found, tables.rows.where("status", "ok").size());
}

TEST(Stability, ComparesMethodsWithALimitOnly) {
  const StabilityConfig all = stability_config({});
  EXPECT_GE(all.integrators.size(), 6U);
  for (const std::string& name : all.integrators) EXPECT_TRUE(find_integrator(name).limit) << name;
  EXPECT_THROW(stability_config({.integrators = {"backward_euler"}}), InputError);
}

}  // namespace
}  // namespace mss::studies::stability

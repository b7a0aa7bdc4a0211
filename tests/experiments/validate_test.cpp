// Springs mean what their calibration says, and `mss validate` measures it.
#include "experiments/validate.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "integrators/linear/linear_solver.hpp"
#include "reference/closed_forms.hpp"

namespace mss {
namespace {

/// E and nu of a cube of n^3 cells, from a pull along x that lets it narrow: K u = f at rest.
ElasticConstants measured(const SpringConstants& springs, int n, double h) {
  const Body body({.voxels = VoxelGrid::box(n, n, n), .cell_size = h, .density = 1, .springs = springs});
  const double edge = n * h, force = 1e6;
  const auto face = [&](int axis) {
    Hold hold{.box = {{0, 0, 0}, {edge, edge, edge}}, .axes = {axis == 0, axis == 1, axis == 2}};
    hold.box.upper[axis] = 0;
    return hold;
  };
  const Box end{{edge, 0, 0}, {edge, edge, edge}};
  SpringSystem<double> system(
      body, {.holds = {face(0), face(1), face(2)}, .loads = {{.box = end, .force = {force, 0, 0}}}});
  const State<double> rest = system.rest_state();
  Field<double> load(system.size()), u(system.size());
  system.force(0, rest.x, rest.v, load);
  Work work;
  const TangentSum sum{.stiffness = 1, .kind = Tangent::elastic};
  EXPECT_EQ(
      solve_tangent(*find_linear_solver("cholmod").make(0), system, 0, rest.x, rest.v, sum, load, u, work),
      Status::ok);
  const std::ptrdiff_t corner = body.select({edge, edge, edge}, {edge, edge, edge}).front();
  const double strain = u.at(corner)[0] / edge, across = u.at(corner)[1] / edge;
  return {.young = force / (edge * edge) / strain, .poisson = -across / strain};
}

TEST(Calibration, UniaxialTestsReturnTheMaterial) {
  for (const double poisson : {0.0, 0.1, 0.25, 0.3, 0.4, 0.45, 0.49})
    for (const double share : {0.25, 0.5, 1.0})
      for (const int n : {1, 2, 5}) {
        const double h = 0.2;
        const ElasticConstants given{.young = 1e5, .poisson = poisson};
        const ElasticConstants found = measured(calibrate(given, h, share), n, h);
        EXPECT_NEAR(found.young / given.young, 1, 1e-8) << poisson << " " << share << " " << n;
        EXPECT_NEAR(found.poisson, poisson, 1e-8) << poisson << " " << share << " " << n;
      }
}

TEST(Calibration, TheThesissConstantsAreWhatTheSpecificationSays) {
  const SpringConstants springs{.edge = 100, .face = 100, .body = 300, .volume = 0};
  const ElasticConstants found = measured(springs, 5, 0.2);
  EXPECT_NEAR(found.young, 1416.67, 0.01);
  EXPECT_NEAR(found.poisson, 0.4167, 1e-4);
  EXPECT_NEAR(cubic_stiffness(springs, 0.2).zener_ratio(), 5, 1e-12);
}

TEST(Validate, MeetsTheSpecificationsCantilevers) {
  ValidationConfig config = validation_config({.cells = {1, 2, 4}});
  config.repetitions = 1;
  Progress progress;
  const ValidationTables tables = measure_validation(config, progress);
  ASSERT_EQ(tables.status, Status::ok);
  const auto ratio = [&](const std::string& name, const std::string& model, int cells) {
    for (std::size_t r = 0; r < tables.rows.size(); ++r)
      if (tables.rows.text(r, "case") == name && tables.rows.text(r, "model") == model &&
          tables.rows.number(r, "cells") == cells)
        return tables.rows.number(r, "compliance") / tables.rows.number(r, "reference");
    return 0.0;
  };
  EXPECT_NEAR(ratio("cantilever", "calibrated, t = 1", 1), 0.5545, 1e-4);
  EXPECT_NEAR(ratio("cantilever", "calibrated, t = 1", 2), 0.8124, 1e-4);
  EXPECT_NEAR(ratio("cantilever", "calibrated, t = 1", 4), 0.9417, 1e-4);
  EXPECT_NEAR(ratio("cantilever", "calibrated, t = 0.5", 4), 0.9269, 1e-4);
  for (const char* model :
       {"thesis's springs", "calibrated, t = 0.25", "calibrated, t = 0.5", "calibrated, t = 1"})
    EXPECT_NEAR(ratio("stretch", model, 2), 1, 1e-12) << model;
  EXPECT_GT(std::abs(ratio("cantilever", "thesis's springs", 4) - 1),
            0.1);  // anisotropic: refining does not help
}

// Beam theory knows nothing of how a clamp stops the end from narrowing: it lies two percent above.
TEST(Validate, ReferencesAgreeWithEachOther) {
  const reference::SquareBar bar{.young = 1e5, .poisson = 0.3, .width = 1, .length = 4};
  EXPECT_NEAR(reference::cantilever_deflection(bar, 1) / reference::clamped_cantilever_deflection, 1.019,
              0.001);
}

TEST(Validate, KeepsFinishedRowsWhenStopped) {
  struct Stopper final : Progress {
    bool stopped() const override { return ++asked > 6; }
    mutable int asked = 0;
  } progress;
  ValidationConfig config = validation_config({.cells = {1, 2}});
  config.repetitions = 1;
  const ValidationTables tables = measure_validation(config, progress);
  EXPECT_EQ(tables.status, Status::interrupted);
  EXPECT_EQ(tables.rows.size(), 4U);
}

}  // namespace
}  // namespace mss

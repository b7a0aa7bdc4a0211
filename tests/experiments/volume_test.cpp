// `mss volume`: what swells, by how much, and that the thesis's volume force does nothing.
#include "experiments/volume.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/measures.hpp"
#include "core/spring_system.hpp"
#include "experiments/equilibrium.hpp"

namespace mss {
namespace {

VolumeConfig small_config() {
  VolumeConfig config = volume_config({.cells = {2, 4, 8}});
  config.strains = {-0.1, 0.1};
  config.stiffness = {0, 0.1, 1e3, 1e5};
  config.study_cells = 4;
  return config;
}

TEST(Volume, ConvergesToWhatElasticityPredicts) {
  Progress progress;
  const Table rows = measure_volume(small_config(), progress).rows;
  double before = 0, without = 0;
  int compared = 0, pairs = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    ASSERT_EQ(rows.text(r, "status"), "ok");
    EXPECT_GE(rows.number(r, "worst_cell"), std::abs(rows.number(r, "drift")));
    const std::string& model = rows.text(r, "model");
    if (model == "thesis's, k_vol = 0") without = rows.number(r, "drift");
    if (model == "thesis's, k_vol = 0.1") {
      EXPECT_NEAR(rows.number(r, "drift") / without, 1, 1e-4);
      EXPECT_NE(rows.number(r, "drift"), without);
      ++pairs;
    }
    if (rows.text(r, "study") != "cells" || model != "springs, nu = 0.3") continue;
    const double error = rows.number(r, "drift") / rows.number(r, "predicted") - 1;
    if (compared++ > 0) {
      EXPECT_LT(error, before / 1.7);  // the glued edges are singular: order below two
    }
    before = error;
  }
  EXPECT_EQ(compared, 3);
  EXPECT_EQ(pairs, 3 + 2 + 1);
  EXPECT_NEAR(before, 0.035, 0.01);
}

// A bar that may narrow swells by (1 - 2 nu) of a small strain, at any resolution.
TEST(Volume, OfAFreelyPulledCubeIsElasticitys) {
  constexpr double strain = 1e-5;
  for (const double poisson : {0.1, 0.3, 0.45, 0.49})
    for (const int n : {1, 3}) {
      BodyConfig config{.voxels = VoxelGrid::box(n, n, n), .cell_size = 1.0 / n};
      config.fill({.young = 1e4, .poisson = poisson}, 0.5);
      const Body body(config);
      SpringSystem<double> system(body,
                                  {.holds = {{.box = {{0, 0, 0}, {0, 1, 1}}, .axes = {true, false, false}},
                                             {.box = {{0, 0, 0}, {1, 0, 1}}, .axes = {false, true, false}},
                                             {.box = {{0, 0, 0}, {1, 1, 0}}, .axes = {false, false, true}},
                                             {.box = {{0, 0, 1}, {1, 1, 1}},
                                              .axes = {false, false, true},
                                              .displacement = {0, 0, strain}}}});
      const auto [status, state] = find_equilibrium(system, [](const Vec3& rest) -> Vec3 {
        return {rest[0], rest[1], (1 + strain) * rest[2]};
      });
      ASSERT_EQ(status, Status::ok);
      EXPECT_NEAR((measure(system, state).volume_ratio - 1) / strain, 1 - 2 * poisson, 1e-3);
    }
}

TEST(Volume, KeepsFinishedRowsWhenStopped) {
  struct Stopper final : Progress {
    bool stopped() const override { return ++asked > 4; }
    mutable int asked = 0;
  } progress;
  const VolumeTables tables = measure_volume(small_config(), progress);
  EXPECT_EQ(tables.status, Status::interrupted);
  EXPECT_EQ(tables.rows.size(), 4U);
}

}  // namespace
}  // namespace mss

// `mss validate lattice`: waves have the continuum's speed where they are long, bodies vibrate as the
// lattice's waves do, and explode beyond the strains that it names.
#include "experiments/studies/lattice/lattice.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "tests/read_back.hpp"

namespace mss::studies::lattice {
namespace {

TEST(Lattice, LongWavesHaveTheContinuumsSpeedToSecondOrder) {
  for (const double poisson : {0.3, 0.45})
    for (const double share : {0.25, 0.5, 1.0})
      for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(1, 1, 1), Vec3(5, 3, 1)}) {
        const PhaseSpeeds coarse = phase_speeds({poisson, share}, direction, 40);
        const PhaseSpeeds fine = phase_speeds({poisson, share}, direction, 80);
        for (std::size_t k = 0; k < wave_kinds.size(); ++k) {
          EXPECT_NEAR(fine[k], 1, 2e-3) << to_string(wave_kinds[k]);
          EXPECT_NEAR((1 - coarse[k]) / (1 - fine[k]), 4, 0.1) << to_string(wave_kinds[k]);
        }
        EXPECT_LE(fine[1], fine[2]);
      }
}

// Along an edge springs of one stiffness in a row: omega = 2 sqrt(k / m) sin(q / 2).
TEST(Lattice, AlongAnEdgeWavesAreThoseOfAChain) {
  for (const double cells : {3.0, 5.0, 8.0}) {
    const double half = std::numbers::pi / cells;
    for (const double speed : phase_speeds({0.3, 0.5}, Vec3::UnitX(), cells))
      EXPECT_NEAR(speed, std::sin(half) / half, 1e-12) << cells;
  }
}

TEST(Lattice, BodiesVibrateAsItsWaves) {
  Table rows = empty_standing();
  add_standing_waves({0.3, 0.5}, 4, rows);
  add_standing_waves({0.45, 0.25}, 3, rows);
  ASSERT_EQ(rows.size(), 14U);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    EXPECT_EQ(rows.text(r, "status"), "ok");
    // Velocity Verlet's is higher by (omega dt)^2 / 24.
    EXPECT_NEAR(rows.number(r, "frequency_over_predicted") - 1, std::pow(2 * std::numbers::pi / 1000, 2) / 24,
                1e-8)
        << rows.text(r, "wave") << rows.text(r, "direction");
    EXPECT_LT(rows.number(r, "frequency_over_continuum"), 0.99);
  }
}

// Free surfaces give way a little before, in compression by buckling.
TEST(Lattice, BodiesExplodeBeyondTheLimitsAndNotFarBefore) {
  Table rows = empty_growth();
  for (const double poisson : {0.0, -0.2}) add_growth({poisson, 0.5}, 6, rows);
  int beside = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const double share = rows.number(r, "strain_over_limit");
    const std::string run = rows.text(r, "path") + ", " + rows.text(r, "sides");
    if (share > 1.05) {
      EXPECT_NE(rows.text(r, "outcome"), "stays") << run << " " << share;
    }
    const double stays = rows.text(r, "sides") == "rollers" ? 0.98 : 0.5;
    if (share > stays) continue;
    ++beside;
    ASSERT_EQ(rows.text(r, "outcome"), "stays") << run << " " << share;
    EXPECT_LT(rows.number(r, "growth"), 2) << run << " " << share;
  }
  EXPECT_EQ(beside, 2 * (1 + 5 + 1));
}

TEST(Lattice, RelaxedItHasTheLawOfCauchyAndBorn) {
  Table rows = empty_law();
  for (const LatticeMaterial& m : {LatticeMaterial{0, 0.5}, {0.3, 0.25}, {0.45, 1}}) add_law(m, 3, rows);
  ASSERT_EQ(rows.size(), 12U);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    EXPECT_EQ(rows.text(r, "status"), "ok") << rows.text(r, "deformation");
    EXPECT_NEAR(rows.number(r, "energy_off"), 0, 1e-12) << rows.text(r, "deformation");
    EXPECT_LT(rows.number(r, "stress_off"), 1e-9) << rows.text(r, "deformation");
  }
}

TEST(Lattice, DrawsFromItsFiles) {
  Progress progress;
  LatticeConfig config = lattice_config({.quick = true});
  config.stretched.clear();
  config.directions = 4;
  const std::vector<NamedTable> tables = lattice_files(measure_lattice(config, progress));
  expect_same_drawings(find_experiment("lattice"), tables);
  const Drawings drawings = draw_lattice(tables);
  ASSERT_EQ(drawings.charts.size(), 3U);
  EXPECT_EQ(drawings.charts[0].name, "lattice");
  EXPECT_EQ(drawings.charts[0].chart.series.size(), 6U);
  for (const NamedChart& chart : drawings.charts) EXPECT_TRUE(has_points(chart.chart)) << chart.name;
}

}  // namespace
}  // namespace mss::studies::lattice

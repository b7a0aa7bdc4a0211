// The tests that decide between what the thesis prints and what this program does; reference/README.md lists
// them by formula.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/body/spectral_bound.hpp"
#include "core/springs/spring_system.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

double tetrahedron_volume(const std::array<Vec3, 4>& p) {
  return (p[1] - p[0]).dot((p[2] - p[0]).cross(p[3] - p[0])) / 6;
}

// Eq. 1-1 moves a vertex along (V - V0) (p - barycentre): away from the middle of a cell that is too large.
TEST(Errata, Equation_1_1_PushesTheWrongWay) {
  const std::array<Vec3, 4> p{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  const double volume = tetrahedron_volume(p);
  const Vec3 barycentre = (p[0] + p[1] + p[2] + p[3]) / 4;
  for (const double rest : {0.8 * volume, 1.2 * volume})  // too large, too small
    for (const double sign : {1.0, -1.0}) {               // as printed, as meant
      std::array<Vec3, 4> moved = p;
      for (Vec3& x : moved) x += 1e-3 * sign * (volume - rest) / rest * (x - barycentre);
      const double before = std::abs(volume - rest), after = std::abs(tetrahedron_volume(moved) - rest);
      if (sign > 0) {
        EXPECT_GT(after, before);
      } else {
        EXPECT_LT(after, before);
      }
    }
}

// A damping coefficient is a mass over a time. In other units of length (l0 times s, k and masses as they
// are) it is the same number; eq. 2-4's changes with them.
TEST(Errata, Equation_2_4_HasTheWrongUnits) {
  const Damping ratio{.law = Damping::Law::ratio, .zeta = 1}, thesis{.law = Damping::Law::thesis};
  EXPECT_EQ(ratio.coefficient(50, 2, 3, 0.1, 1), ratio.coefficient(50, 2, 3, 10, 1));
  EXPECT_NEAR(thesis.coefficient(50, 2, 3, 0.1, 1) / thesis.coefficient(50, 2, 3, 10, 1), 100, 1e-9);
}

// A body that turns as a whole has no strain rate. Eq. 2-6 as printed takes |v1 - v2| for the rate at which a
// spring grows, and would brake it.
TEST(Errata, Equation_2_6_WouldBrakeRotation) {
  BodyConfig config = testing::test_config(VoxelGrid::box(2, 2, 2));
  const Body damped(config);
  config.damping = {};
  const Body undamped(config);
  SpringSystem<double> with(damped, {}), without(undamped, {});
  State<double> state = with.rest_state();
  const Vec3 spin(1, 2, 3);
  for (const std::ptrdiff_t site : damped.sites()) state.v.set(site, spin.cross(state.x.at(site)));
  Field<double> f(with.size()), g(with.size());
  with.force(0, state.x, state.v, f);
  without.force(0, state.x, state.v, g);
  double printed = 0;
  damped.for_each_spring([&](std::ptrdiff_t a, std::ptrdiff_t b, const SpringSlot&, double, double c) {
    printed = std::max(printed, c * (state.v.at(b) - state.v.at(a)).norm());
  });
  EXPECT_LT((f.array() - g.array()).abs().maxCoeff(), 1e-12 * printed);
  EXPECT_GT(printed, 1);
}

// Section 5.1 keeps the volume by k_vol = 0.1. That changes Young's modulus by two millionths.
TEST(Errata, Section_5_1_VolumeForceDoesNotAct) {
  SpringConstants springs{.edge = 100, .face = 100, .body = 300, .volume = 0.1};
  const double with = cubic_stiffness(springs, 0.2).young({1, 0, 0});
  springs.volume = 0;
  const double without = cubic_stiffness(springs, 0.2).young({1, 0, 0});
  EXPECT_NEAR(with / without, 1, 3e-6);
  EXPECT_NE(with, without);
}

double stable_bound(int n, bool fixed_material) {
  const double scale = fixed_material ? 1.0 / n : 1;
  const Body body({.voxels = VoxelGrid::box(n, n, n),
                   .cell_size = 1.0 / n,
                   .density = 1,
                   .springs = {.edge = 100 * scale, .face = 100 * scale, .body = 300 * scale}});
  return spectral_bound(body).omega;
}

// Section 5.3: n^3 springs a step; but steps become shorter: n of them more for a constant material, n^1.5
// for the thesis's constants.
TEST(Errata, Section_5_3_ASimulatedSecondCostsMoreThanNCubed) {
  EXPECT_NEAR(stable_bound(16, true) / stable_bound(8, true), 2, 1e-6);
  EXPECT_NEAR(stable_bound(16, false) / stable_bound(8, false), std::pow(2, 1.5), 1e-6);
}

}  // namespace
}  // namespace mss

// The calibration, its inverse, the thesis's own constants, damping, and bounds on the spectrum.
#include "core/body/material.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "core/body/spectral_bound.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

TEST(Material, CalibrationReturnsYoungAndPoissonInEveryDirection) {
  for (const double poisson : {0.0, 0.1, 0.25, 0.3, 0.4, 0.45, 0.49})
    for (const double share : {0.25, 0.5, 1.0})
      for (const double h : {0.01, 1.0}) {
        const CubicStiffness c = cubic_stiffness(calibrate({.young = 2e5, .poisson = poisson}, h, share), h);
        EXPECT_NEAR(c.zener_ratio(), 1, 1e-12);
        for (const auto& direction : {Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(1, 1, 1), Vec3(3, -1, 2)}) {
          EXPECT_NEAR(c.young(direction), 2e5, 1e-8 * 2e5);
          EXPECT_NEAR(c.poisson(direction), poisson, 1e-10);
        }
      }
}

// It would be printed with the sign.
TEST(Material, APoissonsRatioOfZeroHasNoSign) {
  const CubicStiffness c = cubic_stiffness(calibrate({.young = 1e5, .poisson = 0}, 0.1, 0.5), 0.1);
  for (const auto& direction : {Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(1, 1, 1)}) {
    EXPECT_EQ(c.poisson(direction), 0);
    EXPECT_FALSE(std::signbit(c.poisson(direction)));
  }
}

TEST(Material, ThesisConstantsAreNotIsotropic) {
  const SpringConstants springs{.edge = 100, .face = 100, .body = 300, .volume = 0.1};
  const CubicStiffness c = cubic_stiffness(springs, 0.2);
  EXPECT_NEAR(c.zener_ratio(), 5, 1e-12);
  EXPECT_NEAR(c.young(Vec3(1, 0, 0)), 1416.67, 0.005);
  EXPECT_NEAR(c.poisson(Vec3(1, 0, 0)), 0.4167, 5e-5);
  const std::vector<std::string> warnings = material_warnings(springs, 0.2);
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_NE(warnings[0].find("Zener ratio 5"), std::string::npos);
  EXPECT_NE(warnings[1].find("12.2 percent of compression along [111], 25.6 percent of shear"),
            std::string::npos)
      << warnings[1];
  // The volume force the thesis uses changes E by parts in a million.
  SpringConstants without = springs;
  without.volume = 0;
  EXPECT_NEAR(c.young(Vec3(1, 0, 0)) / cubic_stiffness(without, 0.2).young(Vec3(1, 0, 0)) - 1, 2e-6, 1e-6);
}

TEST(Material, WarnsOfStrainsAtWhichTheLatticeIsUnstable) {
  const auto warnings = [](double poisson, double share) {
    return material_warnings(calibrate({.young = 1e5, .poisson = poisson}, 0.1, share), 0.1);
  };
  EXPECT_TRUE(warnings(0.3, 0.5).empty());
  EXPECT_TRUE(warnings(0.45, 1).empty());
  ASSERT_EQ(warnings(0, 0.5).size(), 1U);
  EXPECT_NE(warnings(0, 0.5)[0].find("below 1/4"), std::string::npos);
  EXPECT_NE(warnings(0, 0.5)[0].find("19.4 percent of tension along"), std::string::npos)
      << warnings(0, 0.5)[0];
  ASSERT_EQ(warnings(0.3, 0.25).size(), 1U);
  EXPECT_NE(warnings(0.3, 0.25)[0].find("29.8 percent of compression along [100]"), std::string::npos)
      << warnings(0.3, 0.25)[0];
  // They have no unit, and springs whose ratios are others have others.
  const auto of_springs = [](double unit, double share) {
    return material_warnings(calibrate({.young = 1e5 * unit, .poisson = 0.3}, 0.7 * unit, share), 0.7 * unit);
  };
  EXPECT_EQ(of_springs(1, 0.25), of_springs(0.3, 0.25));
  EXPECT_NE(of_springs(1, 0.25), of_springs(1, 0.2));
}

TEST(Material, RefusesWhatIsNoMaterial) {
  EXPECT_THROW(calibrate({.young = 1e5, .poisson = 0.5}, 1, 0.5), InputError);
  EXPECT_THROW(calibrate({.young = 1e5, .poisson = -1}, 1, 0.5), InputError);
  EXPECT_THROW(calibrate({.young = 0, .poisson = 0.3}, 1, 0.5), InputError);
  EXPECT_THROW(calibrate({.young = 1e5, .poisson = 0.3}, 1, 1.5), InputError);
}

TEST(Damping, RatioOneIsCriticalForTwoMasses) {
  const double k = 70, m1 = 0.3, m2 = 1.1, reduced = m1 * m2 / (m1 + m2);
  const Damping critical{.law = Damping::Law::ratio, .zeta = 1};
  const double c = critical.coefficient(k, m1, m2, 0.2, 1);
  EXPECT_NEAR(c * c, 4 * k * reduced, 1e-12);  // equal roots of reduced x'' + c x' + k x
  const Damping thesis{.law = Damping::Law::thesis};
  EXPECT_NEAR(thesis.coefficient(k, m1, m2, 0.2, 1), 2 * std::sqrt(k * (m1 + m2)) / 0.2, 1e-12);
}

/// Power that a body's dampers dissipate while it deforms at the rate of a velocity gradient, over its
/// volume.
double dissipation(const BodyConfig& config, const Eigen::Matrix3d& rate) {
  const Body body(config);
  SpringSystem<double> system(body, {}, {.threads = 1});
  State<double> state = system.rest_state();
  for (const std::ptrdiff_t site : body.sites()) state.v.set(site, rate * state.x.at(site));
  Field<double> force(system.size());
  system.force(0, state.x, state.v, force);
  double power = 0;
  for (const std::ptrdiff_t site : body.sites()) power -= force.at(site).dot(state.v.at(site));
  return power / (double(body.cell_count()) * body.cell_volume());
}

// 2 eta e:e + eta tr(e)^2 of the strain rate e: shear viscosity eta, and lambda' = eta by Cauchy's relation.
TEST(Damping, AViscosityIsTheMaterials) {
  const double eta = 30;
  Eigen::Matrix3d rate;
  rate << 0.3, 0.7, -0.2, -0.1, -0.4, 0.5, 0.6, 0.2, 0.9;
  const Eigen::Matrix3d e = (rate + rate.transpose()) / 2;
  const double expected = 2 * eta * e.squaredNorm() + eta * e.trace() * e.trace();
  for (const double poisson : {0.1, 0.25, 0.45})
    for (const double share : {0.25, 0.5, 1.0})
      for (const int n : {1, 2, 5}) {
        BodyConfig config{.voxels = VoxelGrid::box(n, n, n),
                          .cell_size = 0.6 / n,
                          .damping = {.law = Damping::Law::viscosity, .viscosity = eta}};
        config.fill({.young = 1e4, .poisson = poisson}, share);
        EXPECT_NEAR(dissipation(config, rate), expected, 1e-9 * expected) << share << " " << n;
        testing::fill_evenly(config,
                             std::vector<float>(std::size_t(n) * std::size_t(n) * std::size_t(n), 0.5F));
        EXPECT_NEAR(dissipation(config, rate), 0.5 * expected, 1e-9 * expected) << share << " " << n;
      }
}

// Springs that are given have the viscosity in shear along their edges, whatever else they are.
TEST(Damping, AViscosityOfGivenSpringsIsOfShear) {
  Eigen::Matrix3d shear = Eigen::Matrix3d::Zero();
  shear(0, 1) = 1;  // tensorial shear 1/2: 2 eta e:e = eta
  BodyConfig config = testing::test_config(VoxelGrid::box(3, 3, 3));
  config.damping = {.law = Damping::Law::viscosity, .viscosity = 7};
  EXPECT_NEAR(dissipation(config, shear), 7, 1e-10);
}

// A ratio's viscosity goes with the size of cells, but for the surface, whose springs and masses are smaller.
TEST(Damping, ARatioIsOfTheSprings) {
  Eigen::Matrix3d shear = Eigen::Matrix3d::Zero();
  shear(0, 1) = 1;
  const auto power = [&](int n) {
    BodyConfig config{.voxels = VoxelGrid::box(n, n, n),
                      .cell_size = 1.0 / n,
                      .damping = {.law = Damping::Law::ratio, .zeta = 0.1}};
    config.fill({.young = 1e4, .poisson = 0.3}, 0.5);
    return dissipation(config, shear);
  };
  EXPECT_NEAR(power(12) / power(24), 2, 0.1);
}

/// Largest frequency by power iteration on M^-1 K, the force differentiated along the iterate.
double largest_frequency(const Body& body) {
  SpringSystem<double> system(body, {});
  const auto rest = system.rest_state();
  auto state = rest;
  Field<double> a(system.size());
  testing::randomise(body, state, 1e-6, 0, 3);
  double omega_squared = 0;
  const double size = 1e-6 * body.config().cell_size;
  for (int i = 0; i < 3000; ++i) {
    system.acceleration(0, state.x, state.v, a);
    omega_squared = std::sqrt(a.array().square().sum() / (state.x.array() - rest.x.array()).square().sum());
    state.x.array() = rest.x.array() + a.array() * (size / std::sqrt(a.array().square().sum()));
  }
  return std::sqrt(omega_squared);
}

TEST(SpectralBound, IsTheCornersForAUniformCubeAndHolds) {
  const int n = 7;
  BodyConfig config{.voxels = VoxelGrid::box(n, n, n),
                    .cell_size = 1.0 / n,
                    .sharing = Sharing::uniform,
                    .density = 1,
                    .springs = {.edge = 100, .face = 100, .body = 300, .volume = 0}};
  const double corner = std::sqrt(16 * (100 + 200 + 300) * std::pow(n, 3.0));
  EXPECT_NEAR(corner, 1815, 0.5);
  const Body uniform(config);
  EXPECT_NEAR(spectral_bound(uniform).omega, corner, 1e-9 * corner);
  EXPECT_NEAR(largest_frequency(uniform), 1350, 5);
  config.sharing = Sharing::weighted;
  const Body weighted(config);
  EXPECT_GT(spectral_bound(weighted).omega, largest_frequency(weighted));
  EXPECT_LT(spectral_bound(weighted).omega, 2 * largest_frequency(weighted));
}

TEST(SpectralBound, HoldsForEveryShapeWithVolumeForce) {
  for (const auto& shape : testing::test_shapes()) {
    BodyConfig config = testing::test_config(shape.voxels);
    config.damping = {};
    const Body body(config);
    // A single cell attains its bound: only the rounding of differentiated forces separates the two.
    EXPECT_GT((1 + 1e-6) * spectral_bound(body).omega, largest_frequency(body)) << shape.name;
  }
}

}  // namespace
}  // namespace mss

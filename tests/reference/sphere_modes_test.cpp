// Vibrations of the solid sphere: frequencies of the literature, and fields that satisfy the equation of
// motion.
#include "reference/sphere_modes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace mss::reference {
namespace {

SolidSphere sphere_of(double poisson) {
  return {.material = {.young = 2 * (1 + poisson), .poisson = poisson}, .density = 1, .radius = 1};  // mu = 1
}

TEST(SphereModes, HaveTheFrequenciesOfTheLiterature) {
  for (const double poisson : {0.0, 0.25, 0.3, 0.45})
    EXPECT_NEAR(SphereVibration(sphere_of(poisson), SphereMode::torsional).omega(), 2.501133, 1e-6);
  // Love, Mathematical Theory of Elasticity, art. 198: omega a / (pi c) = .848 incompressible, .840 for nu =
  // 1/4.
  EXPECT_NEAR(SphereVibration(sphere_of(0.25), SphereMode::spheroidal).omega() / std::numbers::pi, 0.840,
              5e-4);
  EXPECT_NEAR(SphereVibration(sphere_of(0.499999), SphereMode::spheroidal).omega() / std::numbers::pi, 0.848,
              5e-4);
}

TEST(SphereModes, ScaleWithRadiusAndSpeedOfSound) {
  const SolidSphere sphere{.material = {.young = 5e4, .poisson = 0.3}, .density = 800, .radius = 0.2};
  for (const SphereMode mode : {SphereMode::torsional, SphereMode::spheroidal})
    EXPECT_NEAR(SphereVibration(sphere, mode).omega(),
                SphereVibration(sphere_of(0.3), mode).omega() * std::sqrt(5e4 / 2.6 / 800) / 0.2, 1e-9);
}

/// mu laplace u + (lambda + mu) grad div u + rho omega^2 u, over the last term's size, by central
/// differences.
double residual(const SolidSphere& sphere, SphereMode mode, std::size_t which, const Vec3& at) {
  constexpr double d = 1e-3;
  const SphereVibration vibration(sphere, mode);
  const auto u = [&](const Vec3& p) { return vibration.displacements(p)[which]; };
  const auto axis = [&](int a) { return Vec3(d * Vec3::Unit(a)); };
  const double nu = sphere.material.poisson, mu = 1, lambda = 2 * nu / (1 - 2 * nu);
  Vec3 laplace = Vec3::Zero(), grad_div = Vec3::Zero();
  for (int a = 0; a < 3; ++a) {
    laplace += (u(at + axis(a)) + u(at - axis(a)) - 2 * u(at)) / (d * d);
    for (int b = 0; b < 3; ++b)
      grad_div[a] += (u(at + axis(a) + axis(b))[b] - u(at + axis(a) - axis(b))[b] -
                      u(at - axis(a) + axis(b))[b] + u(at - axis(a) - axis(b))[b]) /
                     (4 * d * d);
  }
  const double omega = vibration.omega();
  return (mu * laplace + (lambda + mu) * grad_div + omega * omega * u(at)).norm() /
         (omega * omega * u(at).norm());
}

TEST(SphereModes, FieldsSatisfyTheEquationOfMotion) {
  const SolidSphere sphere = sphere_of(0.3);
  for (const SphereMode mode : {SphereMode::torsional, SphereMode::spheroidal})
    for (std::size_t which = 0; which < 5; ++which)
      for (const Vec3& at : {Vec3(0.3, 0.5, 0.2), Vec3(-0.1, 0.6, 0.4), Vec3(0.4, -0.2, -0.7)})
        EXPECT_LT(residual(sphere, mode, which, at), 1e-4);
}

TEST(SphereModes, SpheroidalFieldsLeaveTheSurfaceFree) {
  // sigma_rr at the pole of 2 z^2 - x^2 - y^2: lambda div u + 2 mu du_z/dz = 0 at z = a.
  const SolidSphere sphere = sphere_of(0.3);
  constexpr double d = 1e-4, lambda = 2 * 0.3 / (1 - 0.6);
  const SphereVibration vibration(sphere, SphereMode::spheroidal);
  const auto u = [&](const Vec3& p) { return vibration.displacements(p)[4]; };
  const Vec3 pole(0, 0, 1);
  double divergence = 0, along = 0;
  for (int a = 0; a < 3; ++a) {
    const double slope = (u(pole + d * Vec3::Unit(a))[a] - u(pole - d * Vec3::Unit(a))[a]) / (2 * d);
    divergence += slope;
    if (a == 2) along = slope;
  }
  EXPECT_GT(std::abs(along), 0.1 * std::abs(u(pole)[2]));
  EXPECT_NEAR(lambda * divergence + 2 * along, 0, 1e-5 * std::abs(along));
}

}  // namespace
}  // namespace mss::reference

// Generalized-alpha: what it does to motions that a step cannot resolve, and which methods it contains.
#include <gtest/gtest.h>

#include <cmath>

#include "integrators/integrator.hpp"
#include "tests/oscillator.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

std::unique_ptr<Integrator<double>> method(double dt, double spectral_radius) {
  return find_integrator("generalized_alpha").make<double>({.dt = dt, .spectral_radius = spectral_radius});
}

/// By what a step multiplies a motion that it cannot resolve: the largest position in the second of two
/// windows over that in the first. Below 1 all three eigenvalues coincide in the limit, so that x_n is rho^n
/// times a polynomial of degree two, whose share is taken out.
double measured_radius(double rho) {
  constexpr double dt_omega = 1e5;
  constexpr int window = 150;
  testing::Oscillator system(dt_omega, 0);
  auto state = system.start(1, 0);
  Work work;
  const auto integrator = method(1, rho);
  double largest[2] = {0, 0};
  for (int step = 1; step <= 3 * window; ++step) {
    EXPECT_EQ(integrator->advance(system, state, step, work), Status::ok);
    double& here = largest[step > 2 * window];
    if (step > window) here = std::max(here, std::abs(state.x.axis(0)[0]));
  }
  const double polynomial = rho < 1 ? std::pow((2.0 * window + 1) / (window + 1), 2) : 1;
  return std::pow(largest[1] / largest[0] / polynomial, 1.0 / window);
}

TEST(GeneralizedAlpha, HasTheSpectralRadiusAskedForAtInfinity) {
  for (const double rho : {0.3, 0.5, 0.8, 0.9, 1.0}) EXPECT_NEAR(measured_radius(rho), rho, 1e-3);
}

TEST(GeneralizedAlpha, RemovesTheUnresolvedInThreeStepsAtRadiusZero) {
  testing::Oscillator system(1e5, 0);
  auto state = system.start(1, 0);
  Work work;
  ASSERT_EQ(method(1, 0)->advance(system, state, 3, work), Status::ok);
  EXPECT_LT(std::abs(state.x.axis(0)[0]), 1e-8);
}

TEST(GeneralizedAlpha, LosesNoEnergyOfLinearMotionsAtRadiusOne) {
  testing::Oscillator system(3, 0);
  const auto energy_left = [&](double rho) {
    auto state = system.start(0.8, 0.5);
    Work work;
    EXPECT_EQ(method(0.2, rho)->advance(system, state, 200, work), Status::ok);
    const double x = state.x.axis(0)[0], v = state.v.axis(0)[0];
    return (9 * x * x + v * v) / (9 * 0.64 + 0.25);
  };
  EXPECT_NEAR(energy_left(1), 1, 1e-9);
  EXPECT_LT(energy_left(0.9), 0.99);
  EXPECT_LT(energy_left(0.5), energy_left(0.9));
}

// Newmark's average acceleration is x1 - x0 = dt/2 (v0 + v1), M (v1 - v0) = dt/2 (f0 + f1), on any system.
TEST(GeneralizedAlpha, IsTheTrapezoidalRuleAtRadiusOne) {
  const Body body(testing::test_config(VoxelGrid::box(3, 2, 2)));
  SpringSystem<double> system(body, {.gravity = Vec3(0, 0, -9.81)});
  State<double> state = system.rest_state();
  testing::randomise(body, state, 0.2, 0.5, 3);
  constexpr double dt = 0.01;
  const auto integrator = method(dt, 1);
  Field<double> f0(system.size()), f1(system.size());
  Work work;
  for (int step = 0; step < 20; ++step) {
    const State<double> before = state;
    ASSERT_EQ(integrator->advance(system, state, before.t + dt, work), Status::ok);
    system.force(0, before.x, before.v, f0);
    system.force(0, state.x, state.v, f1);
    for (const std::ptrdiff_t site : body.sites()) {
      const Vec3 moved =
          state.x.at(site) - before.x.at(site) - dt / 2 * (before.v.at(site) + state.v.at(site));
      const Vec3 kicked =
          body.mass(site) * (state.v.at(site) - before.v.at(site)) - dt / 2 * (f0.at(site) + f1.at(site));
      EXPECT_LT(moved.norm(), 1e-14);
      EXPECT_LT(kicked.norm(), 1e-8);
    }
  }
}

}  // namespace
}  // namespace mss

// Loads that depend on time, by every kind of method and both kinds of cells.
#include <gtest/gtest.h>

#include <string>

#include "core/environment/environment.hpp"
#include "experiments/simulation/model.hpp"
#include "integrators/integrator.hpp"

namespace mss {
namespace {

/// Steps that reach the end, and the momentum that a load gives a free body there.
Vec3 momentum_after(const std::string& method, const std::string& model, const Load& load, double dt) {
  const Body body({.voxels = VoxelGrid::box(2, 1, 1),
                   .cell_size = 0.1,
                   .springs = calibrate({.young = 1e4, .poisson = 0.25}, 0.1, 0.5),
                   .elastic = ElasticConstants{.young = 1e4, .poisson = 0.25}});
  const auto system = make_system<double>(model, body, {.loads = {load}}, 1);
  State<double> state = system->undeformed_state();
  const auto integrator = find_integrator(method).make<double>({.dt = dt});
  Work work;
  EXPECT_EQ(integrator->advance(*system, state, 1, work), Status::ok) << method;
  Vec3 momentum = Vec3::Zero();
  for (const std::ptrdiff_t site : system->particles()) momentum += system->mass(site) * state.v.at(site);
  return momentum;
}

// Internal forces have no momentum, so it is the integral of the load: of a ramp up to 6 N and down, 3 N s.
TEST(Load, OfAHistoryGivesItsIntegralByEveryMethod) {
  const Load load{.box = {Vec3::Zero(), Vec3(0.2, 0.1, 0.1)},
                  .force = Vec3(0, 6, 0),
                  .history = {{{0, 0}, {0.5, 1}, {1, 0}}}};
  constexpr double dt = 1e-3;
  const auto expect_three = [&](const std::string& method, const std::string& model, double error) {
    const Vec3 momentum = momentum_after(method, model, load, dt);
    EXPECT_NEAR(momentum.y(), 3, error) << method << " " << model;
    EXPECT_NEAR(momentum.x(), 0, 1e-12) << method << " " << model;
  };
  for (const char* method : {"semi_implicit_euler", "verlet", "velocity_verlet", "rk4", "pefrl",
                             "backward_euler", "backward_euler_linear", "implicit_midpoint", "tr_bdf2",
                             "generalized_alpha", "energy_momentum", "xpbd", "vbd:20", "cvode_bdf"})
    expect_three(method, "springs", method == std::string("cvode_bdf") ? 1e-2 : 6e-3);
  expect_three("velocity_verlet", "corotational", 6e-3);
  expect_three("backward_euler", "corotational", 6e-3);
}

TEST(Load, WithoutAHistoryIsConstant) {
  const Load load{.box = {Vec3::Zero(), Vec3(0.2, 0.1, 0.1)}, .force = Vec3(0, 6, 0)};
  EXPECT_NEAR(momentum_after("velocity_verlet", "springs", load, 1e-3).y(), 6, 1e-9);
}

}  // namespace
}  // namespace mss

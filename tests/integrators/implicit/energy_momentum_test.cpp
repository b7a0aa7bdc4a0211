// The energy-momentum method keeps energy and angular momentum at steps far beyond the explicit limit.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/base/error.hpp"
#include "core/measures/measures.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "integrators/nonlinear/implicit_stage.hpp"
#include "reference/fem/fem_system.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

/// A stretched cube that spins and slowly falls, at ten times the largest step of central differences.
struct Tumbling {
  explicit Tumbling(double volume_share, const std::string& method, double steps_of_limit = 10)
      : body(config(volume_share)), system(body, {.gravity = Vec3(0, 0, -1e-4)}, {.threads = 1}) {
    state = system.rest_state();
    for (const std::ptrdiff_t site : body.sites()) {
      const Vec3 x = state.x.at(site);
      state.x.set(site, x.cwiseProduct(Vec3(1.1, 0.95, 1)));
      state.v.set(site, Vec3(0, 0, 0.3).cross(x - Vec3(0.5, 0.5, 0.5)));
    }
    dt = steps_of_limit * central_limit(system.spectral_bound().omega, 0);
    integrator = find_integrator(method).make<double>({.dt = dt});
  }
  static BodyConfig config(double volume_share) {
    BodyConfig config{.voxels = VoxelGrid::box(2, 2, 2), .cell_size = 0.5};
    config.fill({.young = 1e4, .poisson = 0.3}, 0.5);
    config.springs.volume *= volume_share;
    return config;
  }
  Status advance(int steps) { return integrator->advance(system, state, state.t + steps * dt, work); }

  Body body;
  SpringSystem<double> system;
  State<double> state;
  double dt = 0;
  std::unique_ptr<Integrator<double>> integrator;
  Work work;
};

/// Largest share by which the total energy has changed.
double energy_drift(Tumbling& t, int steps) {
  const double start = measure(t.system, t.state).total();
  double largest = 0;
  for (int i = 0; i < steps; ++i) {
    EXPECT_EQ(t.advance(1), Status::ok) << i;
    largest = std::max(largest, std::abs(measure(t.system, t.state).total() / start - 1));
  }
  return largest;
}

TEST(EnergyMomentum, KeepsEnergyAtTenTimesTheExplicitLimit) {
  Tumbling with_volume(1, "energy_momentum"), springs(0, "energy_momentum"), midpoint(1, "implicit_midpoint");
  EXPECT_LT(energy_drift(with_volume, 200), 1e-12);
  EXPECT_LT(energy_drift(springs, 200), 1e-12);
  EXPECT_GT(energy_drift(midpoint, 20), 1e-3);  // which is symplectic, not conserving
}

TEST(EnergyMomentum, KeepsTheSpinOfSprings) {
  Tumbling t(0, "energy_momentum");
  const Vec3 before = measure(t.system, t.state).angular_momentum;
  ASSERT_EQ(t.advance(200), Status::ok);
  EXPECT_LT((measure(t.system, t.state).angular_momentum - before).norm(), 1e-11 * before.norm());
}

TEST(EnergyMomentum, RefusesModelsWithoutADiscreteGradient) {
  BodyConfig config{.voxels = VoxelGrid::box(1, 1, 1)};
  config.fill({.young = 1e4, .poisson = 0.3}, 0.5);
  const Body body(config);
  FemSystem elements(body, {}, solid_laws().front());
  State<double> state = elements.rest_state();
  Work work;
  const auto method = find_integrator("energy_momentum").make<double>({.dt = 0.1});
  try {
    method->advance(elements, state, 1, work);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("no discrete gradient"), std::string::npos);
  }
}

}  // namespace
}  // namespace mss

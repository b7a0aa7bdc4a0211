// Trajectories: against Algorithm 1 over a thousand steps, and the same bits for any number of threads.
#include <gtest/gtest.h>

#include <cstring>

#include "core/kernels/sweep.hpp"
#include "core/measures/measures.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

constexpr double dt = 2e-4;
constexpr KickDrift semi_implicit{.kick_before = dt, .kick_after = 0, .drift_old = 0, .drift_new = dt};

TEST(Trajectory, FollowsTheOracleForAThousandSteps) {
  const Vec3 gravity(0, 0.5, -9.81);
  for (const auto& shape : testing::test_shapes())
    for (const auto sharing : {Sharing::weighted, Sharing::uniform}) {
      BodyConfig config = testing::test_config(shape.voxels);
      config.sharing = sharing;
      const Body body(config);
      SpringSystem<double> system(body, {.gravity = gravity});
      reference::Algorithm1 oracle(config, gravity, 1);
      auto state = system.rest_state();
      testing::randomise(body, state, 0.1, 0.3, 29);
      testing::copy_state(body, state, oracle);
      system.kick_drift(semi_implicit, dt, 1000, state);
      for (int step = 0; step < 1000; ++step) oracle.step(dt);
      double moved = 0;
      for (std::size_t id = 0; id < body.particle_count(); ++id) {
        const std::ptrdiff_t site = body.sites()[id];
        EXPECT_LT((state.x.at(site) - oracle.particles()[id].x).norm(), 1e-9) << shape.name;
        moved = std::max(moved, (state.x.at(site) - body.rest_position(site)).norm());
      }
      EXPECT_GT(moved, 0.1);
    }
}

TEST(Trajectory, OfWeightsFollowsTheOracle) {
  const Vec3 gravity(0, 0.5, -9.81);
  BodyConfig config = testing::test_config(VoxelGrid::box(3, 3, 3));
  config.weights = {{{config.origin, config.origin + Vec3(0.3, 9, 9)}, 1e5}};
  const Body body(config);
  SpringSystem<double> system(body, {.gravity = gravity});
  reference::Algorithm1 oracle(config, gravity, 1);
  auto state = system.rest_state();
  testing::randomise(body, state, 0.1, 0.3, 29);
  testing::copy_state(body, state, oracle);
  const Vec3 momentum = measure(system, state).momentum;
  system.kick_drift(semi_implicit, dt, 1000, state);
  for (int step = 0; step < 1000; ++step) oracle.step(dt);
  for (std::size_t id = 0; id < body.particle_count(); ++id)
    EXPECT_LT((state.x.at(body.sites()[id]) - oracle.particles()[id].x).norm(), 1e-9);
  const Vec3 fell = body.total_mass() * 1000 * dt * gravity;
  EXPECT_LT((measure(system, state).momentum - momentum - fell).norm(), 1e-9 * fell.norm());
}

VoxelGrid random_voxels() { return testing::test_shapes().back().voxels; }

template <class Real>
void expect_same_bits(const VoxelGrid& voxels, const std::string& kernel) {
  const Body body(testing::test_config(voxels));
  Environment environment{.gravity = Vec3(0, 0, -9.81)};
  const Vec3 low = body.config().origin;
  environment.holds.push_back({.box = {low, low + Vec3(0, 9, 9)}, .velocity = Vec3(-0.2, 0, 0)});
  environment.loads.push_back({{low, low + Vec3::Constant(9)}, Vec3(1, -2, 3)});
  Field<Real> expected;
  for (const int threads : {1, 2, 3, 5, 8}) {
    SpringSystem<Real> system(body, environment, {threads, kernel});
    EXPECT_EQ(system.threads(), std::min(threads, body.lattice().planes()));
    auto state = system.rest_state();
    testing::randomise(body, state, 0.1, 0.3, 31);
    system.kick_drift(semi_implicit, dt, 200, state);
    if (threads == 1) {
      expected = state.x;
      continue;
    }
    EXPECT_EQ(0, std::memcmp(expected.axis(0), state.x.axis(0), std::size_t(expected.size()) * sizeof(Real)))
        << threads << " threads, " << kernel;
  }
}

class Threads : public ::testing::TestWithParam<int> {};

TEST_P(Threads, GiveTheSameBits) {
  const VoxelGrid voxels =
      GetParam() == 0 ? random_voxels() : VoxelGrid::box(GetParam(), GetParam(), GetParam());
  for (const auto& kernel : runnable_copies<SweepKernel<double>>())
    expect_same_bits<double>(voxels, kernel.name);
  for (const auto& kernel : runnable_copies<SweepKernel<float>>())
    expect_same_bits<float>(voxels, kernel.name);
}

INSTANTIATE_TEST_SUITE_P(CubesAndRandom, Threads, ::testing::Values(3, 7, 20, 0));

}  // namespace
}  // namespace mss

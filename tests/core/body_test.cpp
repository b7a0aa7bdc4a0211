// Counts, masses and rest states of bodies, from the lattice and from Algorithm 1's enumeration.
#include <gtest/gtest.h>

#include <limits>

#include "core/error.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

BodyConfig cube(int n) { return testing::test_config(VoxelGrid::box(n, n, n)); }

void expect_counts(int n, std::size_t particles, std::size_t springs) {
  const Body body(cube(n));
  const reference::Algorithm1 oracle(cube(n), Vec3::Zero(), 1);
  EXPECT_EQ(body.particle_count(), particles);
  EXPECT_EQ(body.spring_count(), springs);
  EXPECT_EQ(oracle.particles().size(), particles);
  EXPECT_EQ(oracle.springs().size(), springs);
}

TEST(Body, CountsParticlesAndSprings) {
  expect_counts(1, 8, 28);
  expect_counts(5, 216, 1940);
  expect_counts(7, 512, 5068);
}

TEST(Body, CountsFollowTheClosedForm) {
  for (int n = 1; n <= 9; ++n) {
    const auto m = std::size_t(n);
    const Body body(cube(n));
    EXPECT_EQ(body.particle_count(), (m + 1) * (m + 1) * (m + 1));
    EXPECT_EQ(body.spring_count(), 3 * m * (m + 1) * (m + 1) + 6 * m * m * (m + 1) + 4 * m * m * m);
  }
}

TEST(Body, AgreesWithTheOracleOnEveryShape) {
  for (const auto& shape : testing::test_shapes()) {
    const BodyConfig config = testing::test_config(shape.voxels);
    const Body body(config);
    const reference::Algorithm1 oracle(config, Vec3::Zero(), 1);
    ASSERT_EQ(body.particle_count(), oracle.particles().size()) << shape.name;
    EXPECT_EQ(body.spring_count(), oracle.springs().size()) << shape.name;
    double mass = 0;
    for (std::size_t id = 0; id < body.particle_count(); ++id) {
      const std::ptrdiff_t site = body.sites()[id];
      EXPECT_LT((body.rest_position(site) - oracle.particles()[id].x).norm(), 1e-14);
      EXPECT_NEAR(body.mass(site), oracle.particles()[id].mass, 1e-14 * body.total_mass());
      mass += body.mass(site);
    }
    EXPECT_NEAR(mass, body.total_mass(), 1e-12 * body.total_mass()) << shape.name;
  }
}

TEST(Body, CarriesWeightsThatParticlesShare) {
  BodyConfig config = cube(2);
  const Vec3 low = config.origin, high = low + Vec3::Constant(2 * config.cell_size);
  config.weights = {{{low, high}, 27}, {{high, high}, 1e6}, {{high + Vec3::Ones(), high + Vec3::Ones()}, 5}};
  const Body body(config), bare(cube(2));
  const reference::Algorithm1 oracle(config, Vec3::Zero(), 1);
  for (std::size_t id = 0; id < body.particle_count(); ++id) {
    const std::ptrdiff_t site = body.sites()[id];
    const double corner = id + 1 == body.particle_count() ? 1e6 : 0;
    EXPECT_NEAR(body.mass(site), bare.mass(site) + 1 + corner, 1e-12 * body.mass(site));
    EXPECT_NEAR(body.mass(site), oracle.particles()[id].mass, 1e-14 * body.mass(site));
  }
  EXPECT_NEAR(body.total_mass(), bare.total_mass() + 27 + 1e6, 1e-12 * body.total_mass());
}

TEST(Body, SelectsParticlesInAClosedBox) {
  const Body body(cube(3));
  const Vec3 lower = body.config().origin;
  EXPECT_EQ(body.select(lower, lower + Vec3(0, 0.6, 0.6)).size(), 16U);
  EXPECT_EQ(body.select(lower, lower + Vec3(0.2, 0.2, 0.2)).size(), 8U);
  EXPECT_TRUE(body.select(lower + Vec3::Constant(0.05), lower + Vec3::Constant(0.15)).empty());
}

TEST(Body, TopologiesDropTheirSprings) {
  BodyConfig config = cube(4);
  config.topology = Topology::edges_body;
  EXPECT_EQ(Body(config).spring_count(), 3U * 4 * 25 + 4 * 64);
  config.topology = Topology::one_diagonal;
  EXPECT_EQ(Body(config).spring_count(), 3U * 4 * 25 + 3 * 16 * 5 + 4 * 64);
}

/// Random fill factors for a third of the cells, half for all others.
BodyConfig partly_filled(const VoxelGrid& voxels) {
  BodyConfig config = testing::test_config(voxels);
  const auto [nx, ny, nz] = voxels.size();
  std::mt19937 rng(3);
  for (int cell = 0; cell < nx * ny * nz; ++cell)
    config.cell_fill.push_back(cell % 3 == 0 ? std::uniform_real_distribution<float>(0.1F, 1)(rng) : 0.5F);
  return config;
}

TEST(Fill, OfOneIsAFullCell) {
  for (const auto& shape : testing::test_shapes()) {
    BodyConfig config = testing::test_config(shape.voxels);
    const Body plain(config);
    const auto [nx, ny, nz] = shape.voxels.size();
    config.cell_fill.assign(std::size_t(nx * ny * nz), 1);
    const Body filled(config);
    for (const std::ptrdiff_t site : plain.sites()) {
      EXPECT_EQ(plain.mass(site), filled.mass(site));
      EXPECT_EQ(plain.elements_at(site).stiffness, filled.elements_at(site).stiffness);
      EXPECT_EQ(plain.elements_at(site).damping, filled.elements_at(site).damping);
    }
  }
}

TEST(Fill, ScalesSpringsVolumeForceAndMassAlike) {
  BodyConfig config = testing::test_config(VoxelGrid::box(3, 2, 2));
  const Body whole(config);
  config.cell_fill.assign(12, 0.25F);
  const Body quarter(config);
  EXPECT_DOUBLE_EQ(quarter.total_mass(), whole.total_mass() / 4);
  for (const std::ptrdiff_t site : whole.sites()) {
    const SiteElements &a = quarter.elements_at(site), &b = whole.elements_at(site);
    EXPECT_DOUBLE_EQ(quarter.mass(site), whole.mass(site) / 4);
    EXPECT_DOUBLE_EQ(a.volume, b.volume / 4);
    for (std::size_t s = 0; s < spring_slots.size(); ++s) {
      EXPECT_DOUBLE_EQ(a.stiffness[s], b.stiffness[s] / 4);
      EXPECT_DOUBLE_EQ(a.damping[s], b.damping[s] / 4);
    }
  }
}

// The energy is summed over springs and cells one by one, the force by the sweep.
TEST(Fill, ForcesAreTheGradientOfTheEnergy) {
  for (const auto& shape : testing::test_shapes()) {
    BodyConfig config = partly_filled(shape.voxels);
    config.damping = {};
    config.fold_guard = 3;
    const Body body(config);
    SpringSystem<double> system(body, {});
    State<double> state = system.rest_state();
    testing::randomise(body, state, 0.4, 0, 9);
    Field<double> force(system.size());
    system.force(0, state.x, state.v, force);
    const auto energy = [&] {
      const StoredEnergy e = system.stored_energy(state.x);
      return e.elastic + e.volume;
    };
    constexpr double step = 1e-6;
    for (std::size_t p = 0; p < body.particle_count(); p += 1 + body.particle_count() / 7)
      for (int axis = 0; axis < 3; ++axis) {
        double& x = state.x.axis(axis)[body.sites()[p]];
        const double at = x;
        x = at + step;
        const double above = energy();
        x = at - step;
        const double slope = (above - energy()) / (2 * step);
        x = at;
        EXPECT_NEAR(-slope, force.axis(axis)[body.sites()[p]], 1e-5 * force.array().abs().maxCoeff())
            << shape.name;
      }
  }
}

TEST(Fill, RejectsFactorsThatMeanNothing) {
  BodyConfig config = testing::test_config(VoxelGrid::box(2, 1, 1));
  for (const std::vector<float>& fill :
       {std::vector<float>{1}, {1, 0}, {1, -0.5F}, {1, 1.5F}, {1, std::numeric_limits<float>::quiet_NaN()}}) {
    config.cell_fill = fill;
    EXPECT_THROW(Body{config}, InputError);
  }
  config.cell_fill = {1, 0.5F};
  config.sharing = Sharing::uniform;
  EXPECT_THROW(Body{config}, InputError);
}

}  // namespace
}  // namespace mss

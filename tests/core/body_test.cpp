// Counts, masses and rest states of bodies, from the lattice and from Algorithm 1's enumeration.
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace mss

// Counts, masses and rest states of bodies, from the lattice and from Algorithm 1's enumeration.
#include <gtest/gtest.h>

#include <limits>

#include "core/base/error.hpp"
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

TEST(Fill, OfOneIsAFullCell) {
  for (const auto& shape : testing::test_shapes()) {
    BodyConfig config = testing::test_config(shape.voxels);
    const Body plain(config);
    const auto [nx, ny, nz] = shape.voxels.size();
    testing::fill_evenly(config, std::vector<float>(std::size_t(nx * ny * nz), 1));
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
  testing::fill_evenly(config, std::vector<float>(12, 0.25F));
  const Body quarter(config);
  EXPECT_DOUBLE_EQ(quarter.total_mass(), whole.total_mass() / 4);
  for (const std::ptrdiff_t site : whole.sites()) {
    const SiteElements a = quarter.elements_at(site), b = whole.elements_at(site);
    EXPECT_DOUBLE_EQ(quarter.mass(site), whole.mass(site) / 4);
    EXPECT_DOUBLE_EQ(a.volume, b.volume / 4);
    for (std::size_t s = 0; s < spring_slots.size(); ++s) {
      EXPECT_DOUBLE_EQ(a.stiffness[s], b.stiffness[s] / 4);
      EXPECT_DOUBLE_EQ(a.damping[s], b.damping[s] / 4);
    }
  }
}

TEST(Body, DampersHaveATimeInCommonWhereViscositiesAreAsShearModuliAre) {
  BodyConfig config{.voxels = VoxelGrid::box(2, 1, 1), .cell_size = 0.1};
  config.contents = {{PartFill{}}, {PartFill{.part = 1}}};
  config.content_of = {0, 1};
  config.springs = calibrate({.young = 1e5, .poisson = 0.3}, config.cell_size, 0.5);
  Part stiff{.name = "stiff", .springs = calibrate({.young = 3e5, .poisson = 0.3}, config.cell_size, 0.5)};
  config.parts = {stiff};
  EXPECT_EQ(Body(config).kinds().damping_time(), 0);
  config.damping = {.law = Damping::Law::viscosity, .viscosity = 20};
  stiff.damping = {.law = Damping::Law::viscosity, .viscosity = 60};
  config.parts = {stiff};
  const Body alike(config);
  ASSERT_TRUE(alike.kinds().damping_time());
  EXPECT_NEAR(*alike.kinds().damping_time(), 20 / (1e5 / 2.6), 1e-18);
  alike.for_each_spring([&](std::ptrdiff_t, std::ptrdiff_t, const SpringSlot&, double k, double c) {
    EXPECT_DOUBLE_EQ(c, k * 20 * 2.6 / 1e5);
  });
  config.parts.front().damping.viscosity = 61;
  EXPECT_FALSE(Body(config).kinds().damping_time());
  config.parts.front().damping = {.law = Damping::Law::ratio, .zeta = 0.1};
  EXPECT_FALSE(Body(config).kinds().damping_time());
}

TEST(Fill, RejectsContentsThatMeanNothing) {
  const auto reject = [](auto&& change, const char* message) {
    BodyConfig config = testing::test_config(VoxelGrid::box(2, 1, 1));
    testing::fill_evenly(config, {1, 0.5F});
    EXPECT_NO_THROW(Body{config});
    change(config);
    try {
      const Body body(config);
      ADD_FAILURE() << message;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  };
  reject([](BodyConfig& c) { c.content_of.pop_back(); }, "contents of 1 cells for a box of 2");
  reject([](BodyConfig& c) { c.content_of[1] = 2; }, "cell (1, 0, 0) has content 2 of 2");
  reject([](BodyConfig& c) { c.contents[1].clear(); }, "content 1 fills 0 of an octant");
  reject([](BodyConfig& c) { c.contents[1][0].part = 1; }, "content 1 is of part 1, and there are 1");
  reject(
      [](BodyConfig& c) {
        c.contents[1].push_back({0, CellFill::even(0.75F)});
      },
      "fills 1.25 of an octant");
  for (const float f : {-0.5F, std::numeric_limits<float>::quiet_NaN()}) {
    reject([&](BodyConfig& c) { c.contents[1][0].fill.octant[3] = f; }, "of an octant");
    reject([&](BodyConfig& c) { c.contents[1][0].fill.corner[3] = f; }, "of a mass");
  }
  reject([](BodyConfig& c) { c.sharing = Sharing::uniform; }, "sharing = \"weighted\"");
  reject(
      [](BodyConfig& c) {
        c.fill_blend_mass = 0;
        c.contents[1][0].fill.corner = {2, 0, 2, 0, 2, 0, 2, 0};
      },
      "a particle has no mass");
}

}  // namespace
}  // namespace mss

// The V-cycle at rest of quasi-Newton methods: its product is the tangent, it is symmetric and positive on
// any body, it solves, keeps momentum, and goes around what is held.
#include "integrators/linear/rest_cycle.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstring>

#include "core/base/error.hpp"
#include "core/refinement/refined_system.hpp"
#include "tests/random_bodies.hpp"
#include "tests/refined_bodies.hpp"

namespace mss {
namespace {

constexpr TangentCoefficients long_step{
    .mass = 1, .damping = 0.2, .stiffness = 0.04, .kind = Tangent::projected};

Field<double> random_vectors(const System<double>& system, unsigned seed) {
  Field<double> field(system.size());
  std::mt19937 rng(seed);
  std::uniform_real_distribution<> u(-1, 1);
  for (const std::ptrdiff_t site : system.particles()) field.set(site, Vec3(u(rng), u(rng), u(rng)));
  system.clear_prescribed(field);
  return field;
}

double product_of(const Field<double>& a, const Field<double>& b) { return (a.array() * b.array()).sum(); }

/// Ragged bodies of one material and of several with fills, nearly incompressible ones among them.
std::vector<std::pair<std::string, BodyConfig>> bodies() {
  std::vector<std::pair<std::string, BodyConfig>> all;
  for (const auto& [name, voxels] : testing::test_shapes()) {
    all.emplace_back(name, testing::test_config(voxels));
    all.emplace_back(name + "_mixed", testing::mixed_config(voxels, 2));
    all.emplace_back(name + "_incompressible", testing::test_config(voxels));
    all.back().second.springs.volume = 2e4;
  }
  return all;
}

Hold lower_end(const BodyConfig& config, std::array<bool, 3> axes = {true, true, true}) {
  return {.box = {config.origin, config.origin + Vec3(0, 100, 100)}, .axes = axes};
}

TEST(RestCycle, ItsProductIsTheTangentAtRest) {
  for (const auto& [name, config] : bodies()) {
    const Body body(config);
    SpringSystem<double> system(body, {});
    const std::vector<char> all(std::size_t(body.lattice().sites), 1);
    RestLevel level(body, {.unknown = {all, all, all}, .own = all});
    ASSERT_EQ(level.prepare(long_step), Status::ok);
    const Field<double> u = random_vectors(system, 3);
    Field<double> expected(system.size());
    const State<double> rest = system.rest_state();
    system.tangents()->product(0, rest.x, rest.v, long_step, u, expected);
    for (int axis = 0; axis < 3; ++axis)
      for (const std::ptrdiff_t site : body.sites()) {
        level.z()[axis][site] = float(u.axis(axis)[site]);
        level.r()[axis][site] = 0;
      }
    level.subtract_product([](std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task) {
      for (std::ptrdiff_t i = 0; i < count; ++i) task(i);
    });
    double error = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (const std::ptrdiff_t site : body.sites())
        error = std::max(error, std::abs(double(level.r()[axis][site]) + expected.axis(axis)[site]));
    EXPECT_LT(error, 2e-6 * expected.array().abs().maxCoeff()) << name;
  }
}

TEST(RestCycle, IsSymmetricAndPositive) {
  for (const auto& [name, config] : bodies())
    for (const bool held : {false, true}) {
      const Body body(config);
      Environment environment;
      if (held) environment.holds = {lower_end(config, {true, false, true})};
      SpringSystem<double> system(body, environment);
      State<double> state = system.rest_state();
      testing::randomise(body, state, 0.3, 0, 4);
      RestCycle cycle(system, "test");
      ASSERT_EQ(cycle.prepare(long_step), Status::ok);
      cycle.place(state.x);
      const Field<double> r = random_vectors(system, 1), s = random_vectors(system, 2);
      Field<double> hr(system.size()), hs(system.size());
      cycle.solve(r, 1, {}, hr);
      cycle.solve(s, 1, {}, hs);
      const double size = std::sqrt(product_of(r, hr) * product_of(s, hs));
      EXPECT_GT(product_of(r, hr), 0) << name;
      EXPECT_NEAR(product_of(s, hr), product_of(r, hs), 1e-5 * size) << name;
    }
}

/// By how much twenty corrections reduce a residual, in the directions that are free.
double reduction(System<double>& system, RestCycle& cycle, const Field<double>& x,
                 const std::vector<HeldParticle>& held) {
  const auto clear = [&](Field<double>& field) {
    system.clear_prescribed(field);
    for (const HeldParticle& particle : held) {
      const Vec3 value = field.at(particle.site);
      field.set(particle.site, value - particle.directions * value);
    }
  };
  Field<double> r = random_vectors(system, 5), z(system.size()), image(system.size());
  clear(r);
  const double before = std::sqrt(product_of(r, r));
  for (int i = 0; i < 20; ++i) {
    cycle.solve(r, 1, {}, z);
    system.tangents()->product(0, x, x, long_step, z, image);
    r.array() -= image.array();
    clear(r);
  }
  return std::sqrt(product_of(r, r)) / before;
}

TEST(RestCycle, SolvesWithTheTangentOfTurnedBodies) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(2, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  for (const auto& [name, config] : bodies()) {
    if (name.find("random") != std::string::npos) continue;  // cells that hang by a corner
    const Body body(config);
    SpringSystem<double> system(body, {});
    Field<double> x(system.size());
    for (const std::ptrdiff_t site : body.sites()) x.set(site, turn * body.rest_position(site));
    RestCycle cycle(system, "test");
    ASSERT_EQ(cycle.prepare(long_step), Status::ok);
    EXPECT_FALSE(reduction(system, cycle, x, {}) < 0.05) << name;  // that of a body that has not turned
    cycle.place(x);
    EXPECT_LT(reduction(system, cycle, x, {}), name.find("incompr") == std::string::npos ? 1e-4 : 0.05)
        << name;
  }
}

TEST(RestCycle, GoesAroundWhatPlanesHold) {
  const BodyConfig config = testing::test_config(VoxelGrid::box(12, 12, 12));
  const Body body(config);
  SpringSystem<double> system(body, {});
  const State<double> rest = system.rest_state();
  RestCycle cycle(system, "test");
  ASSERT_EQ(cycle.prepare(long_step), Status::ok);
  cycle.place(rest.x);
  const Vec3 normal = Vec3(0.3, -0.4, 1).normalized();
  std::vector<HeldParticle> held;
  for (const std::ptrdiff_t site : body.select(config.origin, config.origin + Vec3(100, 100, 0))) {
    const bool sticks = body.lattice().coordinates(site)[0] < 4;
    held.push_back({site, sticks ? Eigen::Matrix3d::Identity() : Eigen::Matrix3d(normal * normal.transpose()),
                    Eigen::Matrix3d::Zero()});
  }
  cycle.hold(held);
  EXPECT_LT(reduction(system, cycle, rest.x, held), 1e-4);

  // What is held takes the values it is given, and the rest gives way to them.
  Field<double> values(system.size()), z(system.size()), image(system.size());
  for (const HeldParticle& particle : held)
    values.set(particle.site, particle.directions * Vec3(0.1, 0.2, -0.3));
  cycle.solve(Field<double>(system.size()), 1, values, z);
  for (const HeldParticle& particle : held)
    EXPECT_LT((particle.directions * z.at(particle.site) - values.at(particle.site)).norm(), 1e-7);
  const auto forces = [&](const Field<double>& u) {
    system.tangents()->product(0, rest.x, rest.x, long_step, u, image);
    for (const HeldParticle& particle : held) image.set(particle.site, Vec3::Zero());
    return std::sqrt(product_of(image, image));
  };
  EXPECT_LT(forces(z), 0.3 * forces(values));

  cycle.hold({});
  EXPECT_LT(reduction(system, cycle, rest.x, {}), 1e-4);
}

TEST(RestCycle, CountsFrictionAmongMasses) {
  const BodyConfig config = testing::test_config(VoxelGrid::box(8, 8, 8));
  const Body body(config);
  SpringSystem<double> system(body, {});
  const State<double> rest = system.rest_state();
  RestCycle cycle(system, "test");
  ASSERT_EQ(cycle.prepare(long_step), Status::ok);
  std::vector<HeldParticle> held;
  for (const std::ptrdiff_t site : body.select(config.origin, config.origin + Vec3(100, 100, 0)))
    held.push_back({site, Vec3(0, 0, 1) * Vec3(0, 0, 1).transpose(),
                    3000 * Eigen::Matrix3d(Vec3(0, 1, 0) * Vec3(0, 1, 0).transpose())});
  const auto left = [&] {
    Field<double> r = random_vectors(system, 5), z(system.size()), image(system.size());
    for (const HeldParticle& particle : held)
      r.set(particle.site, r.at(particle.site) - particle.directions * r.at(particle.site));
    const double before = std::sqrt(product_of(r, r));
    for (int i = 0; i < 20; ++i) {
      cycle.solve(r, 1, {}, z);
      system.tangents()->product(0, rest.x, rest.v, long_step, z, image);
      r.array() -= image.array();
      for (const HeldParticle& particle : held) {
        const Vec3 value = r.at(particle.site) - particle.friction * z.at(particle.site);
        r.set(particle.site, value - particle.directions * value);
      }
    }
    return std::sqrt(product_of(r, r)) / before;
  };
  cycle.hold(held);
  EXPECT_LT(left(), 1e-4);
}

// In cells twice as large there is no unknown, and none that friction could act on.
TEST(RestCycle, TakesFrictionWhereCoarserCellsArePrescribed) {
  const BodyConfig config = testing::test_config(VoxelGrid::box(4, 2, 2));
  const Body body(config);
  const double h = config.cell_size;
  const Hold middle{.box = {config.origin + Vec3(h, 0, 0), config.origin + Vec3(3 * h, 100, 100)}};
  SpringSystem<double> system(body, {.holds = {middle}});
  RestCycle cycle(system, "test");
  ASSERT_EQ(cycle.prepare(long_step), Status::ok);
  cycle.place(system.rest_state().x);
  const Field<double> r = random_vectors(system, 5);
  Field<double> free(system.size()), rubbed(system.size());
  cycle.solve(r, 1, {}, free);
  std::vector<HeldParticle> held;
  for (const std::ptrdiff_t site : body.select(config.origin, config.origin + Vec3(0, 100, 100)))
    held.push_back({site, Eigen::Matrix3d::Zero(), 3000 * Eigen::Matrix3d::Identity()});
  ASSERT_EQ(held.size(), 9U);
  cycle.hold(held);
  cycle.solve(r, 1, {}, rubbed);
  EXPECT_GT(product_of(r, rubbed), 0);
  EXPECT_LT(product_of(r, rubbed), product_of(r, free));
}

TEST(RestCycle, KeepsTheMomentumOfEveryPieceThatNothingHolds) {
  VoxelGrid voxels(13, 5, 5);
  for (int k = 0; k < 5; ++k)
    for (int j = 0; j < 5; ++j)
      for (int i = 0; i < 13; ++i) voxels.set(i, j, k, i < 6 || i > 6);
  const BodyConfig config = testing::test_config(voxels);
  const Body body(config);
  SpringSystem<double> system(body, {.holds = {lower_end(config, {true, true, false})}});
  State<double> state = system.rest_state();
  testing::randomise(body, state, 0.2, 0, 4);
  RestCycle cycle(system, "test");
  ASSERT_EQ(cycle.prepare(long_step), Status::ok);
  cycle.place(state.x);
  const Field<double> r = random_vectors(system, 5);
  Field<double> z(system.size()), v(system.size());
  cycle.solve(r, 1, {}, z);
  std::array<Vec3, 2> momentum{Vec3::Zero(), Vec3::Zero()}, given = momentum;
  for (const std::ptrdiff_t site : body.sites()) {
    const std::size_t piece = body.lattice().coordinates(site)[0] > 6;
    momentum[piece] += body.mass(site) * z.at(site);
    given[piece] += r.at(site);
  }
  EXPECT_LT((momentum[1] - given[1]).norm(), 1e-13 * double(body.particle_count()));
  EXPECT_NEAR(momentum[0][2], given[0][2], 1e-13 * double(body.particle_count()));  // it slides along z
  cycle.add_where_free(Vec3(1, 2, 3), v);
  for (const std::ptrdiff_t site : body.sites())
    EXPECT_EQ(v.at(site), body.lattice().coordinates(site)[0] > 6 ? Vec3(1, 2, 3) : Vec3(0, 0, 3));
}

// Half a turn in one go: straight paths would leave a plane.
TEST(MergedCells, AreAsHeavyStiffAndViscousAsWhatTheyReplace) {
  for (const testing::RefinedCase& of : testing::refined_cases()) {
    const RefinedBody body = of.make();
    EXPECT_NEAR(Body(merged_cells(body, 0).config).total_mass(), body.total_mass(), 1e-6 * body.total_mass())
        << of.name;
    // All cells split once more are those of a body with such cells, merged.
    const RefinedBody split(of.config,
                            refinement_of(of.config, {{{Vec3::Constant(-100), Vec3::Constant(100)}, 1}}));
    ASSERT_EQ(split.levels().size(), 1U);
    const Body merged(merged_cells(split, 0).config), expected(coarsened(split.levels()[0].body.config()));
    for (const std::ptrdiff_t site : expected.sites()) {
      EXPECT_NEAR(merged.mass(site), expected.mass(site), 1e-6 * expected.mass(site));
      const SiteElements a = merged.elements_at(site), b = expected.elements_at(site);
      EXPECT_NEAR(a.volume, b.volume, 1e-6 * std::abs(b.volume));
      for (std::size_t s = 0; s < spring_slots.size(); ++s) {
        EXPECT_NEAR(a.stiffness[s], b.stiffness[s], 1e-6 * b.stiffness[s]) << of.name;
        EXPECT_NEAR(a.damping[s], b.damping[s], 1e-6 * b.damping[s]) << of.name;
      }
    }
  }
}

// Where cells of two sizes meet, holds end beside them and bodies have turned.
TEST(RestCycle, IsSymmetricAndPositiveOnCellsOfSeveralSizes) {
  for (const testing::RefinedCase& of : testing::refined_cases())
    for (const bool held : {false, true})
      for (const Cycle kind : {Cycle::v, Cycle::additive}) {
        const RefinedBody body = of.make();
        const Vec3 low = of.config.origin;
        Environment environment;
        if (held)
          environment.holds = {{.box = {low, low + Vec3(0, 0.3, 0.3)}, .axes = {true, false, true}},
                               {.box = {low + Vec3(0.3, 0.1, 0.1), low + Vec3(0.3, 0.1, 0.1)}}};
        RefinedSystem<double> system(body, environment);
        State<double> state = system.rest_state();
        std::mt19937 rng(4);
        std::uniform_real_distribution<> move(-0.03, 0.03);
        for (const std::ptrdiff_t site : system.particles())
          state.x.set(site, state.x.at(site) + Vec3(move(rng), move(rng), move(rng)));
        system.constrain(0, state.x, state.v);
        RestCycle cycle(system, "test", kind);
        ASSERT_EQ(cycle.prepare(long_step), Status::ok);
        cycle.place(state.x);
        const Field<double> r = random_vectors(system, 1), s = random_vectors(system, 2);
        Field<double> hr(system.size()), hs(system.size());
        cycle.solve(r, 1, {}, hr);
        cycle.solve(s, 1, {}, hs);
        const double size = std::sqrt(product_of(r, hr) * product_of(s, hs));
        EXPECT_GT(product_of(r, hr), 0) << of.name;
        EXPECT_NEAR(product_of(s, hr), product_of(r, hs), 1e-5 * size) << of.name;
        Field<double> cleared = hr;
        system.clear_prescribed(cleared);
        EXPECT_EQ(product_of(cleared, cleared), product_of(hr, hr)) << of.name;
        for (const std::ptrdiff_t site : system.particles())  // every unknown moves
          EXPECT_TRUE((hr.at(site).array() != 0 || r.at(site).array() == 0).all()) << of.name;
      }
}

TEST(RestCycle, SolvesWithTheTangentOfCellsOfSeveralSizes) {
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(2, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  for (const testing::RefinedCase& of : testing::refined_cases()) {
    const RefinedBody body = of.make();
    RefinedSystem<double> system(body, {});
    State<double> state = system.rest_state();
    for (const std::ptrdiff_t site : system.particles()) state.x.set(site, turn * state.x.at(site));
    system.constrain(0, state.x, state.v);
    RestCycle cycle(system, "test");
    ASSERT_EQ(cycle.prepare(long_step), Status::ok);
    cycle.place(state.x);
    EXPECT_LT(reduction(system, cycle, state.x, {}), 1e-4) << of.name;
    cycle.place_stiffly(state.x);
    EXPECT_LT(reduction(system, cycle, state.x, {}), 1e-4) << of.name;
  }
}

// In small cells, in large ones and where they meet.
TEST(RestCycle, GoesAroundWhatPlanesHoldOfCellsOfSeveralSizes) {
  for (const testing::RefinedCase& of : testing::refined_cases()) {
    const RefinedBody body = of.make();
    RefinedSystem<double> system(body, {});
    const State<double> rest = system.rest_state();
    RestCycle cycle(system, "test");
    ASSERT_EQ(cycle.prepare(long_step), Status::ok);
    cycle.place(rest.x);
    const Vec3 normal = Vec3(0.3, -0.4, 1).normalized();
    std::vector<HeldParticle> held;
    for (const std::ptrdiff_t site : system.particles()) {
      if (rest.x.at(site)[2] > of.config.origin[2] + 1e-9) continue;
      const bool sticks = rest.x.at(site)[1] < of.config.origin[1] + 0.31;
      held.push_back({site,
                      sticks ? Eigen::Matrix3d::Identity() : Eigen::Matrix3d(normal * normal.transpose()),
                      Eigen::Matrix3d::Zero()});
    }
    cycle.hold(held);
    EXPECT_LT(reduction(system, cycle, rest.x, held), 1e-4) << of.name;
    Field<double> values(system.size()), z(system.size()), image(system.size());
    for (const HeldParticle& particle : held)
      values.set(particle.site, particle.directions * Vec3(0.1, 0.2, -0.3));
    cycle.solve(Field<double>(system.size()), 1, values, z);
    for (const HeldParticle& particle : held)
      EXPECT_LT((particle.directions * z.at(particle.site) - values.at(particle.site)).norm(), 1e-7);
    const auto forces = [&](const Field<double>& u) {
      system.tangents()->product(0, rest.x, rest.v, long_step, u, image);
      for (const HeldParticle& particle : held) image.set(particle.site, Vec3::Zero());
      return std::sqrt(product_of(image, image));
    };
    EXPECT_LT(forces(z), 0.3 * forces(values)) << of.name;
    cycle.hold({});
    EXPECT_LT(reduction(system, cycle, rest.x, {}), 1e-4) << of.name;
  }
}

TEST(RestCycle, BendsPathsOfWhatSpins) {
  const Body body(testing::test_config(VoxelGrid::box(5, 4, 3)));
  SpringSystem<double> free(body, {}),
      held(body, {.holds = {lower_end(body.config(), {true, false, false})}});
  const State<double> rest = free.rest_state();
  const Vec3 travel(1, -2, 0.5), turn = 3 * Vec3(1, 2, 2).normalized();
  Vec3 centre = Vec3::Zero();
  for (const std::ptrdiff_t site : body.sites())
    centre += body.mass(site) / body.total_mass() * rest.x.at(site);
  Field<double> v(free.size());
  for (const std::ptrdiff_t site : body.sites()) v.set(site, travel + turn.cross(rest.x.at(site) - centre));
  const Field<double> straight = v;
  const double seconds = 0.5;
  RestCycle(held, "test").bend_paths(rest.x, seconds, v);
  EXPECT_EQ(std::memcmp(v.axis(0), straight.axis(0), std::size_t(v.size()) * sizeof(double)), 0);
  RestCycle(free, "test").bend_paths(rest.x, seconds, v);
  const Eigen::AngleAxisd turned(seconds * turn.norm(), turn.normalized());
  for (const std::ptrdiff_t site : body.sites())
    EXPECT_LT((rest.x.at(site) + seconds * v.at(site) - centre - seconds * travel -
               turned * (rest.x.at(site) - centre))
                  .norm(),
              1e-12);
}

TEST(RestCycle, TurnsPiecesAsWholesWhereAsked) {
  const BodyConfig config = testing::test_config(VoxelGrid::box(4, 4, 12));
  const Body body(config);
  SpringSystem<double> system(body, {});
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(2, Vec3(1, 2, -1).normalized()).toRotationMatrix();
  Field<double> x(system.size());
  for (const std::ptrdiff_t site : body.sites()) x.set(site, turn * body.rest_position(site));
  RestCycle cycle(system, "test");
  ASSERT_EQ(cycle.prepare(long_step), Status::ok);
  cycle.place_stiffly(x);
  EXPECT_LT(reduction(system, cycle, x, {}), 1e-4);
}

TEST(RestCycle, GivesTheSameBitsForAnyNumberOfThreads) {
  const Body body(testing::mixed_config(VoxelGrid::box(11, 12, 13), 3));
  const auto solve = [&](int threads) {
    SpringSystem<double> system(body, {}, {.threads = threads});
    State<double> state = system.rest_state();
    testing::randomise(body, state, 0.2, 0, 4);
    RestCycle cycle(system, "test");
    EXPECT_EQ(cycle.prepare(long_step), Status::ok);
    cycle.place(state.x);
    Field<double> z(system.size());
    cycle.solve(random_vectors(system, 3), 1, {}, z);
    return z;
  };
  const Field<double> one = solve(1);
  for (const int threads : {2, 3, 5}) {
    const Field<double> other = solve(threads);
    EXPECT_EQ(std::memcmp(one.axis(0), other.axis(0), std::size_t(one.size()) * sizeof(double)), 0)
        << threads;
  }
}

// Rows of every length up to some more than two vectors: where a row's last vector ends beyond it.
TEST(RestCycle, AllInstructionSetsAgree) {
  for (int n = 6; n < 50; n += n < 20 ? 1 : 7) {
    BodyConfig config = testing::test_config(VoxelGrid::box(n, 2 + n % 3, 3 + n % 2));
    const Body fine(config), coarse(coarsened(config));
    const Lattice &from = coarse.lattice(), &to = fine.lattice();
    const RestTransfer transfer{{to.cells[0], to.cells[1], to.cells[2]},
                                {from.cells[0], from.cells[1], from.cells[2]},
                                to.row,
                                to.plane,
                                from.row,
                                from.plane};
    PaddedArrays u(from, 1), r(to, 1), scratch(to, 1);
    std::mt19937 rng{unsigned(n)};
    std::uniform_real_distribution<float> random(-1, 1);
    for (const std::ptrdiff_t site : coarse.sites()) u[0][site] = random(rng);
    for (const std::ptrdiff_t site : fine.sites()) r[0][site] = random(rng);
    for (const RestKernels& kernels : runnable_copies<RestKernels>()) {
      PaddedArrays d(to, 1), z(to, 1), restricted(from, 1);
      for (int plane = 0; plane < to.planes(); ++plane)
        kernels.interpolate_plane(transfer, u[0], d[0], z[0], plane, scratch[0]);
      for (int plane = 0; plane < from.planes(); ++plane)
        kernels.restrict_plane(transfer, r[0], restricted[0], plane, scratch[0]);
      double up = 0, down = 0;
      for (const std::ptrdiff_t site : fine.sites()) {
        const std::array<int, 3> at = to.coordinates(site);
        float expected = 0;
        for (int c = 0; c < 8; ++c)
          expected += 0.125F * u[0][from.site((at[0] + corner_bit(c, 0)) / 2, (at[1] + corner_bit(c, 1)) / 2,
                                              (at[2] + corner_bit(c, 2)) / 2)];
        EXPECT_NEAR(d[0][site], expected, 1e-6) << kernels.name << " " << n;
        EXPECT_EQ(d[0][site], z[0][site]);
        up += double(d[0][site]) * double(r[0][site]);
      }
      for (const std::ptrdiff_t site : coarse.sites())
        down += double(u[0][site]) * double(restricted[0][site]);
      EXPECT_NEAR(up, down, 1e-4) << kernels.name << " " << n;
    }
  }
}

TEST(RestCycle, NeedsABodyOfCells) {
  class NoCells final : public System<double> {
   public:
    std::ptrdiff_t size() const override { return 1; }
    const std::vector<std::ptrdiff_t>& particles() const override { return sites_; }
    double mass(std::ptrdiff_t) const override { return 1; }
    void force(double, const Field<double>&, const Field<double>&, Field<double>&) override {}

   private:
    std::vector<std::ptrdiff_t> sites_{0};
  } system;
  EXPECT_THROW(RestCycle(system, "lbfgs"), InputError);
}

}  // namespace
}  // namespace mss

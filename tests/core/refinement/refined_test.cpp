// Bodies with cells of several sizes: which cells are split, hanging particles, and the forces and motion of
// the whole, against bodies with cells of one size.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <set>

#include "core/base/error.hpp"
#include "core/refinement/local_steps.hpp"
#include "core/refinement/refined_system.hpp"
#include "integrators/analysis/modes.hpp"
#include "tests/body_derivatives.hpp"
#include "tests/driven.hpp"

namespace mss {
namespace {

constexpr ElasticConstants refined_rubber{.young = 1e5, .poisson = 0.3};

BodyConfig block(int nx, int ny, int nz, double cell_size, double face_share = 0.5) {
  BodyConfig config{
      .voxels = VoxelGrid::box(nx, ny, nz), .cell_size = cell_size, .origin = Vec3(0.1, -0.2, 0.3)};
  config.fill(refined_rubber, face_share);
  return config;
}

/// Boxes in cells, from the lower corner of the body.
RefinedBox refined_cells(const BodyConfig& body, const Vec3& lower, const Vec3& upper, int levels = 1) {
  return {{body.origin + body.cell_size * lower, body.origin + body.cell_size * upper}, levels};
}
RefinedBody refine(const BodyConfig& body, const std::vector<RefinedBox>& boxes) {
  return {body, refinement_of(body, boxes)};
}

/// Two levels in a block's corner and one in its middle.
RefinedBody corner_and_middle(const BodyConfig& body) {
  return refine(body,
                {refined_cells(body, {0, 0, 0}, {1, 1, 1}, 2), refined_cells(body, {1, 1, 1}, {2, 3, 2})});
}

bool is_on_surface(const BodyConfig& body, const Vec3& at) {
  const Vec3 size = body.cell_size * Vec3(body.voxels.nx(), body.voxels.ny(), body.voxels.nz());
  const Eigen::Array3d from_lower = (at - body.origin).array(), from_upper = size.array() - from_lower;
  return from_lower.min(from_upper).minCoeff() < 1e-9;
}

TEST(Refinement, CellsThatTouchDifferByOneDepthAtMost) {
  VoxelGrid voxels = VoxelGrid::box(3, 3, 2);
  voxels.set(2, 0, 0, false);
  RefinementMap map;
  map.split(4, {17, 20, 3});
  map.balance(voxels);
  struct Leaf {
    Eigen::Array3i lower;  ///< in sixteenths of a half
    int edge;
  };
  std::vector<Leaf> leaves;
  double volume = 0;
  for (int depth = 0; depth <= 5; ++depth) {
    const int count = 1 << depth, edge = 32 >> depth;
    for (int k = 0; k < 2 * count; ++k)
      for (int j = 0; j < 3 * count; ++j)
        for (int i = 0; i < 3 * count; ++i) {
          const bool exists = has_cell(voxels, depth, {i, j, k}) &&
                              (depth == 0 || map.is_split(depth - 1, {i / 2, j / 2, k / 2}));
          if (!exists || map.is_split(depth, {i, j, k})) continue;
          leaves.push_back({edge * Eigen::Array3i(i, j, k), edge});
          volume += std::pow(edge, 3);
        }
  }
  EXPECT_EQ(volume, 17 * std::pow(32, 3));
  for (const Leaf& a : leaves)
    for (const Leaf& b : leaves) {
      const bool touch = (a.lower + a.edge >= b.lower).all() && (b.lower + b.edge >= a.lower).all();
      EXPECT_TRUE(!touch || a.edge <= 2 * b.edge);
    }
}

TEST(RefinedBody, HangingParticlesLieAmidMastersThatMove) {
  const RefinedBody body = corner_and_middle(block(3, 4, 3, 0.2));
  ASSERT_EQ(body.levels().size(), 3U);
  std::set<std::size_t> counts;
  for (const HangingParticle& p : body.hanging()) {
    Vec3 mean = Vec3::Zero();
    for (std::size_t m = 0; m < p.count; ++m) {
      mean += p.weight() * body.levels()[p.level - 1].body.rest_position(p.masters[m]);
      EXPECT_GT(body.mass(body.site_in_field(p.level - 1, p.masters[m])), 0);
    }
    EXPECT_LT((mean - body.levels()[p.level].body.rest_position(p.site)).norm(), 1e-15);
    EXPECT_EQ(body.mass(body.site_in_field(p.level, p.site)), 0);
    counts.insert(p.count);
  }
  EXPECT_EQ(counts, (std::set<std::size_t>{1, 2, 4}));
}

TEST(RefinedBody, HasTheMassAndCentreOfItsCells) {
  const BodyConfig config = block(3, 4, 3, 0.2);
  const RefinedBody body = corner_and_middle(config);
  const RefinedSystem<double> system(body, {});
  double mass = 0;
  Vec3 moment = Vec3::Zero();
  for (const std::ptrdiff_t site : system.particles()) {
    mass += system.mass(site);
    moment += system.mass(site) * system.rest_position(site);
  }
  EXPECT_NEAR(mass, 36 * 8, 36 * 8e-15 * 10);
  EXPECT_NEAR(system.total_mass(), mass, 1e-15 * 10 * mass);
  const Vec3 centre = config.origin + 0.1 * Vec3(3, 4, 3);
  EXPECT_LT((moment / mass - centre).norm(), 1e-14);
}

TEST(RefinedBody, WhollySplitIsTheBodyOfSmallerCells) {
  const BodyConfig coarse = block(3, 2, 2, 0.2), fine = block(6, 4, 4, 0.1);
  const RefinedBody split = refine(coarse, {refined_cells(coarse, {0, 0, 0}, {3, 2, 2})});
  ASSERT_EQ(split.levels().size(), 1U);
  EXPECT_TRUE(split.hanging().empty());
  const Body body(fine);
  const Environment environment{.gravity = Vec3(0, 0, -9.8)};
  RefinedSystem<double> refined(split, environment);
  SpringSystem<double> springs(body, environment);
  State<double> state = springs.rest_state();
  testing::randomise(body, state, 0.1, 1, 3);
  Field<double> a(springs.size()), b(springs.size());
  refined.acceleration(0, state.x, state.v, a);
  springs.acceleration(0, state.x, state.v, b);
  for (const std::ptrdiff_t site : body.sites())
    EXPECT_LT((a.at(site) - b.at(site)).norm(), 1e-12 * b.array().abs().maxCoeff());
}

/// Largest force on a particle inside a body under a large affine deformation, over the largest on the
/// surface, and how many particles have more than rounding.
struct Patch {
  double residual;
  int count;
};
Patch patch(const BodyConfig& config, const RefinedBody& body) {
  RefinedSystem<double> system(body, {});
  State<double> state = system.rest_state();
  Eigen::Matrix3d stretch;
  stretch << 1.2, 0.3, -0.1, 0.05, 0.9, 0.2, -0.15, 0.1, 1.1;
  for (const Level& level : body.levels())
    for (const std::ptrdiff_t site : level.body.sites())
      state.x.set(level.first + site, stretch * level.body.rest_position(site));
  Field<double> f(system.size());
  system.force(0, state.x, state.v, f);
  double inside = 0, outside = 0;
  int count = 0;
  for (const std::ptrdiff_t site : system.particles()) {
    const double force = f.at(site).norm();
    if (is_on_surface(config, system.rest_position(site))) {
      outside = std::max(outside, force);
      continue;
    }
    inside = std::max(inside, force);
    if (force > 1e-9 * config.cell_size * config.cell_size * refined_rubber.young) ++count;
  }
  return {inside / outside, count};
}

TEST(RefinedSystem, UniformStrainIsAnEquilibriumWithEdgesAndFaces) {
  for (const double poisson : {0.25, 0.4}) {  // without and with volume force
    BodyConfig config = block(5, 5, 5, 0.2, 1);
    config.fill({.young = 1e5, .poisson = poisson}, 1);
    const auto [residual, count] =
        patch(config, refine(config, {refined_cells(config, {2, 2, 2}, {3, 3, 3}, 2),
                                      refined_cells(config, {3, 1, 2}, {4, 2, 3})}));
    EXPECT_LT(residual, 1e-13);
    EXPECT_EQ(count, 0);
  }
}

TEST(RefinedSystem, BodyDiagonalsLeaveForcesAtTheCornersOfABlockAlone) {
  const BodyConfig config = block(4, 4, 4, 0.2);
  const auto [residual, count] = patch(config, refine(config, {refined_cells(config, {1, 1, 1}, {3, 3, 3})}));
  EXPECT_EQ(count, 8);
  EXPECT_GT(residual, 0.01);
  EXPECT_LT(residual, 0.1);
}

Environment everything() {
  return {.gravity = Vec3(1, -2, -9.8),
          .holds = {},
          .loads = {{.box = {Vec3(0.1, -0.2, 0.3), Vec3(0.3, 0.6, 0.3)}, .force = Vec3(3, 2, -20)}},
          .planes = {{.point = Vec3(0, 0, 0.31), .contact = ContactLaw::penalty}}};
}

TEST(RefinedSystem, ForcesAreTheEnergysGradientAndTangentsTheForces) {
  BodyConfig config = block(2, 2, 2, 0.2);
  config.damping = {.law = Damping::Law::viscosity, .viscosity = 20};
  const RefinedBody body = refine(config, {refined_cells(config, {0, 0, 0}, {1, 1, 1})});
  RefinedSystem<double> system(body, everything());
  State<double> state = system.rest_state();
  testing::randomise(system, state, 0.1, 1, 5);
  State<double> still = state;
  still.v.array() = 0;
  testing::compare_forces_with_energy(system, still);
  testing::compare_tangents_with_forces(system, state);
}

TEST(RefinedSystem, HeldCoordinatesAreNoUnknowns) {
  const BodyConfig config = block(2, 2, 2, 0.2);
  const RefinedBody body = refine(config, {refined_cells(config, {0, 0, 0}, {1, 2, 1})});
  Environment environment = everything();
  environment.holds = {{.box = {Vec3(0, -1, 0.3), Vec3(1, 1, 0.3)}, .axes = {true, false, true}}};
  RefinedSystem<double> system(body, environment);
  State<double> state = system.rest_state();
  testing::randomise(system, state, 0.1, 1, 5);
  const Eigen::MatrixXd expected = testing::force_differences(system, state, true, 1e-3 * system.cell_size());
  EXPECT_LT(testing::relative_difference(testing::tangent_matrix(system, state, {.stiffness = 1}), expected),
            1e-4);
}

TEST(RefinedSystem, LoadsAreWholeAndEvenOnAFace) {
  const BodyConfig config = block(2, 2, 2, 0.2);
  const RefinedBody body = refine(config, {refined_cells(config, {0, 0, 0}, {1, 2, 2})});
  const Vec3 force(3, 2, -20);
  const Environment environment{.loads = {{.box = {Vec3(0, -1, 0.7), Vec3(1, 1, 0.7)}, .force = force}}};
  RefinedSystem<double> system(body, environment);
  const State<double> rest = system.rest_state();
  Field<double> f(system.size());
  system.force(0, rest.x, rest.v, f);
  Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
  for (const std::ptrdiff_t site : system.particles()) {
    sum += f.at(site);
    moment += system.rest_position(site).cross(f.at(site));
  }
  EXPECT_LT((sum - force).norm(), 1e-13 * force.norm());
  const Vec3 middle = config.origin + Vec3(0.2, 0.2, 0.4);
  EXPECT_LT((moment - middle.cross(force)).norm(), 1e-13 * force.norm());
}

TEST(RefinedSystem, RefusesToHoldAHangingParticleWithoutItsMasters) {
  const BodyConfig config = block(2, 2, 2, 0.2);
  const RefinedBody body = refine(config, {refined_cells(config, {0, 0, 0}, {1, 2, 2})});
  const Vec3 amid_edge = config.origin + Vec3(0.2, 0.1, 0);
  const auto system_with = [&](const Box& box) { RefinedSystem<double>(body, {.holds = {{.box = box}}}); };
  EXPECT_THROW(system_with({amid_edge, amid_edge}), InputError);
  EXPECT_NO_THROW(system_with({amid_edge - Vec3(0, 0.1, 0), amid_edge + Vec3(0, 0.1, 0)}));
}

TEST(RefinedSystem, ConservesMomentumAndSpinWithAnyNumberOfThreads) {
  BodyConfig config = block(4, 3, 5, 0.2);
  config.damping = {.law = Damping::Law::viscosity, .viscosity = 5};
  const RefinedBody body = corner_and_middle(config);
  std::vector<State<double>> ends;
  for (const int threads : {1, 2, 3}) {
    RefinedSystem<double> system(body, {}, {.threads = threads});
    State<double> state = system.rest_state();
    testing::randomise(system, state, 0.05, 0, 3);
    for (const Level& level : body.levels())
      for (const std::ptrdiff_t site : level.body.sites())
        state.v.set(level.first + site,
                    Vec3(1, 2, 3) + 3 * Vec3(2, -1, 4).cross(level.body.rest_position(site)));
    const Measures before = measure(system, state);
    Work work;
    const double dt = 0.3 / system.spectral_bound().omega;
    ASSERT_EQ(find_integrator("verlet").make<double>({.dt = dt})->advance(system, state, 200 * dt, work),
              Status::ok);
    const Measures after = measure(system, state);
    EXPECT_GT(std::abs(after.elastic - before.elastic), 0.01 * before.elastic);
    EXPECT_LT((after.momentum - before.momentum).norm(), 1e-12 * before.momentum.norm());
    EXPECT_LT((after.angular_momentum - before.angular_momentum).norm(),
              1e-12 * before.angular_momentum.norm());
    ends.push_back(state);
  }
  for (const std::ptrdiff_t site : body.sites())
    for (const State<double>& other : ends) {
      EXPECT_EQ(other.x.at(site), ends[0].x.at(site));
      EXPECT_EQ(other.v.at(site), ends[0].v.at(site));
    }
}

TEST(RefinedSystem, NoModeIsFasterThanOfTheBodyOfTheSmallestCells) {
  const BodyConfig config = block(3, 3, 3, 0.2);
  const RefinedBody body = refine(config, {refined_cells(config, {0, 0, 0}, {1, 2, 1}, 2)});
  RefinedSystem<double> system(body, {});
  const Body uniform(block(12, 12, 12, 0.05));
  SpringSystem<double> fine(uniform, {});
  Work work;
  const Modes fastest = fastest_mode(system, system.rest_state(), work),
              uniform_fastest = fastest_mode(fine, fine.rest_state(), work);
  EXPECT_LE(fastest.modes[0].omega, uniform_fastest.modes[0].omega * (1 + 1e-6));
  EXPECT_GT(fastest.modes[0].omega, 0.9 * uniform_fastest.modes[0].omega);
  EXPECT_LE(fastest.modes[0].omega, system.spectral_bound().omega);
  EXPECT_DOUBLE_EQ(system.spectral_bound().omega, fine.spectral_bound().omega);
}

TEST(RefinedSystem, IsDrivenByEveryIntegrator) {
  const BodyConfig config = block(2, 2, 2, 0.2);
  const RefinedBody body = refine(config, {refined_cells(config, {0, 0, 0}, {1, 2, 1})});
  Environment environment = everything();
  environment.holds = {{.box = {Vec3(0, -1, 0.7), Vec3(1, 1, 0.7)}, .velocity = Vec3(0.1, 0, 0.3)}};
  RefinedSystem<double> system(body, environment);
  testing::expect_driven_by_every_integrator(system);
}

TEST(RefinedSystem, NothingPassesThroughAPlane) {
  BodyConfig config = block(2, 2, 2, 0.2);
  config.damping = {.law = Damping::Law::viscosity, .viscosity = 50};
  const RefinedBody body = refine(config, {refined_cells(config, {0, 0, 0}, {1, 2, 1})});
  const Environment environment{
      .gravity = Vec3(0, 0, -9.8),
      .planes = {{.point = Vec3(0, 0, 0.28), .normal = Vec3(0.1, 0, 1).normalized(), .friction = 1}}};
  RefinedSystem<double> system(body, environment);
  State<double> state = system.rest_state();
  Work work;
  const auto method = find_integrator("verlet").make<double>({.dt = 0.5 / system.spectral_bound().omega});
  for (int i = 1; i <= 30; ++i) {
    ASSERT_EQ(method->advance(system, state, 0.1 * i, work), Status::ok);
    for (const Level& level : body.levels())
      for (const std::ptrdiff_t site : level.body.sites())
        EXPECT_GT(environment.planes[0].gap(state.x.at(level.first + site)), -1e-12);
  }
  EXPECT_LT(measure(system, state).max_speed, 0.1);
}

/// Largest error of positions [m] in steps of a share of the largest stable one, against ones so short that
/// they resolve the smallest cells.
double error_of_local_steps(const RefinedBody& body, double share) {
  RefinedSystem<double> system(body, {}, {.threads = 1});
  State<double> start = system.rest_state();
  for (const Level& level : body.levels())
    for (const std::ptrdiff_t site : level.body.sites()) {
      const Vec3 rest = level.body.rest_position(site);
      start.v.set(level.first + site,
                  Vec3(0.1 * std::sin(3 * rest[2]), 0.2 * rest[0], 0.1 * std::cos(2 * rest[1])));
    }
  system.constrain(0, start.x, start.v);
  const double largest = 2 / system.local_bound().omega, duration = 16 * largest;
  const auto end_of = [&](System<double>& driven, double dt) {
    State<double> state = start;
    Work work;
    EXPECT_EQ(
        find_integrator("velocity_verlet").make<double>({.dt = dt})->advance(driven, state, duration, work),
        Status::ok);
    return state;
  };
  const double dt = share * largest;
  const auto local = system.with_local_steps(dt);
  const State<double> exact = end_of(system, largest / 128), found = end_of(*local, dt);
  double error = 0;
  for (const std::ptrdiff_t site : body.sites())
    error = std::max(error, (found.x.at(site) - exact.x.at(site)).norm());
  return error;
}

TEST(LocalSteps, AreOfSecondOrderWithoutDampingAndOfFirstWithIt) {
  BodyConfig config = block(4, 4, 4, 0.2);
  for (const double viscosity : {0.0, 50.0}) {
    if (viscosity > 0) config.damping = {.law = Damping::Law::viscosity, .viscosity = viscosity};
    const RefinedBody body = refine(config, {refined_cells(config, {0, 0, 0}, {1, 1, 1}, 2)});
    const double coarse = error_of_local_steps(body, 1.0 / 4), fine = error_of_local_steps(body, 1.0 / 8),
                 finest = error_of_local_steps(body, 1.0 / 16);
    const double order = std::log2(coarse / fine), next = std::log2(fine / finest);
    EXPECT_NEAR(order, viscosity > 0 ? 1 : 2, 0.25);
    EXPECT_NEAR(next, viscosity > 0 ? 1 : 2, 0.25);
  }
}

/// Largest energy over the first, of small random motions.
double growth(const RefinedBody& body, double share, long steps, const std::string& name = "verlet") {
  RefinedSystem<double> system(body, {}, {.threads = 1});
  State<double> state = system.rest_state();
  testing::randomise(system, state, 1e-7, 0, 4);
  const double dt = share * 2 / system.local_bound().omega;
  const auto local = system.with_local_steps(dt);
  const auto method = find_integrator(name).make<double>({.dt = dt});
  const double before = measure(system, state).mechanical();
  double most = 0;
  Work work;
  for (int i = 1; i <= 10; ++i) {
    if (method->advance(*local, state, i * double(steps) / 10 * dt, work) != Status::ok) return 1e300;
    most = std::max(most, measure(system, state).mechanical() / before);
  }
  return most;
}

TEST(LocalSteps, AreStableUpToTheLimit) {
  std::vector<RefinedBody> bodies;
  for (const double viscosity : {0.0, 0.2}) {
    BodyConfig config = block(9, 8, 7, 0.2);
    if (viscosity > 0) config.damping = {.law = Damping::Law::viscosity, .viscosity = viscosity};
    bodies.push_back(refine(config, {refined_cells(config, {0, 0, 0}, {1, 1, 1}, 2)}));
    bodies.push_back(refine(config, {refined_cells(config, {4, 4, 6}, {5, 5, 7}, 1)}));
    bodies.push_back(refine(config, {refined_cells(config, {3, 0, 0}, {4, 1, 1}, 3)}));
  }
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const RefinedSystem<double> system(bodies[b], {}, {.threads = 1});
    EXPECT_GT(system.spectral_bound().omega / system.local_bound().omega, 1.9) << b;
    for (int i = 1; i <= 20; ++i) {
      const double share = 0.98 * (0.4 + 0.6 * i / 20);
      EXPECT_LT(growth(bodies[b], share, 400), 10) << b << " at " << share;
    }
  }
}

TEST(LocalSteps, AreStableByEveryMethodThatTakesThem) {
  const BodyConfig config = block(6, 5, 4, 0.2);
  const RefinedBody body = refine(config, {refined_cells(config, {0, 0, 0}, {1, 1, 1}, 2)});
  int methods = 0;
  for (const IntegratorInfo& info : integrators())
    if (info.local_steps) {
      EXPECT_LT(growth(body, 0.9, 400, info.name), 10) << info.name;
      ++methods;
    }
  EXPECT_GE(methods, 3);
}

TEST(LocalSteps, AreRefusedToMethodsThatDoNotTakeThem) {
  const BodyConfig config = block(4, 3, 3, 0.2);
  const RefinedBody body = refine(config, {refined_cells(config, {0, 0, 0}, {1, 1, 1}, 2)});
  RefinedSystem<double> system(body, {});
  const auto local = system.with_local_steps(1e-4);
  State<double> state = system.undeformed_state();
  Work work;
  EXPECT_THROW(find_integrator("rk4").make<double>({.dt = 1e-4})->advance(*local, state, 1e-3, work),
               InputError);
  EXPECT_EQ(find_integrator("verlet").make<double>({.dt = 1e-4})->advance(*local, state, 1e-3, work),
            Status::ok);
}

TEST(LocalStepPlan, GivesEveryLevelItsRateWhereLargeCellsAreMost) {
  const auto level = [](int depth, std::size_t particles, double damping = 0) {
    return LevelCost{
        depth, particles, particles / 10, {.omega = std::ldexp(100.0, depth), .damping = damping}};
  };
  const LocalStepPlan plan = plan_local_steps({level(0, 8000), level(1, 4000), level(2, 2000)});
  ASSERT_EQ(plan.rates.size(), 2U);
  EXPECT_EQ(plan.rates[0].first_level, 1U);
  EXPECT_EQ(plan.rates[0].substeps, 2);
  EXPECT_EQ(plan.rates[1].first_level, 2U);
  EXPECT_EQ(plan.rates[1].substeps, 2);
  EXPECT_GT(plan.largest_step, 0.98 * 2 / 100);
  EXPECT_LE(plan.largest_step, 2.0 / 100);
  // Few large cells: short steps of all cost less than computing forces beside the small ones twice.
  EXPECT_TRUE(plan_local_steps({level(0, 10), level(1, 4000)}).rates.empty());
  // Levels that do not touch have no masters between them.
  EXPECT_TRUE(plan_local_steps({level(0, 8000), level(2, 100)}).rates.empty());
  // Damping over a step is at most 0.4.
  const LocalStepPlan damped = plan_local_steps({level(0, 8000), level(1, 100, 24)});
  ASSERT_EQ(damped.rates.size(), 1U);
  EXPECT_NEAR(damped.largest_step * 24, 0.4, 0.003);
}

TEST(LocalStepPlan, EachFilterKeepsWithinTheRangeOfTheOneBefore) {
  const std::vector<LocalRate> rates{{1, 2}, {2, 4}, {3, 2}};
  const std::vector<ChebyshevFilter> filters = filters_of(rates, 0, 1);
  ASSERT_EQ(filters.size(), 3U);
  for (std::size_t r = 0; r < rates.size(); ++r) {
    const auto& [delta, w, value] = filters[r];
    const int p = rates[r].substeps;
    EXPECT_NEAR(value.back(), std::cosh(p * std::acosh(delta)), 1e-12);
    double most = 0;
    for (int i = 1; i <= 1000; ++i) {
      const double x = delta - filters[r].range() * i / 1000 / w;
      const double t = x > 1 ? std::cosh(p * std::acosh(x)) : std::cos(p * std::acos(x));
      most = std::max(most, 2 * (1 - t / value.back()));
    }
    EXPECT_LE(most, filters[r].largest() * (1 + 1e-12));
    EXPECT_NEAR(most, filters[r].largest(), 1e-3);
    if (r == 0) continue;
    EXPECT_LE(most * rates[r - 1].substeps * rates[r - 1].substeps, filters[r - 1].range() * (1 + 1e-12));
  }
}

TEST(LocalSteps, AreAsLongAsLargeCellsAllowAndConserveMomentum) {
  const BodyConfig config = block(8, 8, 8, 0.1);
  const RefinedBody body = refine(config, {refined_cells(config, {3, 3, 7}, {5, 5, 8}, 2)});
  RefinedSystem<double> system(body, {}, {.threads = 1});
  EXPECT_GT(system.spectral_bound().omega / system.local_bound().omega, 3.9);
  State<double> state = system.rest_state();
  testing::randomise(system, state, 0.01, 0.1, 3);
  const Vec3 before = measure(system, state).momentum;
  const double dt = 0.9 * 2 / system.local_bound().omega;
  Work work;
  const auto local = system.with_local_steps(dt);
  ASSERT_EQ(find_integrator("verlet").make<double>({.dt = dt})->advance(*local, state, 200 * dt, work),
            Status::ok);
  EXPECT_LT((measure(system, state).momentum - before).norm(), 1e-12 * system.total_mass());
}

}  // namespace
}  // namespace mss

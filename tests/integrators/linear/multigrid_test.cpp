// Multigrid: iterations that do not grow with the lattice, on every kind of body, and the same bits always.
#include <gtest/gtest.h>

#include <cstring>

#include "core/base/error.hpp"
#include "core/environment/tethered_system.hpp"
#include "integrators/linear/linear_solver.hpp"
#include "reference/fem/fem_system.hpp"
#include "tests/chain.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

/// A calibrated body held at its bottom, bent by half a radian, stretched by a tenth and noisy.
struct Bent {
  Bent(const VoxelGrid& voxels, double poisson, const Execution& execution = {.threads = 1},
       Environment environment = {})
      : Bent(config(voxels, poisson), execution, std::move(environment)) {}
  explicit Bent(const BodyConfig& config, const Execution& execution = {.threads = 1},
                Environment environment = {})
      : body(config), system(body, with_hold(std::move(environment), body), execution) {
    const double height = config.cell_size * config.voxels.nz();
    std::mt19937 rng(2);
    std::uniform_real_distribution<> noise(-0.01, 0.01);
    for (const std::ptrdiff_t site : body.sites()) {
      const Vec3 at = body.rest_position(site);
      const double turn = 0.5 * at[2] / height, along = 1.1 * at[2];
      Vec3 bent(at[0] * std::cos(turn) + along * std::sin(turn / 2), at[1],
                along * std::cos(turn / 2) - at[0] * std::sin(turn));
      for (int axis = 0; axis < 3; ++axis) {
        bent[axis] += body.config().cell_size * noise(rng);
        rhs.axis(axis)[site] = body.mass(site) * noise(rng);
      }
      state.x.set(site, bent);
    }
    system.clear_prescribed(rhs);
  }
  static BodyConfig config(const VoxelGrid& voxels, double poisson) {
    BodyConfig config{.voxels = voxels,
                      .cell_size = 1.0 / voxels.nx(),
                      .damping = {.law = Damping::Law::ratio, .zeta = 0.01}};
    config.fill({.young = 1e6, .poisson = poisson}, 0.5);
    return config;
  }
  static Environment with_hold(Environment environment, const Body& body) {
    const double low = body.rest_position(body.sites().front())[2];
    environment.holds.push_back({.box = {Vec3(-9, -9, -9), Vec3(9, 9, low)}});
    return environment;
  }
  /// A step of backward Euler, so many times the reciprocal of the largest frequency; 0: statics.
  TangentCoefficients sum(double dt_omega) const {
    if (dt_omega == 0) return {.stiffness = 1, .kind = Tangent::projected};
    const double dt = dt_omega / system.spectral_bound().omega;
    return {.mass = 1, .damping = dt, .stiffness = dt * dt, .kind = Tangent::projected};
  }
  /// Products that a residual of 1e-6 takes.
  long iterations(const char* solver, const TangentCoefficients& sum) {
    Work work;
    const auto linear = find_linear_solver(solver).make(1e-6);
    EXPECT_EQ(linear->prepare(system, 0, state.x, state.v, sum, work), Status::ok);
    EXPECT_EQ(linear->solve(rhs, solution, work), Status::ok);
    return work.products;
  }

  Body body;
  SpringSystem<double> system;
  State<double> state = system.undeformed_state();
  Field<double> rhs{system.size()}, solution{system.size()};
};

VoxelGrid cube(int n) { return VoxelGrid::box(n, n, n); }

VoxelGrid ball(int n, double hollow) {
  VoxelGrid voxels(n, n, n);
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const double r = (Vec3(i, j, k).array() + 0.5 - 0.5 * n).matrix().norm() / (0.5 * n);
        voxels.set(i, j, k, r <= 1 && r >= hollow);
      }
  return voxels;
}

TEST(Multigrid, TakesAsManyIterationsOnFineLatticesAsOnCoarse) {
  for (const int n : {7, 9, 10, 11, 13, 17, 20})
    for (const double dt_omega : {300.0, 0.0}) {
      Bent bent(cube(n), 0.3);
      EXPECT_LE(bent.iterations("multigrid", bent.sum(dt_omega)), 8) << n << " " << dt_omega;
    }
}

TEST(Multigrid, TakesMoreNearlyIncompressible) {
  Bent bent(cube(16), 0.45);
  const long iterations = bent.iterations("multigrid", bent.sum(300));
  EXPECT_LE(iterations, 16);
  EXPECT_GT(iterations, 8);
}

TEST(Multigrid, KeepsItsRateOnRaggedBodies) {
  for (const double hollow : {0.0, 0.7}) {
    Bent bent(ball(18, hollow), 0.3);
    EXPECT_LE(bent.iterations("multigrid", bent.sum(300)), 20) << hollow;
  }
}

// A coarse cell is filled as much as its eight are on average, with each part.
TEST(Multigrid, KeepsItsRateWhereCellsArePartlyFilled) {
  BodyConfig config = Bent::config(ball(18, 0), 0.3);
  testing::fill_randomly(config, 3);
  Bent partly(config);
  const long filled = partly.iterations("multigrid", partly.sum(300));
  EXPECT_LE(filled, 24);
  config.contents.clear();
  config.content_of.clear();
  config.parts = {{.springs = calibrate({.young = 1e7, .poisson = 0.3}, config.cell_size, 0.5)}};
  testing::fill_randomly(config, 3);
  Bent mixed(config);
  EXPECT_LE(mixed.iterations("multigrid", mixed.sum(300)), 48);
}

TEST(Multigrid, SolvesWhatTheOthersSolve) {
  Bent bent(ball(12, 0), 0.3);
  bent.iterations("cholmod", bent.sum(100));
  const Field<double> direct = bent.solution;
  bent.iterations("multigrid", bent.sum(100));
  EXPECT_LT((bent.solution.array() - direct.array()).abs().maxCoeff(),
            1e-4 * direct.array().abs().maxCoeff());
}

TEST(Multigrid, GivesTheSameBitsForAnyNumberOfThreads) {
  Bent one(cube(24), 0.3);
  one.iterations("multigrid", one.sum(300));
  for (const int threads : {2, 3, 5}) {
    Bent other(cube(24), 0.3, {.threads = threads});
    other.iterations("multigrid", other.sum(300));
    EXPECT_EQ(std::memcmp(one.solution.axis(0), other.solution.axis(0),
                          std::size_t(one.solution.size()) * sizeof(double)),
              0)
        << threads;
  }
}

TEST(Multigrid, KnowsOfPlanesThatPushAndOfTethers) {
  const Plane plane{.point = Vec3(0, 0, 1.05), .normal = -Vec3::UnitZ(), .contact = ContactLaw::penalty};
  Bent bent(cube(10), 0.3, {.threads = 1}, {.planes = {plane}});
  EXPECT_LE(bent.iterations("multigrid", bent.sum(300)), 12);
  TetheredSystem<double> tethered(bent.system);
  const std::ptrdiff_t site = bent.body.sites().back();
  tethered.tie(stable_tether(bent.body.mass(site), bent.system.spectral_bound(), site));
  Work work;
  const auto linear = find_linear_solver("multigrid").make(1e-6);
  ASSERT_EQ(linear->prepare(tethered, 0, bent.state.x, bent.state.v, bent.sum(300), work), Status::ok);
  EXPECT_EQ(linear->solve(bent.rhs, bent.solution, work), Status::ok);
  EXPECT_LE(work.products, 12);
}

TEST(Multigrid, PreconditionsFiniteElements) {
  for (const SolidLaw& law : solid_laws()) {
    const Body body(Bent::config(cube(8), 0.3));
    FemSystem system(body, Bent::with_hold({}, body), law, 1);
    const State<double> state = system.undeformed_state();
    Field<double> rhs(system.size()), solution(system.size());
    for (const std::ptrdiff_t site : body.sites())
      rhs.set(site, body.mass(site) * Vec3(double(site % 7) - 3, double(site % 5) - 2, double(site % 3) - 1));
    Work work;
    const auto linear = find_linear_solver("multigrid").make(1e-6);
    ASSERT_EQ(
        linear->prepare(system, 0, state.x, state.v, {.stiffness = 1, .kind = Tangent::projected}, work),
        Status::ok);
    EXPECT_EQ(linear->solve(rhs, solution, work), Status::ok);
    EXPECT_LE(work.products, 25) << law.name;
  }
}

TEST(Multigrid, RefusesWhatIsNoBodyOfCells) {
  testing::Chain chain(5, 0);
  Field<double> x(chain.size()), v(chain.size());
  Work work;
  const auto linear = find_linear_solver("multigrid").make(1e-6);
  EXPECT_THROW(linear->prepare(chain, 0, x, v, {.mass = 1, .stiffness = 1, .kind = Tangent::projected}, work),
               InputError);
}

}  // namespace
}  // namespace mss

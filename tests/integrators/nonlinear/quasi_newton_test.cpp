// Projective dynamics and L-BFGS: the same stages as Newton's method, linear momentum in every iteration, and
// refusals in words.
#include <gtest/gtest.h>

#include <cstring>

#include "core/base/error.hpp"
#include "core/environment/tethered_system.hpp"
#include "integrators/nonlinear/implicit_stage.hpp"
#include "tests/chain.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

const std::vector<std::string> quasi_newton{"projective", "lbfgs", "nonlinear_cg", "additive_cg"};

Status run(System<double>& system, State<double>& state, const std::string& method,
           const IntegratorOptions& options, int steps, Work& work) {
  return find_integrator(method).make<double>(options)->advance(system, state, state.t + steps * options.dt,
                                                                work);
}

double distance(const State<double>& a, const State<double>& b) {
  return (a.x.array() - b.x.array()).abs().maxCoeff();
}

/// A box held by a face, one held by a part of it, and a body with holes.
struct Held {
  BodyConfig config;
  std::vector<Hold> holds;
};
std::vector<Held> held_bodies() {
  BodyConfig box = testing::test_config(VoxelGrid::box(4, 3, 3)), holes = box;
  holes.voxels.set(1, 1, 1, false);
  holes.voxels.set(3, 2, 2, false);
  const Vec3 low = box.origin;
  const Hold face{.box = {low, low + Vec3(0, 0.6, 0.6)}, .velocity = Vec3(0.1, 0, 0)};
  const Hold edge{.box = {low, low + Vec3(0, 0, 0.6)}, .axes = {true, false, true}};
  return {{box, {face}}, {box, {edge}}, {holes, {face, edge}}};
}

TEST(QuasiNewton, SolvesTheStagesOfAllImplicitMethods) {
  int methods = 0;
  for (const IntegratorInfo& method : integrators()) {
    if (!method.implicit || method.stepping != Stepping::fixed || method.name == "backward_euler_linear")
      continue;
    ++methods;
    for (const Held& held : held_bodies()) {
      const Body body(held.config);
      SpringSystem<double> system(body, {.gravity = Vec3(0, 0, -9.81), .holds = held.holds});
      State<double> start = system.rest_state();
      testing::randomise(body, start, 0.1, 0.5, 3);
      system.constrain(0, start.x, start.v);
      State<double> expected = start;
      Work work;
      ASSERT_EQ(run(system, expected, method.name, {.dt = 0.02}, 3, work), Status::ok);
      for (const std::string& solver : quasi_newton) {
        State<double> state = start;
        ASSERT_EQ(run(system, state, method.name, {.dt = 0.02, .nonlinear_solver = solver}, 3, work),
                  Status::ok)
            << method.name << " " << solver;
        EXPECT_LT(distance(state, expected), 1e-8 * distance(expected, start))
            << method.name << " " << solver;
      }
    }
  }
  EXPECT_GE(methods, 3);
}

TEST(QuasiNewton, FewIterationsOfLbfgsComeCloserThanOfProjectiveDynamics) {
  const Body body(testing::test_config(VoxelGrid::box(5, 5, 5)));
  SpringSystem<double> system(body, {.gravity = Vec3(0, 0, -9.81), .holds = held_bodies()[0].holds});
  State<double> start = system.rest_state();
  testing::randomise(body, start, 0.1, 0.5, 3);
  State<double> exact = start;
  Work work;
  ASSERT_EQ(run(system, exact, "backward_euler", {.dt = 0.1}, 1, work), Status::ok);
  const auto error = [&](const std::string& solver, int iterations) {
    State<double> state = start;
    Work done;
    const IntegratorOptions options{.dt = 0.1, .nonlinear_solver = solver, .iterations = iterations};
    EXPECT_EQ(run(system, state, "backward_euler", options, 1, done), Status::ok);
    EXPECT_EQ(done.linear_solves, iterations);
    EXPECT_EQ(done.factorisations, 1);
    return distance(state, exact) / distance(start, exact);
  };
  EXPECT_LT(error("projective", 12), error("projective", 4));
  EXPECT_LT(error("lbfgs", 4), error("projective", 4));
  EXPECT_LT(error("lbfgs", 12), 0.2 * error("projective", 12));
  EXPECT_LT(error("lbfgs", 12), 0.01);
}

// It does not wait for convergence.
TEST(QuasiNewton, KeepsLinearMomentumInEveryIteration) {
  const Body body(testing::test_config(VoxelGrid::box(5, 4, 3)));
  SpringSystem<double> system(body, {});
  for (const std::string& solver : quasi_newton)
    for (const int iterations : {1, 2, 7}) {
      State<double> state = system.rest_state();
      testing::randomise(body, state, 0.2, 1, 6);
      const auto momentum = [&] {
        Vec3 sum = Vec3::Zero();
        for (const std::ptrdiff_t site : body.sites()) sum += body.mass(site) * state.v.at(site);
        return sum;
      };
      const Vec3 before = momentum();
      Work work;
      ASSERT_EQ(run(system, state, "backward_euler",
                    {.dt = 0.05, .nonlinear_solver = solver, .iterations = iterations}, 10, work),
                Status::ok);
      EXPECT_LT((momentum() - before).norm(), 1e-12 * body.total_mass()) << solver << " " << iterations;
    }
}

TEST(QuasiNewton, GivesTheSameBitsForAnyNumberOfThreads) {
  const Body body(testing::test_config(VoxelGrid::box(10, 11, 12)));
  const auto end = [&](int threads) {
    SpringSystem<double> system(body, {.gravity = Vec3(0, 0, -9.81)}, {.threads = threads});
    State<double> state = system.rest_state();
    testing::randomise(body, state, 0.1, 0.5, 5);
    Work work;
    EXPECT_EQ(
        run(system, state, "tr_bdf2", {.dt = 0.05, .nonlinear_solver = "lbfgs", .iterations = 8}, 2, work),
        Status::ok);
    return state.x;
  };
  const Field<double> one = end(1);
  for (const int threads : {2, 5}) {
    const Field<double> other = end(threads);
    EXPECT_EQ(std::memcmp(one.axis(0), other.axis(0), std::size_t(one.size()) * sizeof(double)), 0)
        << threads;
  }
}

TEST(QuasiNewton, SolvesFoldedBodiesWithTheirGuard) {
  BodyConfig config = testing::test_config(VoxelGrid::box(3, 3, 3));
  config.fold_guard = 0.5;
  const Body body(config);
  SpringSystem<double> system(body, {});
  State<double> start = system.rest_state();
  testing::randomise(body, start, 0.45, 0.5, 3);
  State<double> newton = start, state = start;
  Work work;
  ASSERT_EQ(run(system, newton, "backward_euler", {.dt = 0.003}, 1, work), Status::ok);
  ASSERT_EQ(run(system, state, "backward_euler", {.dt = 0.003, .nonlinear_solver = "lbfgs"}, 1, work),
            Status::ok);
  EXPECT_LT(distance(state, newton), 1e-7 * distance(start, newton));
}

TEST(QuasiNewton, TakesWhatPullsAtABody) {
  const Body body(testing::test_config(VoxelGrid::box(3, 3, 3)));
  SpringSystem<double> system(body, {.gravity = Vec3(0, 0, -9.81)});
  TetheredSystem<double> tethered(system);
  Tether tether =
      stable_tether(body.mass(body.sites().front()), system.spectral_bound(), body.sites().front());
  tether.anchor = body.config().origin - Vec3(0.3, 0, 0);
  tethered.tie(tether);
  State<double> newton = system.rest_state(), state = newton, start = newton;
  Work work;
  ASSERT_EQ(run(tethered, newton, "backward_euler", {.dt = 0.02}, 2, work), Status::ok);
  ASSERT_EQ(run(tethered, state, "backward_euler", {.dt = 0.02, .nonlinear_solver = "lbfgs"}, 2, work),
            Status::ok);
  EXPECT_LT(distance(state, newton), 1e-8 * distance(start, newton));
}

// A step of three hundred times the shortest period over 2 pi, in which a twisted body would turn by radians.
TEST(QuasiNewton, SolvesVeryLongStepsOfWhatSpins) {
  const Body body(testing::test_config(VoxelGrid::box(6, 6, 6)));
  SpringSystem<double> system(body, {});
  State<double> start = system.rest_state();
  for (const std::ptrdiff_t site : body.sites()) {
    const Vec3 x = body.rest_position(site) - body.config().origin;
    const double angle = x[2];
    start.x.set(site, body.config().origin + Vec3(std::cos(angle) * x[0] - std::sin(angle) * x[1],
                                                  std::sin(angle) * x[0] + std::cos(angle) * x[1], x[2]));
  }
  const double dt = 300 / system.spectral_bound().omega;
  for (const std::ptrdiff_t site : body.sites())
    start.v.set(site, 2 / dt * Vec3(0.3, 1, 0.2).cross(start.x.at(site)));
  // What a step of backward Euler minimises.
  const auto objective = [&](const Field<double>& x) {
    const StoredEnergy energy = system.stored_energy(x);
    double sum = dt * dt * (energy.elastic + energy.volume);
    for (const std::ptrdiff_t site : body.sites())
      sum += body.mass(site) / 2 * (x.at(site) - start.x.at(site) - dt * start.v.at(site)).squaredNorm();
    return sum;
  };
  Work work;
  State<double> newton = start, state = start;
  ASSERT_EQ(run(system, newton, "backward_euler", {.dt = dt, .linear_solver = "cholmod"}, 1, work),
            Status::ok);
  ASSERT_EQ(
      run(system, state, "backward_euler", {.dt = dt, .nonlinear_solver = "lbfgs", .iterations = 5}, 1, work),
      Status::ok);
  const double lowest = objective(newton.x);
  Field<double> inertial = start.x;
  inertial.array() += dt * start.v.array();
  EXPECT_LT(objective(state.x) - lowest, 0.01 * (objective(inertial) - lowest));
}

// As Newton's method does: overdamped and spinning fast, where dampers' forces turn with springs.
TEST(QuasiNewton, SaysWhenItStalls) {
  BodyConfig config = testing::test_config(VoxelGrid::box(3, 3, 3));
  config.damping.zeta = 20;
  const Body body(config);
  SpringSystem<double> system(body, {});
  State<double> state = system.rest_state();
  for (const std::ptrdiff_t site : body.sites()) {
    const Vec3 arm = state.x.at(site) - body.config().origin;
    state.v.set(site, 300 * Vec3(-arm[1], arm[0], 0));
  }
  Work work;
  EXPECT_EQ(run(system, state, "implicit_midpoint", {.dt = 0.05, .nonlinear_solver = "lbfgs"}, 1, work),
            Status::newton_stalled);
}

template <class Act>
std::string refusal(Act&& act) {
  try {
    act();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

// What hardly slides has a friction that turns with it, which is far stiffer than the body.
TEST(QuasiNewton, AGivenNumberOfIterationsNeverStallsInACorner) {
  BodyConfig config{.voxels = VoxelGrid::box(7, 3, 2), .cell_size = 0.1, .density = 1000};
  config.damping = {.law = Damping::Law::ratio, .zeta = 0.1};
  config.fill({.young = 1e4, .poisson = 0.3}, 0.5);
  const Body body(config);
  const Plane slope{.point = Vec3(0, 0, -0.003),
                    .normal = Vec3(0.2, 0, 1).normalized(),
                    .restitution = 0.5,
                    .friction = 0.1},
      wall{.point = Vec3(-0.05, 0, 0), .normal = Vec3(1, 0, 0), .friction = 0.3};
  SpringSystem<double> system(body, {.gravity = Vec3(0, 0, -9.81), .planes = {slope, wall}});
  for (const std::string& solver : quasi_newton)
    for (const int iterations : {1, 2, 3, 5}) {
      State<double> state = system.rest_state();
      Work work;
      EXPECT_EQ(run(system, state, "backward_euler",
                    {.dt = 0.01, .nonlinear_solver = solver, .iterations = iterations}, 30, work),
                Status::ok)
          << solver << " " << iterations;
    }
}

TEST(QuasiNewton, RefusesInWordsWhatItCannotDo) {
  const auto refused = [](System<double>& system, State<double> state) {
    return refusal([&] {
      Work work;
      run(system, state, "backward_euler", {.dt = 0.01, .nonlinear_solver = "lbfgs"}, 1, work);
    });
  };
  testing::Chain chain(3, 0);
  EXPECT_NE(refused(chain, {0, Field<double>(3), Field<double>(3)}).find("a body of cells of one size"),
            std::string::npos);
  BodyConfig config = testing::test_config(VoxelGrid::box(2, 2, 2));
  config.springs.volume = -1;
  const Body body(config);
  SpringSystem<double> system(body, {});
  EXPECT_NE(refused(system, system.rest_state()).find("no lower bound"), std::string::npos);
  EXPECT_NE(refusal([] { find_nonlinear_solver("lbgfs"); }).find("'lbfgs'"), std::string::npos);
}

}  // namespace
}  // namespace mss

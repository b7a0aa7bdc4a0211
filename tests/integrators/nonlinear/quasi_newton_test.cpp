// Projective dynamics and L-BFGS: the same stages as Newton's method, linear momentum in every iteration, and
// refusals in words.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <random>

#include "core/base/error.hpp"
#include "core/environment/tethered_system.hpp"
#include "core/refinement/refined_system.hpp"
#include "integrators/nonlinear/implicit_stage.hpp"
#include "tests/chain.hpp"
#include "tests/random_bodies.hpp"
#include "tests/refined_bodies.hpp"

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

/// A metre of rubber in cells of three sizes.
RefinedBody refined_rubber_block() {
  BodyConfig config{.voxels = VoxelGrid::box(5, 5, 5), .cell_size = 0.2};
  config.fill({.young = 1e7, .poisson = 0.3}, 0.5);
  config.damping = {.law = Damping::Law::viscosity, .viscosity = 1000};
  return {config, refinement_of(config, {testing::box_of_cells(config, {0, 0, 0}, {2, 2, 2}, 1),
                                         testing::box_of_cells(config, {0, 0, 0}, {1, 1, 1}, 2)})};
}

/// Stretched, sheared and moving.
State<double> deformed(SolidSystem<double>& system) {
  State<double> state = system.rest_state();
  for (const std::ptrdiff_t site : system.particles()) {
    const Vec3 x = system.rest_position(site);
    state.x.set(site, Vec3(1.03 * x[0] + 0.02 * x[1] * x[2], x[1] + 0.03 * x[0] * x[2], 0.98 * x[2]));
    state.v.set(site, 0.3 * Vec3(std::sin(3 * x[1]), x[0] - x[2], 2 * std::cos(2 * x[0])));
  }
  system.constrain(0, state.x, state.v);
  return state;
}

TEST(QuasiNewton, SolvesTheStagesOfCellsOfSeveralSizes) {
  const RefinedBody body = refined_rubber_block();
  const Hold face{.box = {Vec3(0, 0, 0), Vec3(0, 1, 1)}, .velocity = Vec3(0.1, 0, 0)},
      edge{.box = {Vec3(0, 0, 0), Vec3(0, 0, 1)}, .axes = {true, false, true}};
  for (const std::vector<Hold>& holds : {std::vector<Hold>{}, {face}, {edge}}) {
    RefinedSystem<double> system(body, {.gravity = Vec3(0, 0, -9.81), .holds = holds});
    const State<double> start = deformed(system);
    for (const std::string method : {"backward_euler", "implicit_midpoint", "tr_bdf2", "generalized_alpha"}) {
      State<double> expected = start;
      Work work;
      ASSERT_EQ(run(system, expected, method, {.dt = 1.0 / 60}, 3, work), Status::ok);
      for (const std::string& solver : quasi_newton) {
        State<double> state = start;
        ASSERT_EQ(run(system, state, method, {.dt = 1.0 / 60, .nonlinear_solver = solver}, 3, work),
                  Status::ok)
            << method << " " << solver;
        EXPECT_LT(distance(state, expected), 1e-8 * distance(expected, start)) << method << " " << solver;
      }
    }
  }
}

/// A box of up to two cells' edge somewhere in a body.
Box box_somewhere(const BodyConfig& config, std::mt19937& rng) {
  std::uniform_real_distribution<> share(0, 1);
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    box.lower[axis] = config.cell_size * config.voxels.size()[std::size_t(axis)] * share(rng);
    box.upper[axis] = box.lower[axis] + 2 * config.cell_size * share(rng);
  }
  return box;
}

// Cells, sizes and holds as they come; where a hold would tear what hangs from its masters there is none.
TEST(QuasiNewton, SolvesTheStagesOfBodiesRefinedAtRandom) {
  std::mt19937 rng(5);
  int solved = 0;
  for (int trial = 0; trial < 40; ++trial) {
    BodyConfig config{.voxels = VoxelGrid(2 + int(rng() % 5), 1 + int(rng() % 5), 1 + int(rng() % 4)),
                      .cell_size = 0.2};
    config.fill({.young = 1e6, .poisson = trial % 3 == 0 ? 0.45 : 0.3}, 0.5);
    config.damping = {.law = Damping::Law::ratio, .zeta = 0.3};
    for (int k = 0; k < config.voxels.nz(); ++k)
      for (int j = 0; j < config.voxels.ny(); ++j)
        for (int i = 0; i < config.voxels.nx(); ++i)
          config.voxels.set(i, j, k, i + j + k == 0 || trial % 2 == 0 || rng() % 3 > 0);
    std::vector<RefinedBox> boxes;
    for (std::size_t n = 1 + rng() % 3; n-- > 0;)
      boxes.push_back({box_somewhere(config, rng), 1 + int(rng() % 2)});
    const RefinedBody body(config, refinement_of(config, boxes));
    Environment environment{.gravity = Vec3(0, 0, -9.81)};
    if (trial % 4 != 0)
      environment.holds = {{.box = box_somewhere(config, rng), .axes = {true, false, true}}};
    try {
      check_holds(body, HeldSites(body.levels(), environment.holds));
    } catch (const InputError&) {
      environment.holds.clear();
    }
    RefinedSystem<double> system(body, environment);
    State<double> start = system.rest_state();
    std::uniform_real_distribution<> move(-0.002, 0.002);
    for (const std::ptrdiff_t site : system.particles())
      start.x.set(site, start.x.at(site) + Vec3(move(rng), move(rng), move(rng)));
    system.constrain(0, start.x, start.v);
    State<double> expected = start, state = start;
    Work work;
    ASSERT_EQ(run(system, expected, "backward_euler", {.dt = 1.0 / 60}, 2, work), Status::ok) << trial;
    ASSERT_EQ(run(system, state, "backward_euler/lbfgs", {.dt = 1.0 / 60}, 2, work), Status::ok) << trial;
    EXPECT_LT(distance(state, expected), 1e-6 * distance(expected, start)) << trial;
    solved += body.levels().size() > 1;
  }
  EXPECT_GT(solved, 20);
}

/// Of two iterations of a held block, the third step from rest: what is left of the step, in the mean over
/// the body and over the corner of it that is held, where its smallest cells are.
std::array<double, 2> left_after_two_iterations(const RefinedBody& body) {
  RefinedSystem<double> system(
      body, {.gravity = Vec3(0, 0, -9.81), .holds = {{.box = {Vec3(0, 0, 0), Vec3(0, 1, 1)}}}});
  const auto advance = [&](State<double> state, int iterations, int steps) {
    Work work;
    const IntegratorOptions options{.dt = 1.0 / 60, .nonlinear_solver = "lbfgs", .iterations = iterations};
    EXPECT_EQ(run(system, state, "backward_euler", options, steps, work), Status::ok);
    return state;
  };
  const State<double> start = advance(system.rest_state(), 0, 2), exact = advance(start, 0, 1),
                      state = advance(start, 2, 1);
  std::array<double, 2> left{};
  for (const double size : {1.0, 0.2}) {
    double error = 0, step = 0;
    for (const std::ptrdiff_t site : system.particles()) {
      if (system.rest_position(site).maxCoeff() > size + 1e-9) continue;
      error += system.mass(site) * (state.x.at(site) - exact.x.at(site)).squaredNorm();
      step += system.mass(site) * (start.x.at(site) - exact.x.at(site)).squaredNorm();
    }
    left[size < 1] = std::sqrt(error / step);
  }
  return left;
}

// The corner hardly moves.
TEST(QuasiNewton, FindsTheStepOfCellsOfSeveralSizesAsFastAsOfTheSmallestEverywhere) {
  BodyConfig config = refined_rubber_block().config();
  const std::array<double, 2> several = left_after_two_iterations(refined_rubber_block()),
                              smallest = left_after_two_iterations(
                                  {config, refinement_of(config, {{{Vec3(0, 0, 0), Vec3(1, 1, 1)}, 2}})});
  EXPECT_LT(several[0], 0.01);
  EXPECT_LT(several[0], 1.1 * smallest[0]);
  EXPECT_LT(several[1], 1.1 * smallest[1]);
}

TEST(QuasiNewton, KeepsTheMomentumOfCellsOfSeveralSizesInEveryIteration) {
  const RefinedBody body = refined_rubber_block();
  RefinedSystem<double> system(body, {});
  const auto momentum = [&](const State<double>& state) {
    Vec3 sum = Vec3::Zero();
    for (const std::ptrdiff_t site : system.particles()) sum += system.mass(site) * state.v.at(site);
    return sum;
  };
  for (const std::string& solver : quasi_newton)
    for (const int iterations : {1, 2, 7}) {
      State<double> state = deformed(system);
      const Vec3 before = momentum(state);
      Work work;
      ASSERT_EQ(run(system, state, "backward_euler",
                    {.dt = 1.0 / 60, .nonlinear_solver = solver, .iterations = iterations}, 10, work),
                Status::ok);
      EXPECT_LT((momentum(state) - before).norm(), 1e-12 * body.total_mass()) << solver << " " << iterations;
    }
}

TEST(QuasiNewton, GivesTheSameBitsOfCellsOfSeveralSizesForAnyNumberOfThreads) {
  BodyConfig config = testing::test_config(VoxelGrid::box(9, 10, 11));
  const RefinedBody body(config,
                         refinement_of(config, {testing::box_of_cells(config, {1, 0, 0}, {6, 7, 8}, 1),
                                                testing::box_of_cells(config, {2, 2, 2}, {5, 5, 5}, 2)}));
  const auto end = [&](int threads) {
    RefinedSystem<double> system(body, {.gravity = Vec3(0, 0, -9.81)}, {.threads = threads});
    State<double> state = deformed(system);
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

// It lands on its smallest cells, on an edge of the larger ones, and slides. With a friction of 0.3 the
// fourth step's equations have several solutions, and rounding chooses among them.
TEST(QuasiNewton, KeepsContactOfCellsOfSeveralSizesInsideSteps) {
  const RefinedBody body = refined_rubber_block();
  const Plane ground{.point = Vec3(0, 0, -0.05), .normal = Vec3(0.1, 0.05, 1).normalized(), .friction = 0.2};
  RefinedSystem<double> system(body, {.gravity = Vec3(0, 0, -9.81), .planes = {ground}});
  State<double> start = system.rest_state();
  for (const std::ptrdiff_t site : system.particles()) start.v.set(site, Vec3(1, 0, -1));
  system.constrain(0, start.x, start.v);
  for (const std::string solver : {"projective", "lbfgs"}) {
    State<double> newton = start, state = start;
    const auto one = find_integrator("backward_euler").make<double>({.dt = 1.0 / 60}),
               other = find_integrator("backward_euler/" + solver).make<double>({.dt = 1.0 / 60});
    for (int step = 1; step <= 20; ++step) {
      Work work;
      ASSERT_EQ(one->advance(system, newton, step / 60.0, work), Status::ok);
      ASSERT_EQ(other->advance(system, state, step / 60.0, work), Status::ok);
      EXPECT_LT(distance(state, newton), 1e-6) << solver << " " << step;
      for (const Level& level : body.levels())
        for (const std::ptrdiff_t site : level.body.sites())
          EXPECT_GT(ground.gap(state.x.at(level.first + site)), -1e-9);
    }
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
  EXPECT_NE(refused(chain, {0, Field<double>(3), Field<double>(3)}).find("a body of cells"),
            std::string::npos);
  BodyConfig config = testing::test_config(VoxelGrid::box(2, 2, 2));
  config.springs.volume = -1;
  const Body body(config);
  SpringSystem<double> system(body, {});
  EXPECT_NE(refused(system, system.rest_state()).find("no lower bound"), std::string::npos);
  const RefinedBody refined(config,
                            refinement_of(config, {testing::box_of_cells(config, {0, 0, 0}, {1, 1, 1}, 1)}));
  RefinedSystem<double> of_several(refined, {});
  EXPECT_NE(refused(of_several, of_several.rest_state()).find("no lower bound"), std::string::npos);
  EXPECT_NE(refusal([] { find_nonlinear_solver("lbgfs"); }).find("'lbfgs'"), std::string::npos);
}

}  // namespace
}  // namespace mss

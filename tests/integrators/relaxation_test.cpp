// Materials that relax: against an oracle that integrates every damper, closed forms of a bar, energy, order
// and limits of methods.
#include "core/body/relaxation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstring>
#include <numbers>

#include "core/base/error.hpp"
#include "core/base/record.hpp"
#include "core/measures/measures.hpp"
#include "core/scene/scene.hpp"
#include "integrators/analysis/modes.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "integrators/integrator.hpp"
#include "tests/dense_eigenvalues.hpp"
#include "tests/differences.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

BodyConfig relaxing(const VoxelGrid& voxels, double ratio = 0.6, double time = 0.05) {
  BodyConfig config = testing::test_config(voxels);
  config.relaxation = {.ratio = ratio, .time = time};
  return config;
}

VoxelGrid ragged() { return testing::test_shapes().back().voxels; }

/// The branch's ODE and the work of its damper, by many small steps.
TEST(Relaxation, StepsBranchesExactly) {
  const Relaxation relaxation{.ratio = 1, .time = 0.3};
  for (const double dt : {1e-6, 1e-3, 0.02, 0.3, 5.0}) {
    const double q = 0.7, pull = -1.3;
    const BranchStep step(relaxation, dt);
    double tension = q, dissipated = 0;
    constexpr int steps = 20000;
    const double h = dt / relaxation.time / steps;
    for (int n = 0; n < steps; ++n) {  // the trapezoidal rule
      const double next = (tension * (1 - h / 2) + pull / steps) / (1 + h / 2);
      dissipated += h * (tension * tension + tension * next + next * next) / 3;
      tension = next;
    }
    EXPECT_NEAR(step.decay * q + step.gain * pull, tension, 1e-7) << dt;
    EXPECT_NEAR(step.dissipated(q, pull), dissipated, 1e-7 * dissipated) << dt;
  }
  const BranchStep for_ever(relaxation, std::numeric_limits<double>::infinity());
  EXPECT_EQ(for_ever.decay, 0);
  EXPECT_EQ(for_ever.gain, 0);
  EXPECT_EQ(for_ever.dissipated(1, 1), 0);
  EXPECT_EQ(BranchStep(relaxation, 0).gain, 1);
}

/// Semi-implicit Euler, as the oracle has it, which knows the dampers' lengths instead of tensions.
TEST(Relaxation, FollowsTheOracle) {
  constexpr double dt = 2e-4;
  constexpr int steps = 300;
  for (const VoxelGrid& voxels : {VoxelGrid::box(3, 2, 4), ragged()}) {
    const BodyConfig config = relaxing(voxels);
    const Body body(config);
    SpringSystem<double> system(body, {.gravity = Vec3(0, 0.5, -9.81)});
    reference::Algorithm1 oracle(config, Vec3(0, 0.5, -9.81), 1);
    State<double> state = system.rest_state();
    testing::randomise(body, state, 0, 0.3, 29);
    testing::copy_state(body, state, oracle);
    const auto method = find_integrator("semi_implicit_euler").make<double>({.dt = dt});
    Work work;
    ASSERT_EQ(method->advance(system, state, steps * dt, work), Status::ok);
    for (int step = 0; step < steps; ++step) oracle.step(dt);
    double moved = 0;
    for (std::size_t id = 0; id < body.particle_count(); ++id) {
      const std::ptrdiff_t site = body.sites()[id];
      EXPECT_LT((state.x.at(site) - oracle.particles()[id].x).norm(), 1e-9);
      moved = std::max(moved, (state.x.at(site) - body.rest_position(site)).norm());
    }
    EXPECT_GT(moved, 0.01);
  }
}

template <class Real>
State<Real> after(const BodyConfig& config, const std::string& name, int threads) {
  const Body body(config);
  SpringSystem<Real> system(body, {.gravity = Vec3(0, 0, -9.81)}, {threads, {}, {}});
  State<Real> state = system.rest_state();
  testing::randomise(body, state, 0.02, 0.3, 31);
  const auto method = find_integrator(name).make<Real>({.dt = 2e-4});
  Work work;
  EXPECT_EQ(method->advance(system, state, 0.02, work), Status::ok);
  return state;
}

TEST(Relaxation, HasTheSameBitsForAnyNumberOfThreads) {
  for (const VoxelGrid& voxels : {VoxelGrid::box(5, 5, 5), ragged()}) {
    const BodyConfig config = relaxing(voxels);
    const Body body(config);
    for (const char* method : {"velocity_verlet", "damped_verlet"}) {
      const State<double> one = after<double>(config, method, 1);
      const State<float> single = after<float>(config, method, 1);
      for (const int threads : {2, 3}) {
        const State<double> several = after<double>(config, method, threads);
        EXPECT_EQ((one.x.array() - several.x.array()).abs().maxCoeff(), 0) << threads;
        EXPECT_EQ((single.v.array() - after<float>(config, method, threads).v.array()).abs().maxCoeff(), 0);
      }
      for (const std::ptrdiff_t site : body.sites())
        EXPECT_LT((one.x.at(site) - single.x.at(site)).norm(), 2e-5);
    }
  }
}

/// Within a step, where tensions are left from before and lengths have changed since.
TEST(Relaxation, HasTangentsOfItsForces) {
  const Body body(relaxing(VoxelGrid::box(2, 1, 2)));
  SpringSystem<double> system(body, {});
  State<double> state = system.rest_state();
  testing::randomise(body, state, 0.2, 0, 3);
  State<double> before = state;
  system.memory()->come_to(before);
  testing::randomise(body, before, 0.2, 0, 5);
  before.t = -0.01;
  system.memory()->forget();
  system.memory()->come_to(before);
  ASSERT_GT((before.x.array() - state.x.array()).abs().maxCoeff(), 0.01);
  Tangents<double>& tangents = *system.tangents();
  SparseMatrix matrix = tangents.pattern();
  tangents.values(0, state.x, state.v, {.stiffness = 1, .kind = Tangent::elastic}, matrix);
  const Eigen::MatrixXd dense(matrix), measured = testing::force_differences(system, state, true, 0.2);
  EXPECT_LT(testing::relative_difference(dense, measured), 1e-7);
  // With the branches, not without.
  system.memory()->forget();
  tangents.values(0, state.x, state.v, {.stiffness = 1, .kind = Tangent::elastic}, matrix);
  EXPECT_GT(testing::relative_difference(Eigen::MatrixXd(matrix), measured), 0.05);
  system.memory()->come_to(before);
  Field<double> direction(system.size()), product(system.size());
  std::vector<Eigen::Matrix3d> diagonal;
  tangents.diagonal(0, state.x, state.v, {.stiffness = 1, .kind = Tangent::elastic}, diagonal);
  const std::vector<FreeDof>& unknowns = tangents.unknowns();
  for (std::size_t column = 0; column < unknowns.size(); column += 7) {
    direction.array().setZero();
    direction.axis(unknowns[column].axis)[unknowns[column].site] = 1;
    tangents.product(0, state.x, state.v, {.stiffness = 1, .kind = Tangent::elastic}, direction, product);
    for (std::size_t row = 0; row < unknowns.size(); ++row)
      EXPECT_NEAR(product.axis(unknowns[row].axis)[unknowns[row].site],
                  dense(Eigen::Index(row), Eigen::Index(column)), 1e-9 * dense.cwiseAbs().maxCoeff());
    EXPECT_NEAR(diagonal[column / 3](int(column % 3), int(column % 3)),
                dense(Eigen::Index(column), Eigen::Index(column)), 1e-9 * dense.cwiseAbs().maxCoeff());
  }
}

/// A beam of springs alone, so that all of it relaxes alike, held at an end.
struct Bar {
  double length = 0.8, young = 1e5;
  Relaxation relaxation{.ratio = 0.5, .time = 0.2};
  BodyConfig config(bool relaxes = true) const {
    BodyConfig c{.voxels = VoxelGrid::box(4, 1, 1), .cell_size = 0.2, .density = 1};
    c.fill({.young = young, .poisson = 0.25}, 0.5);
    c.springs.volume = 0;  // 0 at 1/4, but for rounding
    if (relaxes) c.relaxation = relaxation;
    return c;
  }
  /// Moved by one end along x, and free to contract.
  void stretch(const Body& body, Field<double>& x, double strain, double contraction) const {
    for (const std::ptrdiff_t site : body.sites()) {
      const Vec3 rest = body.rest_position(site);
      x.set(site, Vec3(rest[0] * (1 + strain), rest[1] * (1 - contraction), rest[2] * (1 - contraction)));
    }
  }
};

/// Force that the end of the bar pulls with [N].
double pull_of_end(SpringSystem<double>& system, const State<double>& state) {
  Field<double> f(system.size());
  system.force(state.t, state.x, state.v, f);
  double sum = 0;
  for (const std::ptrdiff_t site : system.particles())
    if (system.body().rest_position(site)[0] < 1e-9) sum += f.axis(0)[site];
  return sum;
}

/// E* = E (1 + ratio i w time / (1 + i w time)) against frequency, by strains that oscillate in steps small
/// enough; errors go with the square of steps.
TEST(Relaxation, HasTheComplexModulusOfABar) {
  constexpr double small = 1e-8;
  const Bar bar;
  const Body body(bar.config());
  for (const double frequency : {0.1, 1.0, 5.0}) {
    const double omega = frequency / bar.relaxation.time, period = 2 * std::numbers::pi / omega;
    const std::complex<double> product(0, frequency),
        expected = 1.0 + bar.relaxation.ratio * product / (1.0 + product);
    double before = 0;
    for (const int steps : {800, 1600, 6400}) {
      SpringSystem<double> system(body, {});
      State<double> state = system.undeformed_state();
      const auto strain_to = [&](double t) {
        state.t = t;
        const double strain = small * std::sin(omega * t);
        bar.stretch(body, state.x, strain, 0.25 * strain);
      };
      const double at_rest = [&] {
        bar.stretch(body, state.x, small, 0.25 * small);
        return pull_of_end(system, state) / small;
      }();
      const int periods = 3 + int(20 * bar.relaxation.time / period);  // until it has settled
      std::complex<double> sum = 0;
      for (int n = 0; n <= periods * steps; ++n) {
        strain_to(n * period / steps);
        system.memory()->come_to(state);
        if (n > (periods - 1) * steps) sum += pull_of_end(system, state) * std::polar(1.0, -omega * state.t);
      }
      const std::complex<double> modulus = sum * std::complex<double>(0, 2.0 / steps) / small / at_rest;
      const double error = std::abs(modulus - expected);
      if (steps == 1600) {
        EXPECT_LT(error, before / 3.5) << frequency;
      }
      if (steps == 6400) {
        EXPECT_LT(error, 1e-6) << frequency;
      }
      before = error;
    }
  }
}

/// Under a load that grows at a constant rate until `grown` and stays, strains are s / E times
/// 1 - ratio / (1 + ratio) creep / grown (exp(grown / creep) - 1) exp(-t / creep), creep = (1 + ratio) time.
TEST(Relaxation, CreepsAsABarShould) {
  Bar bar;
  BodyConfig config = bar.config();
  config.density = 1e-6;  // nothing swings
  const Body body(config);
  const double ratio = bar.relaxation.ratio, creep = (1 + ratio) * bar.relaxation.time, grown = 0.05,
               end = 0.3;
  Environment loaded;
  const Box all{Vec3(-1, -1, -1), Vec3(1, 1, 1)};
  for (int axis = 0; axis < 3; ++axis) {  // free to contract
    Hold hold{.box = all, .axes = {axis == 0, axis == 1, axis == 2}};
    hold.box.upper[axis] = 1e-6;
    loaded.holds.push_back(hold);
  }
  loaded.loads.push_back({{Vec3(0.8 - 1e-6, -1, -1), Vec3(1, 1, 1)}, Vec3(1e-8 * bar.young * 0.04, 0, 0)});
  const auto stretched = [&](const std::string& method, double dt) {
    SpringSystem<double> system(body, loaded);
    State<double> state = system.rest_state();
    Work work;
    EXPECT_EQ(find_integrator(method).make<double>({.dt = dt})->advance(system, state, end, work),
              Status::ok);
    double sum = 0;
    for (const std::ptrdiff_t site : system.particles())
      if (const Vec3 rest = body.rest_position(site); rest[0] > 0.8 - 1e-6)
        sum += state.x.at(site)[0] - rest[0];
    return sum;
  };
  const double finally = stretched("static", 0.1);
  loaded.loads.back().history = {{{0, 0}, {grown, 1}}};
  const double expected =
      1 - ratio / (1 + ratio) * creep / grown * std::expm1(grown / creep) * std::exp(-end / creep);
  double before = 0;
  for (const double dt : {0.01, 0.005, 0.001}) {
    const double error = std::abs(stretched("tr_bdf2", dt) / finally - expected);
    if (dt == 0.005) {
      EXPECT_LT(error, before / 3.5);
    }
    if (dt == 0.001) {
      EXPECT_LT(error, 1e-6);
    }
    before = error;
  }
}

/// At a strain that does not change stress is E e (1 + ratio exp(-t / time)).
TEST(Relaxation, RelaxesAsABarShould) {
  const Bar bar;
  const Body body(bar.config());
  SpringSystem<double> system(body, {});
  State<double> state = system.undeformed_state();
  system.memory()->come_to(state);
  bar.stretch(body, state.x, 1e-6, 0.25e-6);
  system.memory()->come_to(state);
  const double at_once = pull_of_end(system, state), ratio = bar.relaxation.ratio;
  for (const double t : {0.01, 0.3, 2.0}) {
    state.t = t;
    EXPECT_NEAR(pull_of_end(system, state) / at_once,
                (1 + ratio * std::exp(-t / bar.relaxation.time)) / (1 + ratio), 1e-9);
  }
}

/// What kinetic and stored energies lose is what dampers of branches have dissipated.
TEST(Relaxation, BalancesEnergy) {
  BodyConfig config = relaxing(VoxelGrid::box(3, 3, 3));
  config.damping = {};
  const Body body(config);
  for (const char* name : {"damped_verlet", "tr_bdf2"}) {
    double before = 0;
    for (const double dt : {4e-4, 2e-4}) {
      SpringSystem<double> system(body, {});
      State<double> state = system.rest_state();
      testing::randomise(body, state, 0, 0.3, 7);
      const Measures start = measure(system, state);
      const auto method = find_integrator(name).make<double>({.dt = dt});
      Work work;
      ASSERT_EQ(method->advance(system, state, 0.2, work), Status::ok);
      const Measures end = measure(system, state);
      EXPECT_GT(end.relaxed, 0.2 * start.total()) << name;
      EXPECT_GT(end.relaxing, 0);
      const double error = std::abs(end.total() + end.relaxed - start.total());
      if (dt == 2e-4) {
        EXPECT_LT(error, 0.35 * before) << name;
        EXPECT_LT(error, 1e-3 * start.total()) << name;
      }
      before = error;
    }
  }
}

/// Of positions at a time, against steps far smaller.
double error_at(const std::string& name, double dt) {
  BodyConfig config = relaxing(VoxelGrid::box(2, 2, 2));
  const Body body(config);
  const auto end_of = [&](const std::string& method, double step) {
    SpringSystem<double> system(body, {});
    State<double> state = system.rest_state();
    testing::randomise(body, state, 0, 0.3, 7);
    const auto stepper = find_integrator(method).make<double>({.dt = step});
    Work work;
    EXPECT_EQ(stepper->advance(system, state, 0.096, work), Status::ok) << method;
    return state.x;
  };
  static const Field<double> exact = end_of("damped_verlet", 0.096 / 16384);
  return (end_of(name, dt).array() - exact.array()).abs().maxCoeff();
}

TEST(Relaxation, LeavesMethodsTheirOrder) {
  int tested = 0;
  for (const IntegratorInfo& method : integrators()) {
    if (!method.relaxes || method.stepping != Stepping::fixed) continue;
    const double order = std::log2(error_at(method.name, 0.096 / 256) / error_at(method.name, 0.096 / 512));
    EXPECT_NEAR(order, method.order_damped, 0.25) << method.name;
    ++tested;
  }
  EXPECT_GE(tested, 10);
}

/// Verlet multiplies a mode in which all springs relax alike, w^2 at rest, by roots of a cubic; at -1
/// w^2 dt^2 (1 + ratio tanh(h/2) / (h/2)) = 4, h = dt / time.
TEST(Relaxation, LimitsExplicitStepsAsPredicted) {
  BodyConfig config = relaxing(VoxelGrid::box(1, 1, 1), 0.8, 0.01);
  config.springs.volume = 0;
  config.damping = {};
  const Body body(config);
  SpringSystem<double> resting(body, {});
  State<double> state = resting.rest_state();
  SparseMatrix matrix = resting.tangents()->pattern();
  resting.tangents()->values(0, state.x, state.v, {.stiffness = 1, .kind = Tangent::elastic}, matrix);
  const double mass = body.mass(body.sites().front());
  const double omega_squared = testing::symmetric_eigenvalues(matrix).maxCoeff() / mass;
  const auto excess = [&](double dt) {
    const double half = dt / config.relaxation.time / 2;
    return omega_squared * dt * dt * (1 + config.relaxation.ratio * std::tanh(half) / half) - 4;
  };
  double low = 0, high = 3 / std::sqrt(omega_squared);
  for (int n = 0; n < 60; ++n) (excess((low + high) / 2) > 0 ? high : low) = (low + high) / 2;
  const double limit = low;
  EXPECT_LT(limit, 0.95 * 2 / std::sqrt(omega_squared));
  EXPECT_GE(limit, guaranteed_step(find_integrator("semi_implicit_euler"), resting.spectral_bound()));
  const auto grows = [&](double dt) {
    SpringSystem<double> system(body, {});
    State<double> start = system.rest_state();
    testing::randomise(body, start, 1e-9, 0, 7);
    const auto method = find_integrator("semi_implicit_euler").make<double>({.dt = dt});
    Work work;
    const Field<double> rest = system.rest_state().x;
    const Status status = method->advance(system, start, 3000 * dt, work);
    return status != Status::ok || (start.x.array() - rest.array()).abs().maxCoeff() > 1e-7;
  };
  EXPECT_FALSE(grows(0.995 * limit));
  EXPECT_TRUE(grows(1.005 * limit));
}

/// As explicit steps meet it: before the first step all has relaxed, at a state that it has come to nothing.
TEST(Relaxation, MakesVibrationsFasterAtOnce) {
  const Bar bar;
  const Body body(bar.config());
  SpringSystem<double> system(body, {});
  const State<double> rest = system.undeformed_state();
  Work work;
  const double relaxed = fastest_mode(system, rest, work).modes.front().omega;
  system.memory()->come_to(rest);
  EXPECT_NEAR(fastest_mode(system, rest, work).modes.front().omega / relaxed,
              std::sqrt(1 + bar.relaxation.ratio), 1e-9);
}

std::string problem_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Relaxation, IsRefusedByWhatDoesNotFollowIt) {
  const Body body(relaxing(VoxelGrid::box(2, 2, 2)));
  SpringSystem<double> system(body, {});
  int refused = 0;
  for (const IntegratorInfo& method : integrators()) {
    if (method.relaxes || !method.moves_particles()) continue;
    const std::string problem = problem_of([&] { method.make<double>({})->check(system); });
    EXPECT_THAT(problem, ::testing::HasSubstr("material.relaxation")) << method.name;
    ++refused;
  }
  EXPECT_GT(refused, 8);
  EXPECT_THAT(problem_of([&] {
                SpringSystem<double>(body, {}, {1, {}, {.bound = 1e-3}});
              }),
              ::testing::HasSubstr("solve.sleep"));
}

constexpr const char* relaxing_scene = R"(
[body]
cells = [2, 2, 2]
cell_size = 0.1
[material]
density = 1000
young = 1e5
poisson = 0.3
relaxation = { ratio = 0.25, time = 0.3 }
[solve]
integrator = "damped_verlet"
duration = 0.1
)";

TEST(Relaxation, IsReadFromScenes) {
  const Scene scene = parse_scene(relaxing_scene, {});
  EXPECT_EQ(scene.body.relaxation.ratio, 0.25);
  EXPECT_EQ(scene.body.relaxation.time, 0.3);
  const auto refusal = [](const std::vector<std::string>& settings) {
    return problem_of([&] { parse_scene(relaxing_scene, settings); });
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(refusal({"material.relaxation.ratio=-1"}), HasSubstr("a ratio of stiffnesses"));
  EXPECT_THAT(refusal({"material.relaxation.time=0"}), HasSubstr("a positive number of seconds"));
  EXPECT_THAT(refusal({"material.relaxation.tau=1"}), HasSubstr("tau"));
  EXPECT_THAT(refusal({"material.model=corotational"}), HasSubstr("is of springs, and material.model"));
  EXPECT_THAT(refusal({"body.refinement=auto"}), HasSubstr("material.relaxation"));
}

/// What has been strained for ever has relaxed: the same as if there were no branches.
TEST(Relaxation, HasNoPartInEquilibria) {
  const Bar bar;
  Environment held;
  held.gravity = Vec3(0, 0, -2);
  held.holds.push_back({.box = {Vec3(-1, -1, -1), Vec3(1e-6, 1, 1)}});
  const auto end_of = [&](bool relaxes, const std::string& name) {
    const Body body(bar.config(relaxes));
    SpringSystem<double> system(body, held);
    State<double> state = system.rest_state();
    Work work;
    EXPECT_EQ(find_integrator(name).make<double>({})->advance(system, state, 1, work), Status::ok);
    return state.x;
  };
  for (const char* name : {"static", "static/lbfgs"})
    EXPECT_LT((end_of(true, name).array() - end_of(false, name).array()).abs().maxCoeff(), 1e-8) << name;
}

TEST(Relaxation, IsSolvedByQuasiNewtonMethods) {
  const Body body(relaxing(VoxelGrid::box(4, 3, 3)));
  const auto end_of = [&](const std::string& name) {
    SpringSystem<double> system(body, {});
    State<double> state = system.rest_state();
    testing::randomise(body, state, 0, 0.3, 7);
    Work work;
    EXPECT_EQ(find_integrator(name).make<double>({.dt = 1e-2})->advance(system, state, 0.1, work),
              Status::ok);
    return state.x;
  };
  const Field<double> newton = end_of("backward_euler");
  EXPECT_LT((end_of("backward_euler/lbfgs").array() - newton.array()).abs().maxCoeff(), 1e-6);
}

/// Goes on from what it keeps as if it had not stopped.
TEST(Relaxation, IsKeptInRecords) {
  const Body body(relaxing(VoxelGrid::box(2, 3, 2)));
  SpringSystem<double> whole(body, {}), first(body, {}), second(body, {});
  State<double> state = whole.rest_state();
  testing::randomise(body, state, 0, 0.3, 7);
  State<double> halved = state;
  const IntegratorInfo& info = find_integrator("damped_verlet");
  const auto one = info.make<double>({.dt = 1e-3}), two = info.make<double>({.dt = 1e-3}),
             three = info.make<double>({.dt = 1e-3});
  Work work;
  for (const double until : {0.05, 0.1}) ASSERT_EQ(one->advance(whole, state, until, work), Status::ok);
  ASSERT_EQ(two->advance(first, halved, 0.05, work), Status::ok);
  Record made;
  first.remember(made);
  two->remember(first, made);
  Record read(made.take_bytes());
  second.remember(read);
  three->remember(second, read);
  EXPECT_TRUE(read.at_end());
  ASSERT_EQ(three->advance(second, halved, 0.1, work), Status::ok);
  EXPECT_EQ((state.x.array() - halved.x.array()).abs().maxCoeff(), 0);
  EXPECT_EQ(measure(whole, state).relaxed, measure(second, halved).relaxed);
}

}  // namespace
}  // namespace mss

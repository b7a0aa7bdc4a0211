// Every method, linear and nonlinear solver drives a rope and a sheet, or refuses it in words.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "core/base/error.hpp"
#include "core/measures/measures.hpp"
#include "core/springs/spring_system.hpp"
#include "integrators/analysis/modes.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "integrators/linear/linear_solver.hpp"
#include "integrators/nonlinear/implicit_stage.hpp"
#include "reference/closed_forms.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

BodyConfig small_flat_body(int nx, int ny, int nz) {
  BodyConfig config{.voxels = VoxelGrid::box(nx, ny, nz),
                    .cell_size = 0.1,
                    .thickness = 0.02,
                    .density = 1000,
                    .damping = {.law = Damping::Law::viscosity, .viscosity = 20}};
  config.fill({.young = 1e5, .poisson = 1.0 / 3}, 0.5);
  return config;
}

/// Held at the particles at its lowest place along each extent, it falls and swings.
Environment held_at_one_end(const BodyConfig& config) {
  Vec3 far = Vec3::Constant(0);
  for (int axis = 0; axis < 3; ++axis)
    if (axis != 0 || config.voxels.nx() == 0) far[axis] = 10;
  return {.gravity = {0, 1, -9.81}, .holds = {{.box = {Vec3::Zero(), far}}}};
}

const std::vector<BodyConfig>& driven_bodies() {
  static const std::vector<BodyConfig> all{small_flat_body(6, 0, 0), small_flat_body(4, 3, 0),
                                           small_flat_body(5, 0, 3)};
  return all;
}

State<double> flat_after(const IntegratorInfo& method, const BodyConfig& config, double dt, double seconds,
                         const IntegratorOptions& options = {}) {
  const Body body(config);
  SpringSystem<double> system(body, held_at_one_end(config), {.threads = 1});
  State<double> state = system.rest_state();
  IntegratorOptions chosen = options;
  chosen.dt = dt;
  chosen.length_scale = config.cell_size;
  Work work;
  EXPECT_EQ(method.make<double>(chosen)->advance(system, state, seconds, work), Status::ok) << method.name;
  return state;
}

double flat_apart(const State<double>& a, const State<double>& b) {
  return (a.x.array() - b.x.array()).abs().maxCoeff();
}

constexpr double flat_seconds = 0.1;

/// Where each body is after a while, to rounding.
const std::vector<State<double>>& true_states() {
  static const std::vector<State<double>> all = [] {
    std::vector<State<double>> states;
    for (const BodyConfig& config : driven_bodies())
      states.push_back(flat_after(find_integrator("rk4"), config, 1e-5, flat_seconds));
    return states;
  }();
  return all;
}

class FlatMethod : public ::testing::TestWithParam<std::string> {};

TEST_P(FlatMethod, DrivesRopesAndSheets) {
  const IntegratorInfo& method = find_integrator(GetParam());
  for (std::size_t i = 0; i < driven_bodies().size(); ++i) {
    const BodyConfig& config = driven_bodies()[i];
    if (method.springs_only && !method.has_modulus) {
      try {
        flat_after(method, config, 1e-4, flat_seconds);
        FAIL() << method.name << " takes regions of a body without cells";
      } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find(config.noun()), std::string::npos) << error.what();
      }
      continue;
    }
    if (!method.moves_particles()) continue;  // equilibria below, and what is for reduced bodies
    const State<double> end = flat_after(method, config, 1e-4, flat_seconds,
                                         {.tolerance = 1e-8, .iterations = method.springs_only ? 50 : 0});
    const double moved = 0.5 * 9.81 * flat_seconds * flat_seconds;
    EXPECT_LT(flat_apart(end, true_states()[i]), 0.03 * moved) << method.name << ", body " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Every, FlatMethod, ::testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const IntegratorInfo& info : integrators()) names.push_back(info.name);
                           return names;
                         }()),
                         [](const auto& info) { return info.param; });

TEST(FlatSolvers, SolveOrRefuseInWords) {
  const IntegratorInfo& method = find_integrator("backward_euler");
  const State<double> expected = flat_after(method, driven_bodies()[1], 1e-3, flat_seconds);
  for (const LinearSolverInfo& solver : linear_solvers()) {
    if (solver.name == "multigrid" || solver.name == "separable") {
      EXPECT_THROW(flat_after(method, driven_bodies()[1], 1e-3, flat_seconds, {.linear_solver = solver.name}),
                   InputError)
          << solver.name;
      continue;
    }
    const State<double> end =
        flat_after(method, driven_bodies()[1], 1e-3, flat_seconds, {.linear_solver = solver.name});
    EXPECT_LT(flat_apart(end, expected), 1e-8) << solver.name;
  }
  for (const NonlinearSolverInfo& solver : nonlinear_solvers())
    if (solver.name != "newton") {
      EXPECT_THROW(
          flat_after(method, driven_bodies()[1], 1e-3, flat_seconds, {.nonlinear_solver = solver.name}),
          InputError)
          << solver.name;
    }
}

/// Where a rope hangs each link's tension is the weight below it. It begins beside that, not folded on its
/// line.
TEST(FlatEquilibria, HaveTheTensionOfTheWeightBelow) {
  const BodyConfig config = small_flat_body(0, 0, 8);
  const Body body(config);
  const double top = 8 * config.cell_size;
  const Vec3 gravity(1, 0, -9.81);
  for (const char* method : {"static", "dynamic_relaxation"}) {
    SpringSystem<double> system(body, {.gravity = gravity, .holds = {{.box = {{0, 0, top}, {0, 0, top}}}}},
                                {.threads = 1});
    State<double> state = system.rest_state();
    Work work;
    const double dt = 0.9 * stable_step(find_integrator("verlet"), system.spectral_bound());
    ASSERT_EQ(find_integrator(method)
                  .make<double>({.dt = dt, .tolerance = 1e-9, .length_scale = config.cell_size})
                  ->advance(system, state, 1, work),
              Status::ok)
        << method;
    double below = 0;
    for (std::size_t p = 0; p + 1 < body.particle_count(); ++p) {
      below += gravity.norm() * body.mass(body.sites()[p]);
      const double length = (state.x.at(body.sites()[p + 1]) - state.x.at(body.sites()[p])).norm();
      EXPECT_NEAR(config.springs.edge * (length - config.cell_size), below, 1e-5 * below) << method;
    }
  }
}

/// About a stretched rope; about one at rest nothing is resisted across it.
TEST(FlatModes, AreThoseOfTheChain) {
  const BodyConfig config = small_flat_body(0, 12, 0);
  const Body body(config);
  const double length = 12 * config.cell_size, strain = 0.1;
  const Hold lower{.box = {{0, 0, 0}, {0, 0, 0}}},
      upper{.box = {{0, length, 0}, {0, length, 0}}, .displacement = {0, strain * length, 0}};
  SpringSystem<double> system(body, {.holds = {lower, upper}}, {.threads = 1});
  Work work;
  const Modes slack = slowest_modes(system, system.undeformed_state(), 2, work);
  ASSERT_EQ(slack.status, Status::ok);
  EXPECT_EQ(slack.modes.front().omega, 0);
  State<double> state = system.rest_state();
  ASSERT_EQ(find_integrator("static").make<double>({})->advance(system, state, 1, work), Status::ok);
  const Modes modes = slowest_modes(system, state, 4, work);
  ASSERT_EQ(modes.status, Status::ok);
  const double area = 0.02 * 0.02;
  const reference::Stretched string{
      .length = (1 + strain) * length, .tension = 1e5 * area * strain, .mass = 1000 * area / (1 + strain)};
  for (std::size_t i = 0; i < 4; ++i)  // each in two directions
    EXPECT_NEAR(modes.modes[i].omega / (2 * std::numbers::pi) /
                    reference::beaded_string_frequency(string, 12, 1 + int(i / 2)),
                1, 1e-9);
}

/// Undamped and free: what is conserved stays, as of solids.
TEST(FlatMotion, KeepsEnergyMomentumAndSpin) {
  for (BodyConfig config : driven_bodies()) {
    config.damping = {};
    const Body body(config);
    const auto drift = [&](const char* method, double dt) {
      SpringSystem<double> system(body, {}, {.threads = 1});
      State<double> state = system.rest_state();
      testing::randomise(body, state, 0.2, 0.3, 5);
      const Measures before = measure(system, state);
      Work work;
      EXPECT_EQ(find_integrator(method).make<double>({.dt = dt})->advance(system, state, 1, work),
                Status::ok);
      const Measures after = measure(system, state);
      EXPECT_LT((after.momentum - before.momentum).norm(), 1e-9 * 0.3 * body.total_mass()) << method;
      EXPECT_LT((after.angular_momentum - before.angular_momentum).norm(), 1e-9 * before.kinetic) << method;
      return std::abs(after.mechanical() / before.mechanical() - 1);
    };
    EXPECT_LT(drift("energy_momentum", 1e-2), 1e-8);
    EXPECT_LT(drift("verlet", 1e-4), 1e-2);
    EXPECT_LT(drift("pefrl", 1e-3), 1e-4);
  }
}

TEST(FlatContact, RestsOnAPlane) {
  for (const ContactLaw law : {ContactLaw::impulse, ContactLaw::penalty})
    for (const char* method : {"verlet", "backward_euler", "xpbd", "vbd"}) {
      const BodyConfig config = small_flat_body(4, 3, 0);
      const Body body(config);
      Plane ground;
      ground.point = {0, 0, -0.05};
      ground.contact = law;
      SpringSystem<double> system(body, {.gravity = {0, 0, -9.81}, .planes = {ground}}, {.threads = 1});
      State<double> state = system.rest_state();
      Work work;
      ASSERT_EQ(find_integrator(method).make<double>({.dt = 5e-4})->advance(system, state, 2, work),
                Status::ok)
          << method;
      for (const std::ptrdiff_t site : body.sites()) {
        EXPECT_NEAR(state.x.at(site)[2], -0.05, 2e-3) << method;
        EXPECT_LT(state.v.at(site).norm(), 0.02) << method;
      }
    }
}

}  // namespace
}  // namespace mss

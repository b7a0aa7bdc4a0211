// Steps of methods on a device against those of the processor, and against Algorithm 1.
#include <cstring>

#include "core/device/device.hpp"
#include "tests/integrators/device/on_device.hpp"

namespace mss {
namespace {

using testing::Driven;

const Vec3 gravity(0.3, -0.2, -9.81);

std::vector<std::string> methods_on_devices() {
  std::vector<std::string> names;
  for (const IntegratorInfo& info : integrators())
    if (info.make_double_on_device) names.push_back(info.name);
  return names;
}

/// Bodies of every kind: shapes, damped or not, guarded, ragged fills of several parts.
std::vector<std::pair<std::string, BodyConfig>> bodies() {
  std::vector<std::pair<std::string, BodyConfig>> all;
  for (const auto& shape : testing::test_shapes()) {
    BodyConfig config = testing::test_config(shape.voxels);
    all.emplace_back(shape.name, config);
    config.damping.law = Damping::Law::none;
    config.fold_guard = 400;
    all.emplace_back(shape.name + " guarded", config);
    testing::add_parts(config);
    testing::fill_randomly(config, 5);
    all.emplace_back(shape.name + " of parts", config);
  }
  return all;
}

/// What a step of semi-implicit Euler makes of velocities against what the oracle's forces do, over the
/// largest velocity. Positions are rounded to their own last digit, which says nothing of the step.
template <class Real>
double error_of_one_step(const BodyConfig& config, double dt) {
  Driven<Real> driven(config, {.gravity = gravity}, "semi_implicit_euler", {.dt = dt, .device = "gpu"});
  reference::Algorithm1 oracle(config, gravity, 1);
  testing::randomise(driven.body, driven.state, 0.4, 0.5, 3);
  testing::copy_state(driven.body, driven.state, oracle);
  const State<Real> before = driven.state;
  EXPECT_EQ(driven.advance(dt), Status::ok);
  oracle.compute_forces();
  double moved = 0, error = 0;
  for (std::size_t id = 0; id < driven.body.particle_count(); ++id) {
    const std::ptrdiff_t site = driven.body.sites()[id];
    const Vec3 v = before.v.at(site) + dt / driven.body.mass(site) * oracle.particles()[id].f;
    moved = std::max(moved, v.norm());
    error = std::max(error, (v - driven.state.v.at(site)).norm());
  }
  EXPECT_GT(moved, 0);
  return error / moved;
}

TEST(DeviceSteps, EqualTheOracleInDouble) {
  for (const auto& [name, config] : bodies())
    EXPECT_LT(error_of_one_step<double>(config, 1e-2), 1e-13) << name;
}

TEST(DeviceSteps, EqualTheOracleInSingle) {
  for (const auto& [name, config] : bodies()) EXPECT_LT(error_of_one_step<float>(config, 1e-2), 1e-6) << name;
}

/// Of 200 steps on a device and on the processor, the largest difference of a position over the largest way.
/// The thesis's Verlet is compared with the same recursion kept as velocities: kept as positions it loses
/// several digits of single precision.
template <class Real>
double difference_after(const BodyConfig& config, const Environment& environment, const std::string& method,
                        double dt) {
  Driven<Real> there(config, environment, method, {.dt = dt, .device = "gpu"});
  Driven<Real> here(config, environment, method == "verlet" ? "semi_implicit_euler" : method, {.dt = dt});
  testing::randomise(here.body, here.state, 0.1, 0.5, 3);
  here.system.constrain(0, here.state.x, here.state.v);
  there.state = here.state;
  const State<Real> before = here.state;
  EXPECT_EQ(there.advance(200 * dt), Status::ok);
  EXPECT_EQ(here.advance(200 * dt), Status::ok);
  EXPECT_EQ(there.work.steps, here.work.steps);
  EXPECT_EQ(there.state.t, here.state.t);
  const double way = testing::largest_difference(here.body, here.state.x, before.x);
  EXPECT_GT(way, 0.01);
  return testing::largest_difference(here.body, here.state.x, there.state.x) / way;
}

Environment busy_environment() {
  Environment environment{.gravity = gravity};
  environment.holds.push_back({.box = {Vec3(-1, -1, -1), Vec3(0.31, 2, 2)},
                               .axes = {true, false, true},
                               .velocity = Vec3(0.1, 0, 0.2),
                               .turn = Turn{.axis = Vec3::UnitX(), .rate = 0.5}});
  environment.loads.push_back({.box = {Vec3(1, -1, -1), Vec3(9, 9, 9)},
                               .force = Vec3(3, 1, 2),
                               .history = {{{0, 0}, {0.05, 1}, {0.1, 0.3}}}});
  return environment;
}

TEST(DeviceSteps, FollowTheProcessorsByEveryMethod) {
  const BodyConfig config = testing::test_config(VoxelGrid::box(7, 3, 4));
  for (const std::string& method : methods_on_devices())
    for (const Environment& environment : {Environment{.gravity = gravity}, busy_environment()}) {
      EXPECT_LT(difference_after<double>(config, environment, method, 1e-3), 1e-10) << method;
      EXPECT_LT(difference_after<float>(config, environment, method, 1e-3), 1e-4) << method;
    }
}

TEST(DeviceSteps, FollowTheProcessorsWithSheetsAndRopes) {
  for (const auto& cells : {std::array{9, 6, 0}, std::array{0, 7, 5}, std::array{12, 0, 0}}) {
    BodyConfig config = testing::test_config(VoxelGrid::box(cells[0], cells[1], cells[2]));
    config.thickness = 0.1;
    config.springs.volume = 0;
    EXPECT_LT(difference_after<double>(config, busy_environment(), "damped_verlet", 1e-3), 1e-10) << cells[0];
    EXPECT_LT(difference_after<float>(config, busy_environment(), "damped_verlet", 1e-3), 1e-4) << cells[0];
  }
}

TEST(DeviceSteps, FollowTheProcessorsWithEveryBody) {
  for (const auto& [name, config] : bodies()) {
    if (name.rfind("random30", 0) != 0 && name.rfind("beam", 0) != 0) continue;
    EXPECT_LT(difference_after<double>(config, {.gravity = gravity}, "velocity_verlet", 1e-3), 1e-10) << name;
    EXPECT_LT(difference_after<float>(config, {.gravity = gravity}, "velocity_verlet", 1e-3), 1e-4) << name;
  }
}

}  // namespace
}  // namespace mss

// Bodies and obstacles: rest, motion that obstacles give, by methods that meet them after steps, inside steps
// and by forces.
#include "core/environment/obstacle.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>

#include "core/measures/measures.hpp"
#include "core/measures/reactions.hpp"
#include "core/mesh/shapes.hpp"
#include "core/springs/spring_system.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "integrators/integrator.hpp"
#include "tests/body_derivatives.hpp"
#include "tests/centre_of_mass.hpp"
#include "tests/mesh_body.hpp"
#include "tests/random_bodies.hpp"
#include "tests/several_bodies.hpp"

namespace mss::obstacle_systems_test {
namespace {

using testing::g;

/// Of 10 cm, its middle above the origin and its lowest particles at z = 0.
BodyConfig little_cube() {
  BodyConfig config{.voxels = VoxelGrid::box(2, 2, 2), .cell_size = 0.05, .origin = {-0.05, -0.05, 0}};
  config.density = 1000;
  config.fill({.young = 1e5, .poisson = 0.3}, 0.5);
  config.damping = {.law = Damping::Law::ratio, .zeta = 0.3};
  return config;
}

struct ObstacleTrial {
  Body body;
  SpringSystem<double> system;
  ReactionGauge<double> gauge;
  State<double> state;
  std::unique_ptr<Integrator<double>> method;
  Work work;

  ObstacleTrial(const std::string& name, const Environment& environment,
                const BodyConfig& config = little_cube(), int threads = 1, const SleepRule& sleep = {})
      : body(config),
        system(body, environment, {.threads = threads, .sleep = sleep}),
        gauge(system, environment),
        state(system.rest_state()) {
    const IntegratorInfo& info = find_integrator(name);
    const double dt = info.limit ? safe_share * stable_step(info, system.spectral_bound()) : 1.0 / 60;
    method = info.make<double>({.dt = dt, .iterations = info.springs_only ? 20 : 0});
  }
  void advance(double t) { ASSERT_EQ(method->advance(system, state, t, work), Status::ok) << "t = " << t; }
  Reactions mean_until(double t) {
    gauge.begin(state.t);
    advance(t);
    return gauge.read(system, state);
  }
  Vec3 centre() const { return testing::centre_of_mass(body, state); }
  Vec3 momentum() const { return measure(system, state).momentum; }
  double deepest() const {
    const ObstacleSurface surface(system.environment().obstacles[0]);
    double depth = 0;
    for (const std::ptrdiff_t site : body.sites())
      depth = std::max(depth, -surface.gap(state.x.at(site), state.t));
    return depth;
  }
};

Environment on(const Obstacle& obstacle) { return {.gravity = {0, 0, -g}, .obstacles = {obstacle}}; }

/// All shapes, each with a place at z = 0 to stand on; round ones as large as hills.
std::vector<Obstacle> stands() {
  const Obstacle table{.shape = ObstacleShape::box, .size = {0.4, 0.4, 0.2}, .centre = {0.03, 0.02, -0.1}};
  const Obstacle hill{.radius = 4, .centre = {0, 0, -4}};
  const Obstacle trunk{
      .shape = ObstacleShape::capsule, .radius = 4, .length = 2, .centre = {0, 0, -4}, .axis = Vec3::UnitY()};
  const Obstacle stump{
      .shape = ObstacleShape::cylinder, .radius = 0.2, .length = 1, .centre = {0.03, 0, -0.5}};
  const Obstacle block{
      .shape = ObstacleShape::mesh,
      .mesh = std::make_shared<TriangleMesh>(box_mesh(Vec3(-0.2, -0.2, -0.2), Vec3(0.2, 0.2, 0))),
      .centre = {0.02, 0, 0}};
  return {table, hill, trunk, stump, block};
}

TEST(Obstacles, CarryABodyAtRest) {
  for (Obstacle stand : stands())
    for (const auto& [method, law] :
         {std::pair("verlet", ContactLaw::impulse), std::pair("backward_euler", ContactLaw::impulse),
          std::pair("verlet", ContactLaw::penalty)}) {
      stand.contact = law;
      ObstacleTrial trial(method, on(stand));
      trial.advance(0.7);
      const Vec3 before = trial.centre();
      const Reactions mean = trial.mean_until(1);
      const double weight = trial.body.total_mass() * g;
      const std::string which =
          std::string(method) + " " + std::to_string(int(stand.shape)) + " " + std::to_string(int(law));
      EXPECT_NEAR(mean.obstacles[0][2], weight, 0.01 * weight) << which;
      EXPECT_LT(mean.obstacles[0].head<2>().norm(), 0.01 * weight) << which;
      EXPECT_LT((trial.centre() - before).norm(), 1e-5) << which;
      EXPECT_LT(trial.centre().head<2>().norm(), 1e-4) << which;
      EXPECT_LT(trial.deepest(), law == ContactLaw::penalty ? 1e-3 : 1e-9) << which;
      const Vec3 torque = (trial.centre() - stand.centre).cross(mean.obstacles[0]);
      EXPECT_LT((mean.torques[0] - torque).norm(), 1e-3 * weight) << which;
    }
}

TEST(Obstacles, GiveTheMomentumThatTheBodyGains) {
  Environment environment = on({.radius = 0.3, .centre = {0.02, 0.01, -0.302}, .friction = 0.6});
  environment.obstacles.push_back({.shape = ObstacleShape::box, .size = {2, 2, 0.2}, .centre = {0, 0, -0.5}});
  ObstacleTrial trial("velocity_verlet", environment);
  for (const double t : {0.05, 0.2, 0.6}) {
    const Vec3 before = trial.momentum();
    const double since = trial.state.t;
    const Reactions mean = trial.mean_until(t);
    const Vec3 given = (trial.state.t - since) * (mean.obstacles[0] + mean.obstacles[1] +
                                                  trial.body.total_mass() * trial.system.gravity());
    EXPECT_LT((trial.momentum() - before - given).norm(), 1e-12) << t;
  }
}

class ObstaclesBy : public ::testing::TestWithParam<std::string> {};

// It slips until it has the box's speed, and stops with it.
TEST_P(ObstaclesBy, CarryABodyAlongTheirPath) {
  Obstacle cart{
      .shape = ObstacleShape::box, .size = {0.3, 0.3, 0.1}, .centre = {0, 0, -0.05}, .friction = 0.6};
  cart.path.points = {{0.2, Vec3::Zero()}, {0.7, Vec3(0.2, 0, 0)}};
  ObstacleTrial trial(GetParam(), on(cart));
  trial.advance(0.2);
  const double start = trial.centre()[0];
  trial.advance(0.65);
  EXPECT_NEAR(trial.momentum()[0] / trial.body.total_mass(), 0.4, 0.01);
  // It lags by what the speed takes to reach under mu g.
  const double lag = 0.4 * 0.4 / (2 * 0.6 * g);
  EXPECT_NEAR(trial.centre()[0] - start, 0.18 - lag, 0.4 / 60);  // as far as a frame
  trial.advance(1.2);
  EXPECT_NEAR(trial.momentum().norm(), 0, 0.01 * trial.body.total_mass());
  EXPECT_NEAR(trial.centre()[0] - start, 0.2, 0.007);
  EXPECT_LT(trial.deepest(), 1e-9);
}

TEST_P(ObstaclesBy, TurnABodyByFriction) {
  Obstacle wheel{.shape = ObstacleShape::cylinder,
                 .radius = 0.2,
                 .length = 0.1,
                 .centre = {0, 0, -0.05},
                 .friction = 0.8};
  wheel.turn = Turn{.rate = 2};
  ObstacleTrial trial(GetParam(), on(wheel));
  trial.advance(1);
  double worst = 0;
  for (const std::ptrdiff_t site : trial.body.sites()) {
    const Vec3 expected = 2 * Vec3::UnitZ().cross(trial.state.x.at(site));
    worst = std::max(worst, (trial.state.v.at(site) - expected).norm());
  }
  EXPECT_LT(worst, 0.01);
  EXPECT_LT(trial.centre().head<2>().norm(), 2e-3);
}

TEST_P(ObstaclesBy, StopAFallingBody) {
  Environment environment = on({.radius = 0.2, .centre = {0.03, 0.01, -0.3}});
  environment.obstacles.push_back({.shape = ObstacleShape::box, .size = {3, 3, 0.2}, .centre = {0, 0, -0.5}});
  ObstacleTrial trial(GetParam(), environment);
  trial.advance(0.5);
  EXPECT_LT(trial.deepest(), 1e-9);
  EXPECT_GT(trial.centre().head<2>().norm(), 0.001);  // it rolls off
  EXPECT_GT(measure(trial.system, trial.state).min_jacobian, 0);
}

INSTANTIATE_TEST_SUITE_P(Methods, ObstaclesBy,
                         ::testing::Values("verlet", "backward_euler", "tr_bdf2", "xpbd", "vbd"),
                         [](const auto& info) { return info.param; });

TEST(Obstacles, AreNotPassedInAStep) {
  const Obstacle plate{.shape = ObstacleShape::box, .size = {1, 1, 1e-4}, .centre = {0, 0, -0.5}};
  for (const char* method : {"verlet", "backward_euler", "vbd"}) {
    ObstacleTrial trial(method, on(plate));
    for (const std::ptrdiff_t site : trial.body.sites()) trial.state.v.set(site, Vec3(0, 0, -4));
    trial.advance(0.15);
    for (const std::ptrdiff_t site : trial.body.sites()) ASSERT_GT(trial.state.x.at(site)[2], -0.5) << method;
  }
}

TEST(Obstacles, SupportAnEquilibrium) {
  for (const Obstacle& stand : stands()) {
    ObstacleTrial trial("static", on(stand));
    const Reactions mean = trial.mean_until(1);
    const double weight = trial.body.total_mass() * g;
    EXPECT_NEAR(mean.obstacles[0][2], weight, 1e-3 * weight) << int(stand.shape);
  }
}

TEST(Obstacles, TouchTheSurfaceOfAMesh) {
  const TriangleMesh mesh = box_mesh(Vec3(-0.05, -0.05, 0), Vec3(0.05, 0.05, 0.1));
  BodyConfig config = testing::mesh_config(mesh, 0.05);
  config.damping = {.law = Damping::Law::ratio, .zeta = 0.3};
  for (const ContactLaw law : {ContactLaw::impulse, ContactLaw::penalty}) {
    Obstacle table = stands()[0];
    table.contact = law;
    ObstacleTrial trial("verlet", testing::on_surface(on(table), mesh), config);
    trial.advance(0.3);
    const Vec3 before = trial.momentum();
    const double since = trial.state.t;
    const Reactions mean = trial.mean_until(0.6);
    const Vec3 weight = trial.body.total_mass() * trial.system.gravity();
    EXPECT_NEAR(mean.obstacles[0][2], -weight[2], 0.05 * weight.norm());
    if (law == ContactLaw::impulse) {
      EXPECT_LT((trial.momentum() - before - (trial.state.t - since) * (mean.obstacles[0] + weight)).norm(),
                1e-12);
    }
  }
}

TEST(Obstacles, SameBitsForAnyNumberOfThreads) {
  for (const char* method : {"velocity_verlet", "backward_euler", "xpbd", "vbd"}) {
    const Obstacle hill{.radius = 0.3, .centre = {0.01, 0.02, -0.301}};
    ObstacleTrial one(method, on(hill)), two(method, on(hill), little_cube(), 2);
    one.advance(0.1);
    two.advance(0.1);
    EXPECT_EQ(std::memcmp(one.state.x.axis(0), two.state.x.axis(0),
                          sizeof(double) * std::size_t(one.state.x.size())),
              0)
        << method;
  }
}

TEST(Obstacles, KeepAwakeWhatLiesOnThemWhileTheyMove) {
  Obstacle table = stands()[0];
  const SleepRule sleep{.bound = 1e-3, .after = 0.1};
  ObstacleTrial still("verlet", on(table), little_cube(), 1, sleep);
  still.advance(1.2);
  EXPECT_TRUE(still.system.all_asleep());
  table.path.points = {{1, Vec3::Zero()}, {2, Vec3(0.01, 0, 0)}};
  ObstacleTrial moving("verlet", on(table), little_cube(), 1, sleep);
  moving.advance(1.2);
  EXPECT_FALSE(moving.system.all_asleep());
  EXPECT_NEAR(moving.centre()[0], 0.002, 5e-4);
}

TEST(Obstacles, PenaltiesHaveTangentsAndABound) {
  Environment environment =
      on({.radius = 300, .centre = {0.01, 0.02, -299.995}, .contact = ContactLaw::penalty});
  environment.obstacles.push_back({.shape = ObstacleShape::box,
                                   .size = {1, 1, 1},
                                   .centre = {-0.53, 0, 0},
                                   .contact = ContactLaw::penalty,
                                   .friction = 0.9});
  const Body body(little_cube());
  SpringSystem<double> system(body, environment);
  State<double> state = system.rest_state();
  testing::randomise(body, state, 0.1, 0.5, 5);
  testing::compare_tangents_with_forces(system, state);
  const double alone = mss::spectral_bound(body).omega;
  EXPECT_GE(system.spectral_bound().omega, std::sqrt(3.0) * alone * (1 - 1e-12));
  environment.obstacles[0].path.points = {{0, Vec3::Zero()}, {1, Vec3(0, 0, -1)}};
  SpringSystem<double> falling(body, environment);
  const auto gaps = [&](double t) { return falling.events()->event_functions(t, falling.rest_state().x); };
  EXPECT_NEAR(gaps(0.5)[0] - gaps(0.25)[0], 0.25, 1e-3);
  EXPECT_EQ(gaps(0.5)[1], gaps(0.25)[1]);
}

TEST(Obstacles, CarrySeveralBodies) {
  const std::vector<BodyConfig> blocks{testing::rubber_block(VoxelGrid::box(2, 2, 2), Vec3(0, 0, 0)),
                                       testing::rubber_block(VoxelGrid::box(2, 2, 2), Vec3(0.2, 0, 0), 0.04)};
  for (const auto& [method, law] :
       {std::pair("verlet", ContactLaw::impulse), std::pair("verlet", ContactLaw::penalty),
        std::pair("backward_euler", ContactLaw::impulse)}) {
    Environment environment = on({.shape = ObstacleShape::box,
                                  .size = {1, 1, 0.2},
                                  .centre = {0, 0, -0.1},
                                  .contact = law,
                                  .restitution = 0});
    testing::SeveralBodies<double> bodies(blocks, environment);
    BodiesSystem<double>& system = bodies.system();
    ReactionGauge<double> gauge(system, environment);
    State<double> state = system.rest_state();
    const IntegratorInfo& info = find_integrator(method);
    const auto integrator = info.make<double>(
        {.dt = info.limit ? safe_share * stable_step(info, system.spectral_bound()) : 1.0 / 240});
    Work work;
    const Vec3 weight = system.total_mass() * system.gravity();
    const Vec3 before = measure(system, state).momentum;
    gauge.begin(0);
    ASSERT_EQ(integrator->advance(system, state, 0.2, work), Status::ok);
    const Reactions mean = gauge.read(system, state);
    const Vec3 given = measure(system, state).momentum - before - state.t * weight;
    if (law == ContactLaw::impulse) {
      EXPECT_LT((state.t * mean.obstacles[0] - given).norm(), 1e-9) << method;
    }
    EXPECT_GT(given[2], 0.15 * weight.norm()) << method;
  }
}

}  // namespace
}  // namespace mss::obstacle_systems_test

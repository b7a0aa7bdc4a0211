// Planes inside steps of 1/60 s, by every method that takes such steps: rest, slopes, a drop, a groove, any
// orientation.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstring>
#include <numbers>
#include <random>

#include "core/base/error.hpp"
#include "core/environment/plane_bounds.hpp"
#include "core/measures/measures.hpp"
#include "integrators/integrator.hpp"
#include "integrators/linear/linear_solver.hpp"
#include "tests/centre_of_mass.hpp"

namespace mss {
namespace {

using testing::g;
constexpr double frame = 1.0 / 60;

BodyConfig block(double young) {
  BodyConfig config{.voxels = VoxelGrid::box(4, 4, 4), .cell_size = 0.05};
  config.density = 1000;
  config.fill({.young = young, .poisson = 0.3}, 0.5);
  config.damping.zeta = 0.1;
  return config;
}

/// On level ground, with gravity inclined.
Environment slope(double degrees, double friction) {
  const double angle = degrees * std::numbers::pi / 180;
  return {.gravity = g * Vec3(std::sin(angle), 0, -std::cos(angle)), .planes = {{.friction = friction}}};
}

struct BoundsTrial {
  Body body;
  SpringSystem<double> system;
  State<double> state;
  std::unique_ptr<Integrator<double>> method;
  Work work;

  BoundsTrial(const std::string& name, double young, const Environment& environment, int threads = 1,
              double dt = frame, const std::string& linear_solver = "automatic")
      : body(block(young)),
        system(body, environment, {.threads = threads}),
        state(system.rest_state()),
        method(find_integrator(name).make<double>({.dt = dt, .linear_solver = linear_solver})) {}

  void advance(double t) { ASSERT_EQ(method->advance(system, state, t, work), Status::ok) << "t = " << t; }
  void move(const Vec3& by) {
    for (const std::ptrdiff_t site : body.sites()) state.x.set(site, state.x.at(site) + by);
  }
  Vec3 velocity() const { return measure(system, state).momentum / body.total_mass(); }
  /// The mean of particles whose rest position is at that height [m].
  Vec3 mean_at(double height) const {
    Vec3 sum = Vec3::Zero();
    int count = 0;
    for (const std::ptrdiff_t site : body.sites())
      if (std::abs(body.rest_position(site)[2] - height) < 1e-9) sum += state.x.at(site), ++count;
    return sum / count;
  }
  double deepest() const {
    double gap = std::numeric_limits<double>::infinity();
    for (const std::ptrdiff_t site : body.sites())
      for (const Plane& plane : system.environment().planes) gap = std::min(gap, plane.gap(state.x.at(site)));
    return gap;
  }
};

/// The impulse that a plane has given [N s].
Vec3 given(const BoundsTrial& trial, std::size_t plane) {
  Vec3 sum = Vec3::Zero();
  for (const std::ptrdiff_t site : trial.body.sites()) sum += trial.system.plane_impulses()->at(plane, site);
  return sum;
}

TEST(Bounds, AreOfImpulsesOnParticles) {
  Environment thesis = slope(0, 0.5), penalty = thesis;
  thesis.planes[0].contact = ContactLaw::thesis;
  penalty.planes[0].contact = ContactLaw::penalty;
  EXPECT_NE(BoundsTrial("backward_euler", 1e5, slope(0, 0.5)).system.bounds(), nullptr);
  EXPECT_EQ(BoundsTrial("backward_euler", 1e5, thesis).system.bounds(), nullptr);
  EXPECT_EQ(BoundsTrial("backward_euler", 1e5, penalty).system.bounds(), nullptr);
}

struct BoundsCase {
  std::string method;
  double young;
};
std::string name_of(const ::testing::TestParamInfo<BoundsCase>& info) {
  std::string name = info.param.method + (info.param.young < 5e5 ? "_soft" : "_stiff");
  for (char& letter : name)
    if (letter == '/' || letter == ':') letter = '_';
  return name;
}
std::vector<BoundsCase> cases(const std::vector<std::string>& methods) {
  std::vector<BoundsCase> all;
  for (const std::string& method : methods)
    for (const double young : {1e5, 1e6}) all.push_back({method, young});
  return all;
}
const std::vector<std::string> by_newton{"backward_euler", "backward_euler_linear", "implicit_midpoint",
                                         "tr_bdf2",        "generalized_alpha",     "energy_momentum"};
std::vector<std::string> and_also(std::vector<std::string> methods, const std::vector<std::string>& more) {
  methods.insert(methods.end(), more.begin(), more.end());
  return methods;
}

class InSteps : public ::testing::TestWithParam<BoundsCase> {};
INSTANTIATE_TEST_SUITE_P(Methods, InSteps,
                         ::testing::ValuesIn(cases(and_also(by_newton, {"backward_euler/lbfgs", "vbd:20"}))),
                         name_of);

/// Without friction, the answer of `static` where the bottom is held at its height.
double static_sag(double young) {
  Environment held{.gravity = {0, 0, -g}};
  held.holds = {{.box = {{0, 0, 0}, {0.2, 0.2, 0}}, .axes = {false, false, true}},
                {.box = {{0.1, 0.1, 0}, {0.1, 0.1, 0}}},
                {.box = {{0.2, 0.1, 0}, {0.2, 0.1, 0}}, .axes = {false, true, true}}};
  BoundsTrial at_rest("static", young, held);
  at_rest.advance(1);
  return 0.2 - at_rest.mean_at(0.2)[2];
}

/// Methods that keep what their steps do not resolve swing about it for long: their mean over time counts.
TEST_P(InSteps, ABlockRestsAsHighAsItMust) {
  BoundsTrial trial(GetParam().method, GetParam().young, slope(0, 0));
  double sum = 0;
  int count = 0;
  for (int step = 1; step <= 480; ++step) {
    trial.advance(step * frame);
    if (step > 240) sum += 0.2 - trial.mean_at(0.2)[2], ++count;
  }
  const double expected = static_sag(GetParam().young);
  EXPECT_NEAR(sum / count, expected, 0.01 * expected);
  EXPECT_GT(trial.deepest(), -1e-12);
}

TEST_P(InSteps, ABlockSticksToASlope) {
  BoundsTrial trial(GetParam().method, GetParam().young, slope(19, 0.5));
  const bool keeps_vibrations = GetParam().method == "implicit_midpoint" ||
                                GetParam().method == "energy_momentum" ||
                                GetParam().method == "generalized_alpha";
  const double at_rest = keeps_vibrations ? 8 : 5;
  trial.advance(at_rest);
  const Vec3 before = trial.mean_at(0);
  trial.advance(at_rest + 1.5);
  const double creep = (trial.mean_at(0) - before).norm();
  EXPECT_LT(creep, GetParam().method == "vbd:20" ? 5e-4 : 1e-5);
  EXPECT_GT(trial.deepest(), -1e-12);
}

TEST_P(InSteps, ABlockSlidesDownASlope) {
  BoundsTrial trial(GetParam().method, GetParam().young, slope(30, 0.3));
  trial.advance(0.5);
  const Vec3 before = trial.velocity();
  trial.advance(1.5);
  const double angle = std::numbers::pi / 6, expected = g * (std::sin(angle) - 0.3 * std::cos(angle));
  EXPECT_NEAR(trial.velocity()[0] - before[0], expected, 0.01 * expected);
  EXPECT_GT(trial.deepest(), -1e-12);
}

TEST_P(InSteps, ADropGainsNoEnergy) {
  BoundsTrial trial(GetParam().method, GetParam().young, slope(0, 0.5));
  trial.move({0, 0, 0.1});
  const double potential = measure(trial.system, trial.state).external_potential,
               start = trial.body.total_mass() * g * 0.1;
  bool touched = false;
  for (int step = 1; step <= 60; ++step) {
    trial.advance(step * frame);
    EXPECT_LT(measure(trial.system, trial.state).total() - potential + start, 1.001 * start) << step;
    EXPECT_GT(trial.deepest(), -1e-12) << step;
    touched = touched || trial.deepest() < 1e-9;
  }
  EXPECT_TRUE(touched);
}

// An impact without gravity has no other scale than momentum.
TEST(Bounds, StopABlockWithoutGravity) {
  for (const std::string method : {"backward_euler_linear", "backward_euler", "implicit_midpoint"}) {
    BoundsTrial trial(method, 1e6, {.planes = {{.friction = 0.4}}});
    trial.move({0, 0, 0.01});
    for (const std::ptrdiff_t site : trial.body.sites()) trial.state.v.set(site, {0.3, 0, -1});
    trial.advance(0.5);
    EXPECT_GT(trial.velocity()[2], 0) << method;
    EXPECT_LT(trial.velocity()[0], 0.25) << method;
    EXPECT_GE(trial.deepest(), -1e-12) << method;
  }
}

TEST(Bounds, StopWhatComesToRest) {
  for (const std::string method : {"static", "static/lbfgs"}) {
    BoundsTrial on_ground(method, 1e6, slope(0, 0.5)), above(method, 1e6, slope(0, 0.5)),
        sticking(method, 1e6, slope(19, 0.5));
    above.move({0, 0, 0.1});
    const double close = method == "static" ? 1e-6 : 5e-3;  // one moves until 1e-6 m are left
    for (BoundsTrial* trial : {&on_ground, &above, &sticking}) {
      trial->advance(1);
      const Vec3 weight = trial->body.total_mass() * trial->system.environment().gravity;
      EXPECT_LT((given(*trial, 0) + weight).norm(), close * weight.norm()) << method;  // in one second
      EXPECT_GE(trial->deepest(), -1e-12) << method;
    }
    EXPECT_NEAR(above.mean_at(0.2)[2], on_ground.mean_at(0.2)[2], 1e-7) << method;
    EXPECT_NEAR(0.2 - on_ground.mean_at(0.2)[2], 1.8e-4, 2e-6) << method;
    BoundsTrial sliding(method, 1e6, slope(30, 0.3));
    EXPECT_EQ(sliding.method->advance(sliding.system, sliding.state, 1, sliding.work),
              Status::newton_stalled);
  }
}

TEST(Bounds, AGrooveHoldsABlock) {
  for (const std::string& method : and_also(by_newton, {"backward_euler/lbfgs", "vbd:20", "xpbd:20"})) {
    SCOPED_TRACE(method);
    Environment groove{.gravity = {-g / 2, 0, -g}};
    for (const Vec3& normal : {Vec3(1, 0, 0), Vec3(0, 0, 1)})
      groove.planes.push_back({.normal = normal, .friction = 0.2});
    BoundsTrial trial(method, 1e5, groove);
    trial.move({0.01, 0, 0.01});
    trial.advance(4);
    EXPECT_GT(trial.deepest(), -1e-12);
    EXPECT_LT(trial.deepest(), 1e-12);
    const Vec3 bottom = trial.mean_at(0);
    EXPECT_NEAR(bottom[0], 0.1, 0.002);
    EXPECT_NEAR(bottom[2], 0, 0.001);
    trial.advance(5);
    EXPECT_LT((trial.mean_at(0) - bottom).norm(), 1e-4);
  }
}

TEST(Bounds, LiftWhatStartsBehindThem) {
  for (const std::string method :
       {"verlet", "backward_euler", "backward_euler_linear", "tr_bdf2", "generalized_alpha",
        "energy_momentum", "backward_euler/lbfgs", "xpbd:20", "vbd:20"}) {
    SCOPED_TRACE(method);
    BoundsTrial trial(method, 1e6, slope(0, 0.5), 1, method == "verlet" ? 2e-4 : frame);
    trial.move({0, 0, -0.01});
    const double start = measure(trial.system, trial.state).total();
    double fastest = 0, highest = start;
    for (int step = 1; step <= 60; ++step) {
      trial.advance(step * frame);
      const Measures now = measure(trial.system, trial.state);
      fastest = std::max(fastest, now.max_speed);
      highest = std::max(highest, now.total());
    }
    EXPECT_GT(trial.deepest(), -1e-12);
    EXPECT_LT(fastest, 0.5);  // it is lifted at .1 m/s
    EXPECT_LT(highest - start, 1.5 * trial.body.total_mass() * g * 0.01);
  }
}

TEST(Bounds, HaveNoPreferredDirection) {
  const Eigen::Matrix3d turn =
      Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), Vec3(1, 2, 3)).toRotationMatrix();
  for (const std::string method : {"backward_euler", "backward_euler/lbfgs", "vbd:20", "xpbd:20"}) {
    const Environment level = slope(30, 0.3);
    Environment turned = level;
    turned.gravity = turn * level.gravity;
    turned.planes[0].normal = turn * level.planes[0].normal;
    BoundsTrial one(method, 1e6, level), other(method, 1e6, turned);
    for (const std::ptrdiff_t site : other.body.sites())
      other.state.x.set(site, turn * other.state.x.at(site));
    one.advance(0.5);
    other.advance(0.5);
    double apart = 0;
    for (const std::ptrdiff_t site : one.body.sites())
      apart = std::max(apart, (turn * one.state.x.at(site) - other.state.x.at(site)).norm());
    EXPECT_LT(apart, 1e-9) << method;
  }
}

// What rounding leaves along a normal that is no axis must not look like something to solve.
TEST(Bounds, OfAnyDirectionTakeEveryLinearSolver) {
  const double angle = 20 * std::numbers::pi / 180;
  Environment inclined = slope(0, 0.5);
  inclined.planes[0].normal = {-std::sin(angle), 0, std::cos(angle)};
  for (const LinearSolverInfo& solver : linear_solvers()) {
    SCOPED_TRACE(solver.name);
    BoundsTrial trial("backward_euler", 1e6, inclined, 1, frame, solver.name);
    trial.move({0.2, 0, 0});
    trial.move({0, 0, std::max(0.0, -trial.deepest() / std::cos(angle)) + 0.01});
    trial.advance(0.5);
    EXPECT_GT(trial.deepest(), -1e-12);
    EXPECT_LT(trial.velocity().norm(), 1e-4);
  }
}

// On planes so rough that nothing slides the first guess must not be that everything does.
TEST(Bounds, HoldOnPlanesOfAnyRoughness) {
  for (const std::string method :
       {"backward_euler", "backward_euler_linear", "tr_bdf2", "backward_euler/lbfgs", "vbd:20", "xpbd:20"})
    for (const double friction : {5.0, 1000.0}) {
      SCOPED_TRACE(method);
      BoundsTrial trial(method, 1e6, slope(20, friction));
      const Vec3 bottom = trial.mean_at(0);
      trial.advance(0.5);
      EXPECT_GT(trial.deepest(), -1e-12);
      // A few passes do not solve a step, and what is left makes it creep.
      EXPECT_LT((trial.mean_at(0) - bottom).norm(), find_integrator(method).springs_only ? 2e-3 : 1e-4);
    }
}

// Blocks that tumble onto the floor, some corners sticking and some sliding. Where Newton's method does not
// settle which, it goes on with friction that is known before an iteration.
TEST(Bounds, TakeBlocksThatTumble) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto any = [&](double size) {
    return Vec3(size * unit(random), size * unit(random), size * unit(random));
  };
  for (int drop = 0; drop < 12; ++drop) {
    const Vec3 speed = any(2), spin = any(8);
    for (const std::string method : {"backward_euler", "generalized_alpha", "tr_bdf2"}) {
      SCOPED_TRACE(method + ", drop " + std::to_string(drop));
      BoundsTrial trial(method, 1e6, slope(0, drop % 2 == 0 ? 0.4 : 0.8));
      trial.move({0, 0, 0.3});
      for (const std::ptrdiff_t site : trial.body.sites())
        trial.state.v.set(site, speed + spin.cross(trial.state.x.at(site) - Vec3(0.1, 0.1, 0.4)));
      trial.advance(1);
      EXPECT_GT(trial.deepest(), -1e-12);
    }
  }
}

TEST(Bounds, AreAtMostSixtyFour) {
  Environment room = slope(0, 0.5);
  room.planes.assign(40, {.point = {0, 0, -9}, .friction = 0.5});
  room.planes[33] = {.friction = 0.5};
  BoundsTrial trial("backward_euler", 1e6, room);
  trial.advance(0.2);
  EXPECT_GT(trial.deepest(), -1e-12);
  EXPECT_GT(given(trial, 33)[2], 0.9 * trial.body.total_mass() * g * 0.2);
  room.planes.resize(65, {.point = {0, 0, -9}});
  BoundsTrial refused("backward_euler", 1e6, room);
  EXPECT_THROW(static_cast<void>(refused.method->advance(refused.system, refused.state, 0.1, refused.work)),
               InputError);
}

// Particles on rails leave an inclined plane along these.
TEST(Bounds, TakeParticlesHeldAlongAnAxis) {
  const double angle = 20 * std::numbers::pi / 180;
  Environment environment = slope(0, 0.5);
  environment.planes[0].normal = {-std::sin(angle), 0, std::cos(angle)};
  environment.holds = {{.box = {Vec3(0, 0, 0), Vec3(1, 1, 1)}, .axes = {true, false, false}}};
  for (const std::string method : {"verlet", "backward_euler", "vbd:5"}) {
    SCOPED_TRACE(method);
    BoundsTrial trial(method, 1e5, environment, 1, method == "verlet" ? 2e-4 : frame);
    trial.move({0, 0, 0.2});
    trial.advance(1);
    EXPECT_GT(trial.deepest(), -1e-9);
    EXPECT_LT(trial.mean_at(0)[2], 0.1);  // it has come down
  }
}

TEST(Bounds, AreTheSameBitsForAnyThreads) {
  for (const std::string method :
       {"backward_euler", "backward_euler/lbfgs", "vbd:5", "xpbd:5", "shape_matching"}) {
    const double dt = method == "shape_matching" ? 1e-3 : frame;
    BoundsTrial one(method, 1e6, slope(10, 0.4), 1, dt);
    one.advance(0.3);
    for (const int threads : {2, 3, 8}) {
      BoundsTrial other(method, 1e6, slope(10, 0.4), threads, dt);
      other.advance(0.3);
      EXPECT_EQ(std::memcmp(one.state.x.axis(0), other.state.x.axis(0),
                            std::size_t(one.state.x.size()) * sizeof(double)),
                0)
          << method << " " << threads;
    }
  }
}

TEST(Vbd, FallsFreelyAtAnyStiffness) {
  for (const double young : {1e4, 1e7})
    for (const char* method : {"vbd", "vbd:5", "vbd:20"}) {
      BoundsTrial trial(method, young, {.gravity = {0, 0, -g}});
      trial.advance(1);
      EXPECT_NEAR(trial.velocity()[2] / -g, 1, 1e-6) << method << " " << young;
    }
}

}  // namespace
}  // namespace mss

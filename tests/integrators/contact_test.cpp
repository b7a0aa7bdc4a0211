// Laws of contact under every method: heights of bounces, sticking and sliding on slopes, stopping distances,
// rest; and what methods must do: reset, take whole steps, find the first contact.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstring>
#include <limits>
#include <numbers>

#include "core/measures/measures.hpp"
#include "core/system/system_wrapper.hpp"
#include "integrators/integrator.hpp"
#include "reference/closed_forms.hpp"
#include "tests/centre_of_mass.hpp"

namespace mss {
namespace {

using testing::g;
const Environment down{.gravity = Vec3(0, 0, -g)};

Environment with(Environment environment, const Plane& plane) {
  environment.planes.push_back(plane);
  return environment;
}

/// A body in an environment with a method and its state.
struct ContactTrial {
  Body body;
  SpringSystem<double> system;
  State<double> state;
  std::unique_ptr<Integrator<double>> method;
  Work work;

  ContactTrial(const std::string& name, double dt, const BodyConfig& config, const Environment& environment,
               int threads = 1)
      : body(config),
        system(body, environment, {.threads = threads}),
        state(system.rest_state()),
        method(find_integrator(name).make<double>({.dt = dt})) {}

  void advance(double t) { ASSERT_EQ(method->advance(system, state, t, work), Status::ok); }
  void push(const Vec3& velocity) {
    for (const std::ptrdiff_t site : body.sites()) state.v.set(site, velocity);
  }
  Vec3 centre() const { return testing::centre_of_mass(body, state); }
};

class FixedStepContact : public ::testing::TestWithParam<std::string> {};

TEST_P(FixedStepContact, BouncesAsHighAsRestitutionSays) {
  constexpr double restitution = 0.7, dt = 1e-3;
  const Plane floor{.point = Vec3(0, 0, -1), .restitution = restitution};
  ContactTrial run(GetParam(), dt, free_particles(), with(down, floor));
  double before = 1, highest = 0;
  bool rising = false;
  int bounces = 0;
  for (long step = 1; bounces < 5 && step < 5000; ++step) {
    run.advance(double(step) * dt);
    const double height = run.state.x.at(0)[2] + 1;
    highest = rising ? std::max(highest, height) : height;
    if (rising && height < before) {
      const double expected = reference::bounce_height(1, restitution, ++bounces);
      EXPECT_NEAR(highest / expected, 1, 1e-3) << bounces;
    }
    rising = height > before;
    before = height;
  }
  EXPECT_EQ(bounces, 5);
}

// The normal is inclined, so that rounding decides whether a particle is on the plane.
TEST_P(FixedStepContact, SticksToASlopeOrSlidesDownIt) {
  const double angle = std::atan(0.5);
  for (const double friction : {0.51, 0.49}) {
    const Plane slope{.normal = Vec3(std::sin(angle), 0, std::cos(angle)), .friction = friction};
    ContactTrial run(GetParam(), 1e-3, free_particles(), with(down, slope));
    for (const std::ptrdiff_t site : run.body.sites()) {
      const Vec3 x = run.state.x.at(site);
      run.state.x.set(site, x - slope.gap(x) * slope.normal);
    }
    const State<double> start = run.state;
    run.advance(1);
    const double expected = reference::slope_distance(g, angle, friction, 1);
    for (const std::ptrdiff_t site : run.body.sites()) {
      const Vec3 moved = run.state.x.at(site) - start.x.at(site);
      EXPECT_NEAR(moved.norm(), expected, friction > 0.5 ? 1e-12 : 0.01 * expected);
      EXPECT_NEAR(slope.gap(run.state.x.at(site)), 0, 1e-15);
    }
  }
}

TEST_P(FixedStepContact, StopsWhereFrictionSays) {
  for (const double degrees : {0, 30, 45}) {
    const double angle = degrees * std::numbers::pi / 180;
    ContactTrial run(GetParam(), 1e-3, free_particles(), with(down, {.friction = 0.4}));
    for (const std::ptrdiff_t site : run.body.sites()) {
      Vec3 x = run.state.x.at(site);
      x[2] = 0;
      run.state.x.set(site, x);
    }
    run.push(2 * Vec3(std::cos(angle), std::sin(angle), 0));
    const Vec3 start = run.state.x.at(0);
    run.advance(1);
    const Vec3 moved = run.state.x.at(0) - start;
    EXPECT_NEAR(moved.norm(), reference::stopping_distance(g, 2, 0.4),
                0.01 * reference::stopping_distance(g, 2, 0.4));
    EXPECT_NEAR(std::atan2(moved[1], moved[0]), angle, 1e-12);
    EXPECT_EQ(run.state.v.at(0), Vec3::Zero());
  }
}

TEST_P(FixedStepContact, DoesNotDependOnHowOftenItIsSampled) {
  const Plane floor{.point = Vec3(0, 0, -0.002)};
  ContactTrial once(GetParam(), 2e-4, rubber_block(), with(down, floor));
  ContactTrial often(GetParam(), 2e-4, rubber_block(), with(down, floor));
  once.advance(0.04);
  for (int look = 1; look <= 10; ++look) often.advance(look * 0.004);
  EXPECT_EQ((once.state.x.array() - often.state.x.array()).abs().maxCoeff(), 0);
  EXPECT_EQ(once.work.steps, 200);
  EXPECT_LT(once.state.x.axis(2)[0], -0.0015);  // it has landed
}

auto methods(Stepping stepping) {
  std::vector<std::string> names;
  for (const IntegratorInfo& info : integrators())
    if (info.stepping == stepping && info.has_modulus) names.push_back(info.name);
  return ::testing::ValuesIn(names);
}
const auto method_name = [](const auto& p) { return p.param; };
INSTANTIATE_TEST_SUITE_P(Registry, FixedStepContact, methods(Stepping::fixed), method_name);

/// A block at rest on inclined ground: on level ground, with inclined gravity.
std::unique_ptr<ContactTrial> block_on_slope(const std::string& method, double angle, double friction) {
  const Environment leaning{.gravity = g * Vec3(std::sin(angle), 0, -std::cos(angle))};
  ContactTrial glued(method, 2e-4, rubber_block(), with(leaning, {.restitution = 0, .friction = 10}));
  glued.advance(0.6);
  auto run =
      std::make_unique<ContactTrial>(method, 2e-4, rubber_block(), with(leaning, {.friction = friction}));
  run->state = glued.state;
  run->state.t = 0;
  return run;
}

class BlockContact : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Some, BlockContact, ::testing::Values("verlet", "velocity_verlet", "rk4"),
                         method_name);

TEST_P(BlockContact, StopsWhereFrictionSays) {
  for (const double degrees : {0, 30, 45}) {
    const double angle = degrees * std::numbers::pi / 180;
    ContactTrial run(GetParam(), 5e-4, rubber_block(), with(down, {.friction = 0.4}));
    run.push(2 * Vec3(std::cos(angle), std::sin(angle), 0));
    const Vec3 start = run.centre();
    run.advance(0.8);
    Vec3 moved = run.centre() - start;
    moved[2] = 0;
    EXPECT_NEAR(moved.norm(), reference::stopping_distance(g, 2, 0.4),
                0.01 * reference::stopping_distance(g, 2, 0.4));
    EXPECT_NEAR(std::atan2(moved[1], moved[0]), angle, 1e-3);
  }
}

TEST(Block, SticksToASlopeOrSlidesDownIt) {
  const double angle = std::atan(0.5);
  const auto sticking = block_on_slope("verlet", angle, 0.51);
  Vec3 start = sticking->centre();
  sticking->advance(1);
  EXPECT_LT((sticking->centre() - start).norm(), 0.01 * sticking->body.config().cell_size);
  EXPECT_LT(measure(sticking->system, sticking->state).max_speed, 1e-4);
  // It begins with a jerk, as the strain of sticking is released; then it slides by the law.
  const auto sliding = block_on_slope("verlet", angle, 0.49);
  sliding->advance(0.4);
  start = sliding->centre();
  const Vec3 speed = measure(sliding->system, sliding->state).momentum / sliding->body.total_mass();
  sliding->advance(1.4);
  const double expected = speed[0] + reference::slope_distance(g, angle, 0.49, 1);
  EXPECT_NEAR((sliding->centre() - start)[0], expected, 0.01 * reference::slope_distance(g, angle, 0.49, 1));
}

/// The thesis's cube, spinning, dropped on ground.
std::unique_ptr<ContactTrial> spinning_cube(const std::string& method, double dt, int threads = 1) {
  auto run = std::make_unique<ContactTrial>(method, dt, thesis_cube(), with(down, {}), threads);
  const Vec3 centre = run->centre();
  for (const std::ptrdiff_t site : run->body.sites())
    run->state.v.set(site, Vec3(1, 0, 0) + Vec3(3, 2, 1).cross(run->state.x.at(site) - centre));
  return run;
}

class CubeContact : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Some, CubeContact, ::testing::Values("verlet", "velocity_verlet"), method_name);

TEST_P(CubeContact, ComesToRestAndDoesNotSink) {
  const auto cube = spinning_cube(GetParam(), GetParam() == "verlet" ? 1e-3 : 5e-4);
  ContactTrial& run = *cube;
  double peak = 0, lowest = 0, before = std::numeric_limits<double>::infinity();
  int in_flight = 0;
  bool flew = false;
  for (int look = 1; look <= 800; ++look) {
    run.advance(look * 0.01);
    const Measures m = measure(run.system, run.state);
    double low = 1;
    for (const std::ptrdiff_t site : run.body.sites()) low = std::min(low, run.state.x.at(site)[2]);
    peak = std::max(peak, m.kinetic);
    lowest = std::min(lowest, low);
    const bool flies = low > 0.05;  // too high to have touched since the last sample
    if (flies && flew) {
      ++in_flight;
      EXPECT_LT(m.total(), before + 1e-3 * peak) << m.t;
    }
    flew = flies;
    before = m.total();
  }
  EXPECT_GT(in_flight, 20);
  EXPECT_GT(lowest, -1e-3 * run.body.config().cell_size);
  EXPECT_LT(measure(run.system, run.state).kinetic, 1e-10 * peak);
}

TEST(Cube, BouncesTheSameForAnyThreads) {
  const auto one = spinning_cube("verlet", 1e-3, 1);
  one->advance(1);
  for (const int threads : {2, 3}) {
    const auto other = spinning_cube("verlet", 1e-3, threads);
    other->advance(1);
    EXPECT_EQ((one->state.x.array() - other->state.x.array()).abs().maxCoeff(), 0);
    EXPECT_EQ((one->state.v.array() - other->state.v.array()).abs().maxCoeff(), 0);
  }
}

TEST(Corner, HoldsABlock) {
  Environment corner = down;
  for (const Vec3& normal : {Vec3(1, 0, 1), Vec3(-1, 0, 1), Vec3(0, 1, 0)})
    corner.planes.push_back({.normal = normal.normalized(), .friction = 0.2});
  BodyConfig config = rubber_block();
  config.origin = Vec3(-0.15, 0.05, 0.2);
  ContactTrial run("verlet", 5e-4, config, corner);
  run.push(Vec3(0, -1, 0));
  run.advance(4);
  EXPECT_LT(measure(run.system, run.state).max_speed, 1e-6);
  double nearest[3] = {1, 1, 1};
  for (const std::ptrdiff_t site : run.body.sites())
    for (std::size_t p = 0; p < 3; ++p)
      nearest[p] = std::min(nearest[p], corner.planes[p].gap(run.state.x.at(site)));
  for (const double gap : nearest) EXPECT_GT(gap, -1e-6 * config.cell_size);
  EXPECT_LT(std::max(nearest[0], nearest[1]), 1e-9);  // it lies in the groove
}

class PenaltyContact : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Some, PenaltyContact,
                         ::testing::Values("velocity_verlet", "implicit_midpoint", "cvode_bdf", "arkode_erk"),
                         method_name);

TEST_P(PenaltyContact, StopsWhereFrictionSays) {
  const Plane floor{.contact = ContactLaw::penalty, .friction = 0.4};
  const bool adaptive = find_integrator(GetParam()).stepping == Stepping::adaptive;
  const bool limited = find_integrator(GetParam()).limit != nullptr;
  ContactTrial run(GetParam(), adaptive ? 0 : limited ? 1e-5 : 5e-4, rubber_block(), with(down, floor));
  run.push(Vec3(0.5, 0, 0));
  const Vec3 start = run.centre();
  run.advance(0.3);
  const double expected = reference::stopping_distance(g, 0.5, 0.4);
  EXPECT_NEAR((run.centre() - start)[0], expected, 0.05 * expected);
}

// There is no friction without velocity, so the sides are held where they must not drift.
TEST(StaticContact, CarriesAWeight) {
  const Plane floor{.contact = ContactLaw::penalty};
  Environment environment = with(down, floor);
  environment.holds = {{.box = {Vec3(0, 0, 0), Vec3(0, 1, 1)}, .axes = {true, false, false}},
                       {.box = {Vec3(0, 0, 0), Vec3(1, 0, 1)}, .axes = {false, true, false}}};
  ContactTrial run("static", 0, rubber_block(), environment);
  run.advance(1);
  Field<double> force(run.system.size());
  run.system.force(1, run.state.x, run.state.v, force);
  run.system.clear_prescribed(force);
  EXPECT_LT(force.array().abs().maxCoeff(), 1e-8 * run.body.total_mass() * g);
  double weight = 0, deepest = 0;
  SpringSystem<double> floorless(run.body, down);
  Field<double> without(run.system.size());
  floorless.force(1, run.state.x, run.state.v, without);
  for (const std::ptrdiff_t site : run.body.sites()) {
    weight -= without.at(site)[2];
    deepest = std::min(deepest, run.state.x.at(site)[2]);
  }
  EXPECT_NEAR(weight, run.body.total_mass() * g, 1e-8 * weight);
  EXPECT_LT(deepest, 0);
  EXPECT_GT(deepest, -0.01 * run.body.config().cell_size);
}

/// Records the times of evaluations of accelerations; with or without the events of the system it wraps.
class Recorder final : public SystemWrapper<double> {
 public:
  Recorder(SpringSystem<double>& system, bool with_events)
      : SystemWrapper<double>(system), with_events_(with_events) {}
  std::vector<double> times;

  void force(double t, const Field<double>& x, const Field<double>& v, Field<double>& f) override {
    other().force(t, x, v, f);
  }
  void acceleration(double t, const Field<double>& x, const Field<double>& v, Field<double>& a) override {
    times.push_back(t);
    other().acceleration(t, x, v, a);
  }
  StepEvents<double>* events() override { return with_events_ ? other().events() : nullptr; }

 private:
  bool with_events_;
};

class CvodeContact : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(All, CvodeContact,
                         ::testing::Values("cvode_adams", "cvode_bdf", "cvode_bdf_klu", "cvode_bdf_gmres"),
                         method_name);

/// How near to the first touch of a falling particle a method evaluates an acceleration [s].
double nearest_to_touch(const std::string& method, bool with_events) {
  const Plane floor{.point = Vec3(0, 0, -0.5), .contact = ContactLaw::penalty};
  ContactTrial run(method, 0, free_particles(), with(down, floor));
  Recorder recorder(run.system, with_events);
  EXPECT_EQ(run.method->advance(recorder, run.state, 0.4, run.work), Status::ok);
  EXPECT_EQ(run.state.t, 0.4);
  double nearest = 1;
  for (const double t : recorder.times) nearest = std::min(nearest, std::abs(t - std::sqrt(2 * 0.5 / g)));
  return nearest;
}

TEST_P(CvodeContact, RestartsAtTheFirstContact) {
  EXPECT_LT(nearest_to_touch(GetParam(), true), 1e-6);  // the tolerance's own error
  EXPECT_GT(nearest_to_touch(GetParam(), false), 3e-6);
}

}  // namespace
}  // namespace mss

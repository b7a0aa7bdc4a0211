// What holds and planes exert on a body: weights, changes of momentum, by every method that takes steps.
#include "core/measures/reactions.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/measures/measures.hpp"
#include "core/mesh/shapes.hpp"
#include "core/refinement/refined_system.hpp"
#include "core/system/plane_impulses.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "integrators/integrator.hpp"
#include "tests/centre_of_mass.hpp"
#include "tests/mesh_body.hpp"

namespace mss {
namespace {

using testing::g;

BodyConfig block() {
  BodyConfig config{.voxels = VoxelGrid::box(4, 4, 4), .cell_size = 0.05};
  config.density = 1000;
  config.fill({.young = 1e5, .poisson = 0.3}, 0.5);
  config.damping.zeta = 0.1;
  return config;
}

/// On level ground, with gravity inclined.
Environment slope(double degrees, const Plane& plane) {
  const double angle = degrees * std::numbers::pi / 180;
  return {.gravity = g * Vec3(std::sin(angle), 0, -std::cos(angle)), .planes = {plane}};
}

/// Frames of implicit methods and passes, or as long as planes that act after steps allow; safe steps of
/// others.
template <class Real>
double step_of(const IntegratorInfo& method, SolidSystem<Real>& system) {
  constexpr double frame = 1.0 / 60;
  if (method.limit) return safe_share * stable_step(method, system.spectral_bound());
  const bool after = system.events()->collides() && !system.bounds();
  return after ? std::min(frame, system.events()->resolved_step()) : frame;
}

template <class Real = double>
struct ReactionTrial {
  Body body;
  Work work;
  SpringSystem<Real> system;
  ReactionGauge<Real> gauge;
  State<Real> state;
  std::unique_ptr<Integrator<Real>> method;

  ReactionTrial(const std::string& name, const Environment& environment, const BodyConfig& config = block(),
                const Execution& execution = {.threads = 1})
      : body(config),
        system(body, environment, execution),
        gauge(system, environment),
        state(system.rest_state()),
        method(find_integrator(name).make<Real>({.dt = step_of(find_integrator(name), system)})) {}

  void advance(double t) { ASSERT_EQ(method->advance(system, state, t, work), Status::ok) << "t = " << t; }
  /// Means over a while.
  Reactions mean_until(double t) {
    gauge.begin(state.t);
    advance(t);
    return gauge.read(system, state);
  }
  void move(const Vec3& by) {
    for (const std::ptrdiff_t site : body.sites()) state.x.set(site, state.x.at(site) + by);
  }
  void push(const Vec3& velocity) {
    for (const std::ptrdiff_t site : body.sites()) state.v.set(site, velocity);
  }
  Vec3 momentum() const { return measure(system, state).momentum; }
  Vec3 weight() const { return body.total_mass() * system.environment().gravity; }
};

/// Of all, from what the planes add to the forces.
Vec3 penalty_force(ReactionTrial<double>& trial) {
  Environment without = trial.system.environment();
  without.planes.clear();
  SpringSystem<double> alone(trial.body, without, Execution{.threads = 1});
  Field<double> with_plane(trial.system.size()), others = with_plane;
  trial.system.force(trial.state.t, trial.state.x, trial.state.v, with_plane);
  alone.force(trial.state.t, trial.state.x, trial.state.v, others);
  Vec3 sum = Vec3::Zero();
  for (const std::ptrdiff_t site : trial.body.sites()) sum += with_plane.at(site) - others.at(site);
  return sum;
}

Vec3 sum_of(const std::vector<Vec3>& forces) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& force : forces) sum += force;
  return sum;
}

/// All of fixed step but those without a safe step and one without springs.
std::vector<std::string> methods() {
  std::vector<std::string> names{"backward_euler/lbfgs"};
  for (const IntegratorInfo& info : integrators())
    if (info.stepping == Stepping::fixed && info.has_modulus && !(info.limit && info.limit(1, 0) == 0))
      names.push_back(info.springs_only ? info.name + ":20" : info.name);
  return names;
}
const auto name_of = [](const auto& info) {
  std::string name = info.param;
  for (char& letter : name)
    if (letter == '/' || letter == ':') letter = '_';
  return name;
};

/// By how much mean forces of planes miss the change of momentum until t, over the weight.
template <class Real>
double missing(ReactionTrial<Real>& trial, double t) {
  const Vec3 before = trial.momentum();
  const double begin = trial.state.t;
  const Vec3 force = sum_of(trial.mean_until(t).planes),
             mean = (trial.momentum() - before) / (trial.state.t - begin);
  return (force + trial.weight() - mean).norm() / trial.weight().norm();
}

/// Passes of vbd do not keep momentum until they converge, and generalized_alpha has it lag behind forces.
double most_missing(const std::string& method) {
  return method == "vbd:20" ? 0.02 : method == "generalized_alpha" ? 1e-3 : 1e-9;
}

class Reaction : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Methods, Reaction, ::testing::ValuesIn(methods()), name_of);

/// It has come to rest by backward Euler.
TEST_P(Reaction, CarriesABlockAtRest) {
  BodyConfig config = block();
  config.damping = {.law = Damping::Law::ratio, .zeta = 1};
  for (const double degrees : {0, 19}) {
    const Environment environment = slope(degrees, {.friction = 0.5});
    ReactionTrial settling("backward_euler", environment, config);
    settling.advance(3);
    ReactionTrial trial(GetParam(), environment, config);
    trial.state.x = settling.state.x;
    trial.advance(0.5);
    const Vec3 force = trial.mean_until(0.6).planes[0];
    const double most = GetParam() == "xpbd:20" || GetParam() == "vbd:20" ? 1e-3 : 1e-9;
    EXPECT_LT((force + trial.weight()).norm(), most * trial.weight().norm()) << degrees;
  }
}

TEST_P(Reaction, ChangesMomentum) {
  ReactionTrial trial(GetParam(), slope(20, {.restitution = 0.4, .friction = 0.3}));
  trial.move({0, 0, 0.05});
  trial.push({0.5, 0.2, 0});
  EXPECT_LT(missing(trial, 0.7), most_missing(GetParam()));
  double lowest = 1;
  for (const std::ptrdiff_t site : trial.body.sites()) lowest = std::min(lowest, trial.state.x.at(site)[2]);
  EXPECT_LT(lowest, 0.04);  // it has landed
}

/// TR-BDF2 finds no set of contacts here, and says so.
TEST_P(Reaction, OfAGrooveChangesMomentum) {
  if (GetParam() == "tr_bdf2") return;
  Environment groove{.gravity = {-g / 2, 0, -g}};
  for (const Vec3& normal : {Vec3(1, 0, 0), Vec3(0, 0, 1)})
    groove.planes.push_back({.normal = normal, .friction = 0.2});
  ReactionTrial trial(GetParam(), groove);
  trial.move({0.01, 0, 0.01});
  EXPECT_LT(missing(trial, 1), most_missing(GetParam()));
  const std::vector<Vec3> planes = trial.mean_until(1.5).planes;
  EXPECT_GT(planes[0][0], 0.2 * trial.weight().norm());
  EXPECT_GT(planes[1][2], 0.6 * trial.weight().norm());
}

TEST_P(Reaction, IsZeroInFreeFall) {
  Environment far{.gravity = {0, 0, -g}, .planes = {{.point = {0, 0, -10}}}};
  ReactionTrial trial(GetParam(), far);
  const Vec3 centre = testing::centre_of_mass(trial.body, trial.state);
  for (const std::ptrdiff_t site : trial.body.sites())
    trial.state.v.set(site, Vec3(3, 2, 1).cross(trial.state.x.at(site) - centre));
  EXPECT_EQ(trial.mean_until(0.1).planes[0], Vec3::Zero());
}

TEST_P(Reaction, HasTheSameBitsForAnyThreads) {
  const auto force = [&](int threads) {
    ReactionTrial trial(GetParam(), slope(10, {.friction = 0.1}), block(), {.threads = threads});
    trial.move({0, 0, 1e-4});
    return trial.mean_until(0.1).planes[0];
  };
  const Vec3 alone = force(1);
  EXPECT_GT(alone[2], 0);
  for (const int threads : {2, 3}) EXPECT_EQ(force(threads), alone) << threads;
}

double missing_of_landing(const std::string& method, double friction) {
  ReactionTrial trial(method, slope(0, {.friction = friction}));
  trial.move({0, 0, 0.05});
  return missing(trial, 0.3);
}

/// Passes that converge keep momentum. With friction those of one step, of a block about to bounce, go on
/// between sticking and sliding by a thousandth of the weight, however many they are.
TEST(ReactionOfVbd, ConvergesWithPasses) {
  const double few = missing_of_landing("vbd:20", 0), more = missing_of_landing("vbd:100", 0);
  EXPECT_LT(few, 0.02);
  EXPECT_LT(more, 1e-6 * few);
  EXPECT_LT(missing_of_landing("vbd:500", 0), 1e-4 * more);
  for (const char* method : {"vbd:100", "vbd:500"})
    EXPECT_LT(missing_of_landing(method, 0.3), 1e-3) << method;
}

/// Impulses at the end of steps, where a method keeps no bounds or planes are no bounds.
TEST(Reactions, OfTheThesissLawChangesMomentum) {
  Environment mixed{.gravity = {0, 0, -g}};
  mixed.planes = {{.normal = Vec3(1, 0, 1).normalized(), .contact = ContactLaw::thesis, .restitution = 0.4},
                  {.normal = Vec3(-1, 0, 1).normalized(), .friction = 0.3}};
  for (const std::string method : {"verlet", "rk4", "velocity_verlet", "backward_euler", "tr_bdf2"}) {
    SCOPED_TRACE(method);
    ReactionTrial trial(method, mixed);
    trial.move({-0.1, 0, 0.15});
    EXPECT_LT(missing(trial, 0.25), 1e-9);
    EXPECT_GT(trial.gauge.read(trial.system, trial.state).planes[0].norm(), 0.1);
    EXPECT_GT(trial.gauge.read(trial.system, trial.state).planes[1].norm(), 0.1);
  }
}

TEST(Reactions, InSinglePrecisionChangesMomentum) {
  ReactionTrial<float> trial("verlet", slope(20, {.friction = 0.3}));
  trial.move({0, 0, 0.05});
  EXPECT_LT(missing(trial, 0.5), 1e-4);
}

TEST(Reactions, OnASurfaceChangesMomentum) {
  const TriangleMesh ball = icosphere(0.25, 6);
  BodyConfig config = testing::mesh_config(ball, 0.1, 2e5);
  for (const std::string method : {"verlet", "backward_euler"})
    for (const ContactLaw law : {ContactLaw::impulse, ContactLaw::penalty}) {
      SCOPED_TRACE(method);
      Environment environment = slope(20, {.point = {0, 0, -0.3}, .contact = law, .friction = 0.3});
      ReactionTrial trial(method, testing::on_surface(environment, ball), config);
      if (law == ContactLaw::impulse) {
        EXPECT_LT(missing(trial, 0.4), 1e-9);
        EXPECT_GT(trial.gauge.read(trial.system, trial.state).planes[0][2], 0);
      } else {
        trial.advance(0.12);
        EXPECT_LT((trial.gauge.read(trial.system, trial.state).planes[0] - penalty_force(trial)).norm(),
                  1e-9);
        EXPECT_GT(penalty_force(trial)[2], 0);
      }
    }
}

TEST(Reactions, OfARefinedBodyChangesMomentum) {
  const BodyConfig config = block();
  const RefinedBody body(config, refinement_of(config, {{{{0, 0, 0}, {0.1, 0.1, 0.1}}, 1}}));
  const Environment environment = slope(20, {.restitution = 0.4, .friction = 0.3});
  for (const bool local : {false, true}) {
    RefinedSystem<double> system(body, environment);
    const IntegratorInfo& method = find_integrator("velocity_verlet");
    const SpectralBound bound = local ? system.local_bound() : system.spectral_bound();
    const double dt = safe_share * stable_step(method, bound);
    const std::unique_ptr<System<double>> in_local_steps = local ? system.with_local_steps(dt) : nullptr;
    System<double>& driven = local ? *in_local_steps : system;
    State<double> state = system.rest_state();
    Work work;
    ReactionGauge<double> gauge(system, environment);
    ASSERT_EQ(method.make<double>({.dt = dt})->advance(driven, state, 0.3, work), Status::ok);
    const Vec3 weight = system.total_mass() * environment.gravity,
               force = gauge.read(driven, state).planes[0], mean = measure(system, state).momentum / state.t;
    EXPECT_LT((force + weight - mean).norm(), 1e-9 * weight.norm()) << local;
    EXPECT_GT(force[2], 0.5 * -weight[2]);
  }
}

TEST(Reactions, IsTheWeightWhileABodySleeps) {
  BodyConfig config = block();
  config.damping = {.law = Damping::Law::ratio, .zeta = 1};
  for (const std::string method : {"verlet", "velocity_verlet", "semi_implicit_euler"}) {
    ReactionTrial trial(method, slope(0, {.friction = 0.5}), config,
                        {.threads = 1, .sleep = {.bound = 1e-3, .after = 0.2}});
    trial.advance(4);
    ASSERT_TRUE(trial.system.all_asleep()) << method;
    const Vec3 force = trial.mean_until(5).planes[0];
    EXPECT_LT((force + trial.weight()).norm(), 0.02 * trial.weight().norm()) << method;
  }
}

TEST(Reactions, IsTheWeightOfAPenaltyPlane) {
  ReactionTrial trial("backward_euler", slope(0, {.contact = ContactLaw::penalty}));
  trial.advance(8);
  EXPECT_LT((trial.gauge.read(trial.system, trial.state).planes[0] + trial.weight()).norm(),
            1e-6 * trial.weight().norm());
}

TEST(Reactions, OfAHoldIsTheWeightAtRest) {
  Environment wall{.gravity = {0, 0, -g}, .holds = {{.box = {{0, 0, 0}, {0, 1, 1}}}}};
  ReactionTrial trial("backward_euler", wall);
  trial.advance(10);
  EXPECT_LT((trial.gauge.read(trial.system, trial.state).holds[0] + trial.weight()).norm(),
            1e-9 * trial.weight().norm());
}

/// Two holds overlap, a load acts on a held particle, a penalty plane presses.
TEST(Reactions, OfAllAtRestCarryWeightAndLoads) {
  Environment environment{.gravity = {0, 0, -g}};
  environment.holds = {{.box = {{0, 0, 0}, {0.05, 1, 1}}, .axes = {true, true, false}},
                       {.box = {{0, 0, 0}, {0, 1, 1}}, .axes = {false, true, true}}};
  environment.loads = {{.box = {{0, 0, 0}, {0.2, 0.2, 0.2}}, .force = {1, 2, 3}},
                       {.box = {{0, 0, 0.2}, {0, 0.2, 0.2}}, .force = {-3, 1, 0}}};
  environment.planes = {{.point = {0, 0, 0.001}, .contact = ContactLaw::penalty}};
  BodyConfig config = block();
  const Body body(config);
  SpringSystem<double> system(body, environment);
  State<double> state = system.rest_state();
  Work work;
  ASSERT_EQ(find_integrator("static").make<double>({.dt = 0})->advance(system, state, 1, work), Status::ok);
  const Reactions reactions = ReactionGauge<double>(system, environment).read(system, state);
  ASSERT_EQ(reactions.holds.size(), 2U);
  const Vec3 outer = body.total_mass() * environment.gravity + Vec3(-2, 3, 3),
             sum = sum_of(reactions.holds) + sum_of(reactions.planes) + outer;
  EXPECT_LT(sum.norm(), 1e-7 * outer.norm());
  EXPECT_EQ(reactions.holds[0][2], 0);  // it holds x, and y where the other does not
  EXPECT_EQ(reactions.holds[1][0], 0);
  for (const auto& [hold, axis] : {std::pair{0, 0}, {0, 1}, {1, 1}, {1, 2}})
    EXPECT_GT(std::abs(reactions.holds[std::size_t(hold)][axis]), 1e-3) << hold << axis;
  EXPECT_GT(reactions.planes[0][2], 1);
}

/// A body that turns as a whole: m omega^2 r towards the axis.
TEST(Reactions, OfATurnKeepsABodyOnItsCircle) {
  Hold all{.box = {{0, 0, 0}, {1, 1, 1}}};
  all.turn = {.axis = {0, 0, 2}, .centre = {-1, 0.1, 0}, .rate = 3, .until = 0.5};
  ReactionTrial trial("backward_euler", {.holds = {all}});
  trial.advance(0.25);
  const Vec3 arm = testing::centre_of_mass(trial.body, trial.state) - Vec3(-1, 0.1, 0.1);
  EXPECT_LT((trial.gauge.read(trial.system, trial.state).holds[0] + trial.body.total_mass() * 9 * arm).norm(),
            1e-6 * 9 * trial.body.total_mass());
  trial.advance(0.75);
  EXPECT_LT(trial.gauge.read(trial.system, trial.state).holds[0].norm(), 1e-6 * trial.body.total_mass());
}

TEST(PlaneImpulses, OfWhatSticksAreForceTimesTime) {
  PlaneImpulses impulses(2, 4);
  impulses.hold(1, 3, {1, 2, 3});
  impulses.end_step(0.5);
  EXPECT_EQ(impulses.at(1, 3), Vec3(0.5, 1, 1.5));
  impulses.hold_for(0.25);
  impulses.end_step(0.5);  // for all of which it was told
  EXPECT_EQ(impulses.at(1, 3), Vec3(0.75, 1.5, 2.25));
  impulses.hold(0, 3, {0, 0, 8});
  impulses.end_step(0.5);
  impulses.let_go(3);
  impulses.end_step(0.5);
  EXPECT_EQ(impulses.at(1, 3), Vec3(0.75, 1.5, 2.25));
  EXPECT_EQ(impulses.at(0, 3), Vec3(0, 0, 4));
  EXPECT_EQ(impulses.at(0, 2), Vec3::Zero());
}

TEST(PlaneImpulses, AreSplitByNormalsAndFriction) {
  const std::vector<Plane> planes{{.normal = {1, 0, 0}, .friction = 0.5},
                                  {.normal = {0, 1, 0}, .friction = 9},
                                  {.normal = {0, 0, 1}, .friction = 0.25}};
  const std::vector<Vec3> two = split_by_plane(planes, {0, 2}, Vec3::Ones(), {2, 4, 12});
  EXPECT_LT((two[0] - Vec3(2, 1, 0)).norm(), 1e-14);  // 0.5 * 2 of 0.5 * 2 + 0.25 * 12
  EXPECT_LT((two[2] - Vec3(0, 3, 12)).norm(), 1e-14);
  EXPECT_EQ(two[1], Vec3::Zero());
  EXPECT_EQ(split_by_plane(planes, {1}, {1, 1, 0}, {2, 4, 12})[1], Vec3(2, 4, 0));
  const std::vector<Vec3> along = split_by_plane(planes, {0, 2}, Vec3::Ones(), {0, 4, 0});
  EXPECT_EQ(along[0] + along[2], Vec3(0, 4, 0));
}

}  // namespace
}  // namespace mss

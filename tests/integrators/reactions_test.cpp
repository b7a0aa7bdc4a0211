// What holds and planes exert on a body: weights, changes of momentum, by every method that takes steps.
#include "core/reactions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/local_steps.hpp"
#include "core/measures.hpp"
#include "core/refined_system.hpp"
#include "core/tethered_system.hpp"
#include "integrators/integrator.hpp"
#include "integrators/stable_step.hpp"
#include "tests/centre_of_mass.hpp"

namespace mss {
namespace {

constexpr double g = 9.81;

BodyConfig block(double young = 1e5) {
  BodyConfig config{.voxels = VoxelGrid::box(4, 4, 4), .cell_size = 0.05};
  config.density = 1000;
  config.fill({.young = young, .poisson = 0.3}, 0.5);
  config.damping.zeta = 0.1;
  return config;
}

/// On level ground, with gravity inclined.
Environment slope(double degrees, const Plane& plane) {
  const double angle = degrees * std::numbers::pi / 180;
  return {.gravity = g * Vec3(std::sin(angle), 0, -std::cos(angle)), .planes = {plane}};
}

/// Frames of implicit methods and passes, safe steps of others.
double step_of(const IntegratorInfo& method, const SpectralBound& bound) {
  return method.limit ? safe_share * stable_step(method, bound) : 1.0 / 60;
}

template <class Real = double>
struct Trial {
  Body body;
  SpringSystem<Real> system;
  State<Real> state;
  double dt;
  std::unique_ptr<Integrator<Real>> method;
  ReactionGauge<Real> gauge;
  Work work;

  Trial(const std::string& name, const Environment& environment, const BodyConfig& config = block(),
        const Execution& execution = {.threads = 1})
      : body(config),
        system(body, environment, execution),
        state(system.rest_state()),
        dt(step_of(find_integrator(name), system.spectral_bound())),
        method(find_integrator(name).make<Real>({.dt = dt})),
        gauge(system, environment) {}

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

Vec3 sum_of(const std::vector<Vec3>& forces) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& force : forces) sum += force;
  return sum;
}

const std::vector<std::string> explicit_methods{"verlet", "velocity_verlet",     "damped_verlet", "rk4",
                                                "pefrl",  "semi_implicit_euler", "explicit_euler"};
const std::vector<std::string> implicit_methods{
    "backward_euler",    "backward_euler_linear", "implicit_midpoint",    "tr_bdf2",
    "generalized_alpha", "energy_momentum",       "backward_euler/lbfgs", "backward_euler/projective"};
const std::vector<std::string> passes{"xpbd:20", "vbd:20"};

std::vector<std::string> all_of(std::vector<std::vector<std::string>> groups) {
  std::vector<std::string> all;
  for (const auto& group : groups) all.insert(all.end(), group.begin(), group.end());
  return all;
}
const auto name_of = [](const auto& info) {
  std::string name = info.param;
  for (char& letter : name)
    if (letter == '/' || letter == ':') letter = '_';
  return name;
};
bool is_pass(const std::string& method) {
  return std::find(passes.begin(), passes.end(), method) != passes.end();
}

class Reaction : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Methods, Reaction,
                         ::testing::ValuesIn(all_of({explicit_methods, implicit_methods, passes})), name_of);

TEST_P(Reaction, CarriesABlockAtRest) {
  for (const double degrees : {0, 19}) {
    Trial trial(GetParam(), slope(degrees, {.friction = 0.5}));
    trial.advance(4);
    const Vec3 force = trial.mean_until(4.5).planes[0];
    std::printf("rest %s %g: error %.3g\n", GetParam().c_str(), degrees,
                (force + trial.weight()).norm() / trial.weight().norm());
    EXPECT_LT((force + trial.weight()).norm(), (is_pass(GetParam()) ? 1e-3 : 1e-6) * trial.weight().norm())
        << degrees;
  }
}

/// By how much reactions miss the change of momentum, over the weight.
double missing(Trial<>& trial, double t) {
  const Vec3 before = trial.momentum();
  const double begin = trial.state.t;
  const Vec3 force = sum_of(trial.mean_until(t).planes),
             mean = (trial.momentum() - before) / (trial.state.t - begin);
  return (force + trial.weight() - mean).norm() / trial.weight().norm();
}

TEST_P(Reaction, ChangesMomentum) {
  Trial trial(GetParam(), slope(20, {.restitution = 0.4, .friction = 0.3}));
  trial.move({0, 0, 0.05});
  trial.push({0.5, 0.2, 0});
  std::printf("drop %s: missing %.3g\n", GetParam().c_str(), missing(trial, 0.7));
}

TEST_P(Reaction, OfAWedgeChangesMomentum) {
  Environment groove{.gravity = {-g / 2, 0, -g}};
  for (const Vec3& normal : {Vec3(1, 0, 0), Vec3(0, 0, 1)})
    groove.planes.push_back({.normal = normal, .friction = 0.2});
  Trial trial(GetParam(), groove);
  trial.move({0.01, 0, 0.01});
  const Status status = trial.method->advance(trial.system, trial.state, 0.02, trial.work);
  ASSERT_EQ(status, Status::ok);
  std::printf("wedge %s: missing %.3g\n", GetParam().c_str(), missing(trial, 1));
  const Reactions at_rest = trial.mean_until(2);
  std::printf("   x %.6g %.6g %.6g  z %.6g %.6g %.6g / %g\n", at_rest.planes[0][0], at_rest.planes[0][1],
              at_rest.planes[0][2], at_rest.planes[1][0], at_rest.planes[1][1], at_rest.planes[1][2],
              trial.weight().norm());
}

}  // namespace
}  // namespace mss

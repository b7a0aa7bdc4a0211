// Bodies whose surface touches planes, over many steps: drops, slopes, rest, energy.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <numbers>

#include "core/measures/measures.hpp"
#include "core/mesh/shapes.hpp"
#include "integrators/integrator.hpp"
#include "reference/closed_forms.hpp"
#include "tests/centre_of_mass.hpp"
#include "tests/mesh_body.hpp"

namespace mss {
namespace {

using testing::g;

/// A mesh that touches one plane with its surface, a method and a state.
struct SurfaceTrial {
  Plane plane;
  Body body;
  SpringSystem<double> system;
  State<double> state;
  std::unique_ptr<Integrator<double>> method;
  Work work;

  SurfaceTrial(const std::string& name, const IntegratorOptions& options, const TriangleMesh& mesh,
               const BodyConfig& config, const Plane& floor, int threads = 1)
      : plane(floor),
        body(config),
        system(body, testing::on_surface({.gravity = Vec3(0, 0, -g), .planes = {floor}}, mesh),
               {.threads = threads}),
        state(system.rest_state()),
        method(find_integrator(name).make<double>(options)) {}

  void advance(double t) { ASSERT_EQ(method->advance(system, state, t, work), Status::ok); }
  void push(const Vec3& velocity) {
    for (const std::ptrdiff_t site : body.sites()) state.v.set(site, velocity);
  }
  Vec3 centre() const { return testing::centre_of_mass(body, state); }
  Measures measures() const { return measure(system, state); }
  double lowest_gap() const {
    double lowest = std::numeric_limits<double>::infinity();
    for (const Vec3& x : system.surface_contact()->surface().interpolate(state.x))
      lowest = std::min(lowest, plane.gap(x));
    return lowest;
  }
};

BodyConfig damped(BodyConfig config, double ratio) {
  config.damping = {.law = Damping::Law::ratio, .zeta = ratio};
  return config;
}

const TriangleMesh ball = icosphere(0.25, 6);

class SurfaceDrop : public ::testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Some, SurfaceDrop, ::testing::Values("verlet", "semi_implicit_euler"),
                         [](const auto& test) { return test.param; });

// A soft ball falls, bounces, and comes to rest; without friction it keeps its horizontal momentum.
TEST_P(SurfaceDrop, DoesNotSinkAndComesToRest) {
  SurfaceTrial run(GetParam(), {.dt = 5e-4}, ball, damped(testing::mesh_config(ball, 0.1, 2e5), 0.2),
                   {.point = Vec3(0, 0, -0.4), .restitution = 0.5, .friction = 0});
  run.push(Vec3(0.1, 0.2, 0));
  const Measures start = run.measures();
  double lowest = 1, highest_after = -1, peak = 0;
  for (int step = 1; step <= 6000; ++step) {
    run.advance(step * 5e-4);
    lowest = std::min(lowest, run.lowest_gap());
    peak = std::max(peak, run.measures().kinetic);
    if (step > 4000) highest_after = std::max(highest_after, run.lowest_gap());
  }
  const Measures end = run.measures();
  EXPECT_GT(lowest, -1e-9);
  EXPECT_LT(highest_after, 1e-4);       // it does not hover
  EXPECT_LT(end.kinetic, 0.05 * peak);  // it slides and rocks without friction
  EXPECT_NEAR(end.momentum[0], start.momentum[0], 1e-11 * start.momentum.norm());  // rounding of 6000 steps
  EXPECT_NEAR(end.momentum[1], start.momentum[1], 1e-11 * start.momentum.norm());
  const double squeezed = -0.4 + 0.25 - run.centre()[2];
  EXPECT_GT(squeezed, 0);
  EXPECT_LT(squeezed, 0.03);
}

/// A plane of this angle that falls towards +x, through the origin.
Plane slope(double angle, double friction) {
  return {.normal = Vec3(std::sin(angle), 0, std::cos(angle)), .restitution = 0, .friction = friction};
}

/// Of the particles about the y axis through their centre [kg m^2].
double inertia_about_y(const Body& body, const Vec3& centre) {
  double sum = 0;
  for (const std::ptrdiff_t site : body.sites()) {
    const Vec3 arm = body.rest_position(site) - centre;
    sum += body.mass(site) * (arm[0] * arm[0] + arm[2] * arm[2]);
  }
  return sum;
}

// A stiff ball on a slope slides without friction, and rolls with it: its facets are small.
TEST(SurfaceSlope, BallsSlideOrRoll) {
  constexpr double angle = std::numbers::pi / 12, radius = 0.25, time = 0.6;
  const Vec3 along(std::cos(angle), 0, -std::sin(angle));
  for (const double friction : {0.0, 0.6}) {
    const Plane plane = slope(angle, friction);
    TriangleMesh mesh = icosphere(radius, 12);
    place(mesh, {.translation = radius * plane.normal});
    SurfaceTrial run("verlet", {.dt = 2e-4}, mesh, damped(testing::mesh_config(mesh, 0.1, 1e6), 0.1), plane);
    const Vec3 start = run.centre();
    const double mass = run.body.total_mass(), inertia = inertia_about_y(run.body, start);
    run.advance(time);
    const double share = along.dot(run.centre() - start) / (g * std::sin(angle) * time * time / 2);
    const double rim = run.measures().angular_momentum[1] / inertia * radius;  // its speed
    const double speed = along.dot(run.measures().momentum) / mass;
    if (friction == 0) {
      EXPECT_NEAR(share, 1, 1e-3);
      EXPECT_LT(std::abs(rim), 0.05 * speed);
    } else {
      EXPECT_NEAR(share, 1 / (1 + inertia / (mass * radius * radius)), 0.03);
      EXPECT_NEAR(rim / speed, 1, 0.1);
    }
    EXPECT_GT(run.lowest_gap(), -1e-9);
  }
}

TEST(SurfaceSlope, ABlockStopsWhereFrictionSays) {
  const TriangleMesh block = box_mesh({0, 0, 0}, {0.4, 0.3, 0.2});
  SurfaceTrial run("verlet", {.dt = 2e-4}, block, damped(testing::mesh_config(block, 0.07, 1e6), 0.1),
                   {.friction = 0.4});
  run.push(Vec3(0.5, 0, 0));
  const Vec3 start = run.centre();
  run.advance(0.4);
  const double expected = reference::stopping_distance(g, 0.5, 0.4);
  EXPECT_NEAR((run.centre() - start)[0], expected, 0.05 * expected);
  EXPECT_GT(run.lowest_gap(), -1e-9);
}

// With gravity and an elastic plane nothing dissipates.
TEST(SurfacePenalty, KeepsTheEnergyOfABounce) {
  const Plane floor{
      .point = Vec3(0, 0, -0.3), .contact = ContactLaw::penalty, .restitution = 1, .friction = 0};
  double drift[2] = {0,
                     0};  // the largest on the way: what is left at an end depends on the phase of vibrations
  for (int i = 0; i < 2; ++i) {
    SurfaceTrial run("velocity_verlet", {.dt = i == 0 ? 4e-5 : 2e-5}, ball, testing::mesh_config(ball, 0.1),
                     floor);
    const double before = run.measures().total(), fall = run.body.total_mass() * g * 0.05;
    double lowest = 1;
    for (int look = 1; look <= 30; ++look) {
      run.advance(0.01 * look);
      lowest = std::min(lowest, run.lowest_gap());
      drift[i] = std::max(drift[i], std::abs(run.measures().total() - before) / fall);
    }
    EXPECT_LT(lowest, -1e-6);  // it did touch
    EXPECT_GT(lowest, -0.02);
  }
  EXPECT_LT(drift[1], 2e-7);
  EXPECT_NEAR(drift[0] / drift[1], 4, 0.3);  // second order
}

TEST(SurfacePenalty, CarriesTheBallUnderEveryKindOfMethod) {
  const Plane floor{.point = Vec3(0, 0, -0.251), .contact = ContactLaw::penalty};
  std::vector<double> centres, gaps;
  for (const std::string name :
       {"verlet", "implicit_midpoint", "backward_euler", "cvode_bdf", "vbd", "xpbd"}) {
    const IntegratorInfo& info = find_integrator(name);
    const bool adaptive = info.stepping == Stepping::adaptive;
    SurfaceTrial run(name,
                     {.dt = adaptive     ? 0
                            : info.limit ? 2e-5
                                         : 5e-4},
                     ball, damped(testing::mesh_config(ball, 0.12), 0.3), floor);
    run.advance(0.2);
    if (centres.empty()) {
      EXPECT_LT(run.centre()[2], -0.02);
      EXPECT_GT(run.centre()[2], -0.12);  // it would have fallen by 0.196
    }
    centres.push_back(run.centre()[2]);
    gaps.push_back(run.lowest_gap());
    EXPECT_NEAR(centres.back(), centres[0], 3e-3) << name;
    EXPECT_NEAR(gaps.back(), gaps[0], 1e-3) << name;
  }
}

TEST(SurfacePenalty, IsInTheMatricesOfAllLinearSolvers) {
  const Plane floor{.point = Vec3(0, 0, -0.24), .contact = ContactLaw::penalty};
  std::vector<State<double>> ends;
  for (const std::string solver : {"cholmod", "matrix_free", "multigrid"}) {
    SurfaceTrial run("implicit_midpoint", {.dt = 1e-3, .linear_solver = solver}, ball,
                     damped(testing::mesh_config(ball, 0.06), 0.1), floor);
    run.push(Vec3(0, 0, -0.5));
    run.advance(0.02);
    ends.push_back(run.state);
    EXPECT_LT((ends.back().x.array() - ends[0].x.array()).abs().maxCoeff(), 1e-7) << solver;
  }
}

TEST(SurfaceContact, IsTheSameBitsForAnyThreads) {
  for (const ContactLaw law : {ContactLaw::impulse, ContactLaw::penalty}) {
    std::vector<State<double>> ends;
    for (const int threads : {1, 2, 3}) {
      SurfaceTrial run("verlet", {.dt = 5e-5}, ball, damped(testing::mesh_config(ball, 0.1), 0.1),
                       {.point = Vec3(0, 0, -0.26), .contact = law}, threads);
      run.push(Vec3(1, 0, -1));
      run.advance(0.05);
      ends.push_back(run.state);
      EXPECT_EQ((ends.back().x.array() - ends[0].x.array()).abs().maxCoeff(), 0);
      EXPECT_EQ((ends.back().v.array() - ends[0].v.array()).abs().maxCoeff(), 0);
    }
    EXPECT_GT(std::abs(ends[0].v.array().maxCoeff() - 1), 0.05);
  }
}

}  // namespace
}  // namespace mss

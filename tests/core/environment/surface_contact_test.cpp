// Planes that touch the vertices of a mesh: the masses of vertices, penalties against energies, differences
// and bounds, and impulses against their law and momentum.
#include "core/environment/surface_contact.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "core/mesh/shapes.hpp"
#include "integrators/analysis/modes.hpp"
#include "tests/body_derivatives.hpp"
#include "tests/dense_eigenvalues.hpp"
#include "tests/mesh_body.hpp"

namespace mss {
namespace {

/// A ball in cells of a fifth of its width that are full where their centre is inside: some vertices lie
/// outside of all.
struct Ball {
  TriangleMesh mesh = icosphere(0.25, 4);
  Body body{testing::mesh_config(mesh, 0.1, 1e5, FillMode::staircase)};
};

std::size_t lowest_vertex(const TriangleMesh& mesh) {
  const auto lower = [](const Vec3& a, const Vec3& b) { return a[2] < b[2]; };
  return std::size_t(std::min_element(mesh.vertices.begin(), mesh.vertices.end(), lower) -
                     mesh.vertices.begin());
}

/// Two planes in which the ball stands; one has friction.
Environment penalised(const TriangleMesh& mesh) {
  return testing::on_surface({.gravity = Vec3(1, 0, -9.81),
                              .planes = {{.point = Vec3(0, 0, -0.15),
                                          .normal = Vec3(0.1, 0, 1).normalized(),
                                          .contact = ContactLaw::penalty},
                                         {.point = Vec3(-0.2, 0, 0),
                                          .normal = Vec3(1, 0.2, 0).normalized(),
                                          .contact = ContactLaw::penalty,
                                          .friction = 0.9}}},
                             mesh);
}

TEST(VertexMass, IsAsLargeAsTheParticlesAllow) {
  const Ball ball;
  const HeldSites held(ball.body, {});
  const PlaneContact planes({}, {.omega = 1}, 0.1);
  const SurfaceContact contact(ball.mesh, ball.body, held, planes);
  std::vector<double> sums(std::size_t(ball.body.lattice().size));
  bool outside = false;
  for (std::size_t s = 0; s < ball.mesh.vertices.size(); ++s) {
    EXPECT_GT(contact.mass(s), 0);
    double length = 0;
    for (const double weight : contact.surface().weights(s)) length += std::abs(weight);
    outside = outside || length > 1.01;
    for (int c = 0; c < 8; ++c)
      sums[std::size_t(contact.surface().site(s) + ball.body.lattice().corner(c))] +=
          contact.mass(s) * length * std::abs(contact.surface().weights(s)[std::size_t(c)]);
  }
  EXPECT_TRUE(outside);
  double most = 0;
  for (const std::ptrdiff_t site : ball.body.sites())
    most = std::max(most, sums[std::size_t(site)] / ball.body.mass(site));
  EXPECT_LT(most, 1 + 1e-12);
  EXPECT_GT(most, 0.5);
}

TEST(SurfacePenalty, IsInTheTangents) {
  const Ball ball;
  SpringSystem<double> system(ball.body, penalised(ball.mesh), {.threads = 2});
  State<double> state = system.rest_state();
  testing::randomise(ball.body, state, 0.1, 0.5, 5);
  testing::compare_tangents_with_forces(system, state);
}

TEST(SurfacePenalty, IsInTheTotalEnergy) {
  const Ball ball;
  Environment environment = penalised(ball.mesh);
  for (Plane& plane : environment.planes) plane.restitution = 1, plane.friction = 0;
  SpringSystem<double> system(ball.body, environment);
  State<double> state = system.rest_state();
  testing::randomise(ball.body, state, 0.1, 0, 5);
  Field<double> f(system.size()), without(system.size());
  system.force(0, state.x, state.v, f);
  SpringSystem<double>(ball.body, {.gravity = environment.gravity}).force(0, state.x, state.v, without);
  EXPECT_GT((f.array() - without.array()).abs().maxCoeff(), 1);
  testing::compare_forces_with_energy(system, state);
}

TEST(SurfacePenalty, IsInTheAcceleration) {
  const Ball ball;
  SpringSystem<double> system(ball.body, penalised(ball.mesh));
  State<double> state = system.rest_state();
  testing::randomise(ball.body, state, 0.1, 0.5, 5);
  Field<double> f(system.size()), a(system.size());
  system.force(0, state.x, state.v, f);
  system.acceleration(0, state.x, state.v, a);
  for (const std::ptrdiff_t site : ball.body.sites())
    EXPECT_LT((a.at(site) - f.at(site) / ball.body.mass(site)).norm(), 1e-11 * a.array().abs().maxCoeff());
}

/// Deep in a plane in which all vertices are pressed.
Environment deep(const TriangleMesh& mesh) {
  return testing::on_surface(
      {.planes = {{.point = Vec3(0, 0, 5), .contact = ContactLaw::penalty, .restitution = 1, .friction = 0}}},
      mesh);
}

TEST(SurfacePenalty, IsInTheSpectralBound) {
  const Ball ball;
  SpringSystem<double> system(ball.body, deep(ball.mesh));
  Work work;
  const Modes fastest = fastest_mode(system, system.rest_state(), work);
  ASSERT_EQ(fastest.status, Status::ok);
  EXPECT_GT(system.spectral_bound().omega, fastest.modes.front().omega);
  EXPECT_LT(system.spectral_bound().omega, 2.5 * fastest.modes.front().omega);
}

// Without springs beside it: near what the planes' stiffness per mass allows, and not above.
TEST(SurfacePenalty, AddsAtMostItsOwnFrequency) {
  const Ball ball;
  SpringSystem<double> system(ball.body, deep(ball.mesh)), alone(ball.body, {});
  const State<double> rest = system.rest_state();
  const TangentCoefficients stiffness{.stiffness = 1, .kind = Tangent::elastic};
  const Eigen::MatrixXd added =
      testing::tangent_matrix(system, rest, stiffness) - testing::tangent_matrix(alone, rest, stiffness);
  const Eigen::MatrixXd mass = testing::tangent_matrix(system, rest, {.mass = 1});
  const double largest = testing::symmetric_eigenvalues(added, mass).maxCoeff();
  const double allowed = std::pow(system.spectral_bound().omega, 2) - std::pow(system.body_bound().omega, 2);
  EXPECT_LT(largest, allowed * (1 + 1e-9));
  EXPECT_GT(largest, 0.3 * allowed);
}

TEST(SurfacePenalty, HasAnEventWhereTheLowestVertexTouches) {
  const Ball ball;
  const Environment environment = testing::on_surface(
      {.planes = {{.point = Vec3(0, 0, -0.3), .contact = ContactLaw::penalty}, {}}}, ball.mesh);
  SpringSystem<double> system(ball.body, environment);
  const std::vector<double> gaps = system.events()->event_functions(0, system.rest_state().x);
  ASSERT_EQ(gaps.size(), 1U);
  EXPECT_NEAR(gaps[0], ball.mesh.vertices[lowest_vertex(ball.mesh)][2] + 0.3, 1e-14);
}

/// The ball flies through the floor, deformed, with a velocity that differs from particle to particle.
struct SurfaceCrash {
  Ball ball;
  State<double> before, after;
  double dt = 0.01;
  explicit SurfaceCrash(double speed) {
    const SpringSystem<double> system(ball.body, {});
    before = system.rest_state();
    testing::randomise(ball.body, before, 0.05, 0.5, 3);
    for (const std::ptrdiff_t site : ball.body.sites())
      before.v.set(site, before.v.at(site) + Vec3(1, 2, -speed));
    after = before;
    after.x.array() += dt * before.v.array();
  }
  /// A floor this far above the lowest vertex at the end.
  Environment floor(double depth, double restitution, double friction) const {
    const SpringSystem<double> system(ball.body, {});
    const EmbeddedSurface surface(ball.mesh, ball.body.config().voxels, ball.body.config().cell_size,
                                  ball.body.config().origin);
    double lowest = 1;
    for (const Vec3& x : surface.interpolate(after.x)) lowest = std::min(lowest, x[2]);
    return testing::on_surface(
        {.planes = {{.point = Vec3(0, 0, lowest + depth), .restitution = restitution, .friction = friction}}},
        ball.mesh);
  }
};

// One vertex touches: it moves exactly as the law says, and the body takes its impulse.
TEST(SurfaceImpulse, IsThatOfTheLaw) {
  const SurfaceCrash crash(3);
  const Environment environment = crash.floor(1e-4, 0.6, 0.3);
  SpringSystem<double> system(crash.ball.body, environment);
  State<double> state = crash.after;
  ASSERT_TRUE(system.events()->collide(crash.before, crash.dt, state));
  const EmbeddedSurface& surface = system.surface_contact()->surface();
  std::size_t s = 0;
  const std::vector<Vec3> ends = surface.interpolate(crash.after.x);
  for (std::size_t i = 0; i < ends.size(); ++i)
    if (ends[i][2] < ends[s][2]) s = i;
  Motion expected{surface.at(s, crash.after.x), surface.at(s, crash.after.v)};
  const Vec3 free = expected.v;
  ASSERT_TRUE(collide_impulse(environment.planes.front(),
                              {surface.at(s, crash.before.x), surface.at(s, crash.before.v)}, crash.dt,
                              expected));
  EXPECT_LT((surface.at(s, state.x) - expected.x).norm(), 1e-15);
  EXPECT_LT((surface.at(s, state.v) - expected.v).norm(), 1e-14);
  double yield = 0;
  for (int c = 0; c < 8; ++c)
    yield += std::pow(surface.weights(s)[std::size_t(c)], 2) /
             crash.ball.body.mass(surface.site(s) + crash.ball.body.lattice().corner(c));
  const Measures m = measure(system, state), m0 = measure(system, crash.after);
  EXPECT_LT((m.momentum - m0.momentum - (expected.v - free) / yield).norm(), 1e-14 * m0.momentum.norm());
  EXPECT_GT((m.momentum - m0.momentum).norm(), 0.1);
  EXPECT_LT(m.kinetic, m0.kinetic);
}

TEST(SurfaceImpulse, WithoutFrictionActsAlongTheNormalOnly) {
  const SurfaceCrash crash(3);
  SpringSystem<double> system(crash.ball.body, crash.floor(0.02, 0.5, 0));
  State<double> state = crash.after;
  ASSERT_TRUE(system.events()->collide(crash.before, crash.dt, state));
  const Measures m = measure(system, state), m0 = measure(system, crash.after);
  EXPECT_NEAR(m.momentum[0], m0.momentum[0], 1e-14 * m0.momentum.norm());
  EXPECT_NEAR(m.momentum[1], m0.momentum[1], 1e-14 * m0.momentum.norm());
  EXPECT_GT(m.momentum[2], m0.momentum[2] + 0.01 * m0.momentum.norm());
}

TEST(SurfaceImpulse, LeavesNoVertexBehindThePlaneAndAddsNoEnergy) {
  for (const double restitution : {0.0, 0.5, 1.0})
    for (const double friction : {0.0, 0.4}) {
      const SurfaceCrash crash(3);
      const Environment environment = crash.floor(0.02, restitution, friction);
      SpringSystem<double> system(crash.ball.body, environment);
      State<double> state = crash.after;
      ASSERT_TRUE(system.events()->collide(crash.before, crash.dt, state));
      int behind = 0;
      const std::vector<Vec3> ends = system.surface_contact()->surface().interpolate(state.x),
                              free = system.surface_contact()->surface().interpolate(crash.after.x);
      for (std::size_t s = 0; s < ends.size(); ++s) {
        EXPECT_GT(environment.planes[0].gap(ends[s]), -1e-10);
        behind += environment.planes[0].gap(free[s]) < 0 ? 1 : 0;
      }
      EXPECT_GT(behind, 5);
      EXPECT_LT(measure(system, state).kinetic, measure(system, crash.after).kinetic * (1 + 1e-12));
    }
}

TEST(SurfaceImpulse, IsTheSameBitsForAnyThreads) {
  const SurfaceCrash crash(3);
  std::vector<State<double>> results;
  for (const int threads : {1, 2, 3}) {
    SpringSystem<double> system(crash.ball.body, crash.floor(0.02, 0.5, 0.4), {.threads = threads});
    results.push_back(crash.after);
    EXPECT_TRUE(system.events()->collide(crash.before, crash.dt, results.back()));
    EXPECT_EQ((results.back().x.array() - results[0].x.array()).abs().maxCoeff(), 0);
    EXPECT_EQ((results.back().v.array() - results[0].v.array()).abs().maxCoeff(), 0);
  }
  EXPECT_GT((results[0].x.array() - crash.after.x.array()).abs().maxCoeff(), 1e-3);
}

TEST(SurfaceImpulse, DoesNotMoveWhatIsHeld) {
  const SurfaceCrash crash(3);
  Environment environment = crash.floor(0.02, 0.5, 0.4);
  const Box low{Vec3(-1, -1, -1), Vec3(1, 1, -0.16)};
  environment.holds = {{.box = low, .axes = {false, false, true}}};
  SpringSystem<double> system(crash.ball.body, environment);
  State<double> state = crash.after;
  system.events()->collide(crash.before, crash.dt, state);
  double moved = 0;
  int held = 0;
  for (const std::ptrdiff_t site : crash.ball.body.select(low.lower, low.upper)) {
    EXPECT_EQ(state.x.at(site)[2], crash.after.x.at(site)[2]);
    EXPECT_EQ(state.v.at(site)[2], crash.after.v.at(site)[2]);
    moved = std::max(moved, std::abs(state.v.at(site)[0] - crash.after.v.at(site)[0]));
    ++held;
  }
  EXPECT_GT(held, 3);
  EXPECT_GT(moved, 1e-3);  // friction acts
}

// In single precision a vertex rests within rounding.
TEST(SurfaceImpulse, ActsInSinglePrecisionToo) {
  const SurfaceCrash crash(3);
  const Environment environment = crash.floor(0.02, 0.5, 0.4);
  SpringSystem<double> reference(crash.ball.body, environment);
  SpringSystem<float> system(crash.ball.body, environment);
  State<double> expected = crash.after;
  reference.events()->collide(crash.before, crash.dt, expected);
  const auto single = [&](const State<double>& from) {
    State<float> to = system.rest_state();
    for (const std::ptrdiff_t site : crash.ball.body.sites()) {
      to.x.set(site, from.x.at(site));
      to.v.set(site, from.v.at(site));
    }
    return to;
  };
  State<float> state = single(crash.after);
  ASSERT_TRUE(system.events()->collide(single(crash.before), crash.dt, state));
  for (const std::ptrdiff_t site : crash.ball.body.sites())
    EXPECT_LT((state.x.at(site) - expected.x.at(site)).norm(), 1e-5);
}

}  // namespace
}  // namespace mss

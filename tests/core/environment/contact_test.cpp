// The laws of contact, one particle at a time, and a body that has planes: forces against energies, tangents
// against differences of forces, holds and threads.
#include "core/environment/contact.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cstring>
#include <random>

#include "reference/fem/fem_system.hpp"
#include "reference/mollemans.hpp"
#include "tests/body_derivatives.hpp"
#include "tests/centre_of_mass.hpp"
#include "tests/dense_eigenvalues.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

using Eigen::Matrix3d;
using testing::g;

/// Motion of a particle under a constant acceleration after a time.
Motion flight(const Motion& start, const Vec3& a, double time) {
  return {start.x + time * start.v + time * time / 2 * a, start.v + time * a};
}

TEST(Impulse, FindsTheImpactWithinTheStep) {
  const Plane plane{.restitution = 0.6, .friction = 0};
  const Vec3 a(0, 0, -g);
  const Motion start{Vec3(1, 2, 0.003), Vec3(4, 0, -5)};
  const double dt = 1e-3, speed = std::sqrt(25 + 2 * g * 0.003), time = (speed - 5) / g;
  const Motion expected =
      flight({start.x + time * Vec3(4, 0, 0) - Vec3(0, 0, 0.003), Vec3(4, 0, 0.6 * speed)}, a, dt - time);
  Motion end = flight(start, a, dt);
  ASSERT_TRUE(collide_impulse(plane, start, dt, end));
  EXPECT_LT((end.x - expected.x).norm(), 1e-15);
  EXPECT_LT((end.v - expected.v).norm(), 1e-12);
  // A velocity that lags by half a step gives the same, half a step late.
  const Motion lagging{start.x, start.v - dt / 2 * a};
  end = flight(start, a, dt);
  end.v -= dt / 2 * a;
  ASSERT_TRUE(collide_impulse(plane, lagging, dt, end));
  EXPECT_LT((end.x - expected.x).norm(), 1e-15);
  EXPECT_LT((end.v - (expected.v - dt / 2 * a)).norm(), 1e-12);
}

TEST(Impulse, LeavesAloneWhatDoesNotTouch) {
  const Motion start{Vec3(0, 0, 0.1), Vec3(0, 0, -1)};
  Motion end{Vec3(0, 0, 1e-9), Vec3(0, 0, -1)};
  EXPECT_FALSE(collide_impulse({}, start, 0.1, end));
  EXPECT_EQ(end.x, Vec3(0, 0, 1e-9));
}

// Rebounds shorter than a step count as rest; friction takes mu times the impulse that stopped the fall.
TEST(Impulse, RestsAndSlides) {
  const Plane plane{.restitution = 0.9, .friction = 0.3};
  const double dt = 1e-2;
  const Motion start{Vec3::Zero(), Vec3(2, 0, 0)};
  Motion end = flight(start, Vec3(0, 0, -g), dt);
  ASSERT_TRUE(collide_impulse(plane, start, dt, end));
  EXPECT_LT((end.v - Vec3(2 - 0.3 * g * dt, 0, 0)).norm(), 1e-14);
  EXPECT_LT((end.x - Vec3(2 * dt - 0.3 * g * dt * dt / 2, 0, 0)).norm(), 1e-15);
}

TEST(Impulse, FrictionStaysInsideCoulombsCone) {
  const Plane plane{.restitution = 0.5, .friction = 0.2};
  const auto slid = [&](double speed) {
    const Motion start{Vec3(0, 0, 1e-3), Vec3(speed, 0, -2)};
    Motion end{start.x + 1e-2 * start.v, start.v};
    EXPECT_TRUE(collide_impulse(plane, start, 1e-2, end));
    EXPECT_NEAR(end.v[2], 1, 1e-12);
    return speed - end.v[0];
  };
  EXPECT_NEAR(slid(5), 0.2 * 3, 1e-12);    // the cone's edge: mu times the normal impulse, (1 + e) 2 m/s
  EXPECT_NEAR(slid(-5), -0.2 * 3, 1e-12);  // in either direction
  EXPECT_NEAR(slid(0.5), 0.5, 1e-15);      // inside: it stops
}

TEST(Impulse, SticksWithinTheConeOnly) {
  const Plane plane{.friction = 0.5};
  const Motion rest{Vec3::Zero(), Vec3::Zero()};
  EXPECT_TRUE(sticks(plane, rest, Vec3(0.499 * g, 0, -g), 1e-9));
  EXPECT_FALSE(sticks(plane, rest, Vec3(0.501 * g, 0, -g), 1e-9));
  EXPECT_FALSE(sticks(plane, rest, Vec3(0, 0, g), 1e-9));                               // it is lifted
  EXPECT_FALSE(sticks(plane, {Vec3(0, 0, 1e-8), Vec3::Zero()}, Vec3(0, 0, -g), 1e-9));  // it hovers
  EXPECT_FALSE(sticks(plane, {Vec3::Zero(), Vec3(1e-9, 0, 0)}, Vec3(0, 0, -g), 1e-9));  // it moves
}

TEST(ThesisLaw, ReflectsAllOfTheVelocity) {
  const Plane plane{.restitution = 0.5, .friction = 0.4};
  const Motion start{Vec3(0, 0, 0.01), Vec3(3, 0, -2)};
  Motion end{Vec3(0.03, 0, -0.01), Vec3(3, 0, -2)};
  ASSERT_TRUE(collide_thesis(plane, start, end));
  EXPECT_LT((end.x - Vec3(0.03, 0, 0.01)).norm(), 1e-15);
  EXPECT_LT((end.v - Vec3(1.5, 0, 1)).norm(), 1e-15);  // sliding is lost too
}

TEST(ThesisLaw, ForgetsWhatCameThrough) {
  const Motion start{Vec3(0, 0, -0.1), Vec3(0, 0, -1)};
  Motion end{Vec3(0, 0, -0.2), Vec3(0, 0, -1)};
  EXPECT_FALSE(collide_thesis({}, start, end));
}

TEST(ThesisLaw, SupportsWhatIsSlow) {
  const Plane plane{.friction = 0.2};
  const double dt = 1e-2;
  const Motion rest{Vec3(0, 0, 0), Vec3::Zero()};
  Motion end{dt * dt * Vec3(1, 0, -g), dt * Vec3(1, 0, -g)};
  ASSERT_TRUE(collide_thesis(plane, rest, end));
  EXPECT_EQ(end.x, rest.x);
  EXPECT_LT((end.v - dt * g * Vec3(-0.2, 0, 1)).norm(),
            1e-15);  // mu N, though the tangential force is only half of it
}

constexpr SpectralBound stiff{.omega = 300, .damping = 0};

Penalty penalty(double restitution, double friction) {
  const Plane plane{.point = Vec3(0.1, 0, 0),
                    .normal = Vec3(1, 2, 2) / 3,
                    .contact = ContactLaw::penalty,
                    .restitution = restitution,
                    .friction = friction};
  return {plane, stiff, g, 0.1};
}

/// Motions at every relevant depth: outside, in the soft layer (up to a hundredth of a cell) and beyond.
std::vector<Motion> motions() {
  std::vector<Motion> all;
  for (const double depth : {-1e-4, 1e-5, 5e-4, 9e-4, 2e-3, 0.05})
    for (const double speed : {-3.0, -0.01, 0.02, 1.0})
      for (const Vec3& slip : {Vec3(0, 1, -1), Vec3(0.02, -0.02, 0.01), Vec3(0, 0, 0)})
        all.push_back({Vec3(0.1, 0, 0) + Vec3(0, 0.3, -0.3) - depth * Vec3(1, 2, 2) / 3,
                       speed * Vec3(1, 2, 2) / 3 + slip});
  return all;
}

/// Derivatives of the force by x, or by v.
Matrix3d differences(const Penalty& law, const Motion& motion, bool of_positions) {
  Matrix3d slope;
  for (int axis = 0; axis < 3; ++axis) {
    Motion plus = motion, minus = motion;
    const double step = 1e-9;
    (of_positions ? plus.x : plus.v)[axis] += step;
    (of_positions ? minus.x : minus.v)[axis] -= step;
    slope.col(axis) = (law.acceleration(minus) - law.acceleration(plus)) / (2 * step);
  }
  return slope;
}

TEST(Penalty, TangentEqualsDifferencesOfTheForce) {
  const Penalty law = penalty(0.4, 0.7);
  int touching = 0;
  for (const Motion& motion : motions()) {
    const Matrix3d k = law.tangent(motion, {.stiffness = 1}), c = law.tangent(motion, {.damping = 1});
    EXPECT_LT((k - differences(law, motion, true)).norm(), 1e-4 * (1 + k.norm()));
    EXPECT_LT((c - differences(law, motion, false)).norm(), 1e-4 * (1 + c.norm()));
    if (k.norm() > 0) ++touching;
  }
  EXPECT_EQ(touching, 5 * 4 * 3);
}

TEST(Penalty, SymmetricTangentsLeaveOutHowFrictionFollowsPressure) {
  const Penalty law = penalty(0.4, 0.7);
  for (const Motion& motion : motions())
    for (const TangentCoefficients part :
         {TangentCoefficients{.stiffness = 1}, TangentCoefficients{.damping = 1}}) {
      TangentCoefficients elastic = part, projected = part;
      elastic.kind = Tangent::elastic;
      projected.kind = Tangent::projected;
      const Matrix3d m = law.tangent(motion, elastic);
      EXPECT_LT((m - m.transpose()).norm(), 1e-12 * (1 + m.norm()));
      EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix3d>(m).eigenvalues()[0], -1e-9 * (1 + m.norm()));
      EXPECT_EQ(m, law.tangent(motion, projected));
      if (part.stiffness == 0) continue;  // it contains the damping of friction
      EXPECT_LT((m - penalty(0.4, 0).tangent(motion, part)).norm(), 1e-12 * (1 + m.norm()));
    }
}

TEST(Penalty, ForceIsTheSlopeOfItsEnergy) {
  const Penalty law = penalty(1, 0);
  for (const Motion& motion : motions()) {
    const Vec3 force = law.acceleration(motion);
    for (int axis = 0; axis < 3; ++axis) {
      Vec3 plus = motion.x, minus = motion.x;
      plus[axis] += 1e-7;
      minus[axis] -= 1e-7;
      EXPECT_NEAR((law.potential(minus) - law.potential(plus)) / 2e-7, force[axis],
                  1e-5 * (1e-2 + force.norm()));
    }
  }
}

/// Speed after a collision over that before, in small steps of classical Runge-Kutta.
double realised_restitution(const Penalty& law, const Vec3& normal, double speed) {
  Motion m{Vec3(0.1, 0, 0), -speed * normal};
  const double dt = 1e-6;
  do {
    const Vec3 k1 = law.acceleration(m), v1 = m.v;
    const Vec3 v2 = m.v + dt / 2 * k1, k2 = law.acceleration({m.x + dt / 2 * v1, v2});
    const Vec3 v3 = m.v + dt / 2 * k2, k3 = law.acceleration({m.x + dt / 2 * v2, v3});
    const Vec3 v4 = m.v + dt * k3, k4 = law.acceleration({m.x + dt * v3, v4});
    m.x += dt / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
    m.v += dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    EXPECT_GE(normal.dot(law.acceleration(m)), 0);  // it never pulls
  } while (law.gap(m.x) < 0);
  return normal.dot(m.v) / speed;
}

TEST(Penalty, GivesBackWhatItsRestitutionSays) {
  const Vec3 normal = Vec3(1, 2, 2) / 3;
  for (const double speed : {0.5, 5.0}) {
    EXPECT_NEAR(realised_restitution(penalty(1, 0.4), normal, speed), 1, 1e-6);
    EXPECT_NEAR(realised_restitution(penalty(0.8, 0.4), normal, speed), 0.8, 0.01);
    EXPECT_NEAR(realised_restitution(penalty(0.5, 0.4), normal, speed), 0.5, 0.01);
    EXPECT_NEAR(realised_restitution(penalty(0.2, 0.4), normal, speed), 0.2, 0.03);
  }
}

Environment penalised(const Vec3& corner) {
  return {.gravity = Vec3(1, 0, -g),
          .planes = {{.point = corner + Vec3(0, 0, 0.05),
                      .normal = Vec3(0.1, 0, 1).normalized(),
                      .contact = ContactLaw::penalty},
                     {.point = corner + Vec3(0.05, 0, 0),
                      .normal = Vec3(1, 0.2, 0).normalized(),
                      .contact = ContactLaw::penalty,
                      .friction = 0.9}}};
}

/// Tangents of a body that stands in two penalty planes.
template <class MakeSystem>
void compare_tangents(MakeSystem&& make) {
  BodyConfig config = testing::test_config(VoxelGrid::box(2, 1, 2));
  config.fill({.young = 1e4, .poisson = 0.3}, 0.5);
  const Body body(config);
  const auto system = make(body, penalised(config.origin));
  State<double> state = system->rest_state();
  testing::randomise(body, state, 0.1, 0.5, 5);
  testing::compare_tangents_with_forces(*system, state);
}

TEST(PenaltyPlanes, AreInTheTangentsOfSprings) {
  compare_tangents([](const Body& body, const Environment& environment) {
    return std::make_unique<SpringSystem<double>>(body, environment, Execution{.threads = 2});
  });
}
TEST(PenaltyPlanes, AreInTheTangentsOfElements) {
  compare_tangents([](const Body& body, const Environment& environment) {
    return std::make_unique<FemSystem>(body, environment, solid_laws().front(), 2);
  });
}

TEST(PenaltyPlanes, AreInTheTangentsOfMollemanss) {
  compare_tangents([](const Body& body, const Environment& environment) {
    return std::make_unique<MollemansSystem>(body, environment, 2);
  });
}

TEST(PenaltyPlanes, AreInTheTotalEnergy) {
  BodyConfig config = testing::test_config(VoxelGrid::box(2, 2, 2));
  config.damping = {};
  const Body body(config);
  Environment environment = penalised(config.origin);
  for (Plane& plane : environment.planes) plane.restitution = 1, plane.friction = 0;
  SpringSystem<double> system(body, environment);
  State<double> state = system.rest_state();
  testing::randomise(body, state, 0.1, 0, 5);
  Field<double> f(system.size()), without(system.size());
  system.force(0, state.x, state.v, f);
  SpringSystem<double>(body, {.gravity = environment.gravity}).force(0, state.x, state.v, without);
  EXPECT_GT((f.array() - without.array()).abs().maxCoeff(), 1);
  testing::compare_forces_with_energy(system, state);
}

// The bound that dt = "safe" relies on: above the fastest mode of a body deep in the planes, yet near it.
TEST(PenaltyPlanes, AreInTheSpectralBound) {
  BodyConfig config = testing::test_config(VoxelGrid::box(2, 1, 2));
  config.damping = {};
  const Body body(config);
  Environment environment = penalised(config.origin);
  environment.planes[0].point = environment.planes[1].point = config.origin + Vec3(5, 5, 5);
  environment.planes[0].normal = environment.planes[1].normal = Vec3::UnitX();
  SpringSystem<double> system(body, environment);
  const State<double> state = system.rest_state();
  const auto largest = [&](const TangentCoefficients& sum) {
    SparseMatrix matrix = system.tangents()->pattern();
    system.tangents()->values(0, state.x, state.v, sum, matrix);
    Eigen::VectorXd mass(matrix.rows());
    for (Eigen::Index i = 0; i < mass.size(); ++i)
      mass[i] = std::sqrt(body.mass(system.tangents()->unknowns()[std::size_t(i)].site));
    const Eigen::MatrixXd scaled =
        mass.cwiseInverse().asDiagonal() * Eigen::MatrixXd(matrix) * mass.cwiseInverse().asDiagonal();
    return testing::symmetric_eigenvalues(scaled)[mass.size() - 1];
  };
  const SpectralBound bound = system.spectral_bound();
  const double omega = std::sqrt(largest({.stiffness = 1, .kind = Tangent::elastic}));
  EXPECT_GT(bound.omega, omega);
  EXPECT_LT(bound.omega, 1.5 * omega);
  const double damping = largest({.damping = 1, .kind = Tangent::elastic});
  EXPECT_GT(bound.damping, damping * (1 - 1e-12));
  EXPECT_LT(bound.damping, 1.5 * damping);
  EXPECT_GT(damping, 10 * omega);
}

TEST(PenaltyPlanes, HaveAnEventWhereTheLowestParticleTouches) {
  const Body body(free_particles());
  SpringSystem<double> system(body, {.planes = {{.point = Vec3(0, 0, -0.2), .contact = ContactLaw::penalty},
                                                {.contact = ContactLaw::impulse}}});
  const std::vector<double> gaps = system.events()->event_functions(0, system.rest_state().x);
  ASSERT_EQ(gaps.size(), 1U);
  EXPECT_NEAR(gaps[0], 0.2, 1e-15);
  EXPECT_TRUE(SpringSystem<double>(body, {}).events()->event_functions(0, system.rest_state().x).empty());
}

/// A body above a floor and beside a wall, and the step that moved it through both.
struct Crash {
  Body body{testing::test_config(VoxelGrid::box(3, 2, 4))};
  State<double> before, after;
  Environment environment{
      .gravity = Vec3::Zero(),
      .planes = {{.point = Vec3(0, 0, 0.5)}, {.point = Vec3(0.3, 0, 0), .normal = Vec3::UnitX()}}};
  Crash() {
    const SpringSystem<double> system(body, {});
    before = after = system.rest_state();
    testing::randomise(body, before, 0.3, 2, 3);
    after = before;
    after.x.array() += 0.02 * before.v.array();
  }
};

TEST(Collisions, AreTheSameBitsForAnyThreads) {
  const Crash crash;
  std::vector<State<double>> results;
  for (const int threads : {1, 2, 3}) {
    SpringSystem<double> system(crash.body, crash.environment, {.threads = threads});
    EXPECT_TRUE(system.events()->collides());
    results.push_back(crash.after);
    EXPECT_TRUE(system.events()->collide(crash.before, 0.02, results.back()));
  }
  for (const State<double>& other : results) {
    EXPECT_EQ((other.x.array() - results[0].x.array()).abs().maxCoeff(), 0);
    EXPECT_EQ((other.v.array() - results[0].v.array()).abs().maxCoeff(), 0);
  }
  EXPECT_GT((results[0].x.array() - crash.after.x.array()).abs().maxCoeff(), 1e-3);
}

TEST(Collisions, LeaveNoParticleBehindAPlane) {
  const Crash crash;
  SpringSystem<double> system(crash.body, crash.environment);
  State<double> state = crash.after;
  system.events()->collide(crash.before, 0.02, state);
  int behind = 0;
  for (const std::ptrdiff_t site : crash.body.sites())
    for (const Plane& plane : crash.environment.planes) {
      const double start = plane.gap(crash.before.x.at(site));
      EXPECT_GE(plane.gap(state.x.at(site)), std::min(0.0, start) - 1e-15);
      if (plane.gap(crash.after.x.at(site)) < 0) ++behind;
    }
  EXPECT_GT(behind, 10);
}

// A particle that one plane has placed behind itself by rounding does not collide again because of others.
TEST(Collisions, WithOnePlaneDoNotDependOnOthersFarAway) {
  const Body body(free_particles());
  const Plane slope{.normal = Vec3(0.36397, 0, 1).normalized(), .restitution = 0.2, .friction = 0.2};
  const Plane far{.point = Vec3(0, 0, -50)};
  SpringSystem<double> alone(body, {.planes = {slope}}), among(body, {.planes = {slope, far}});
  std::mt19937 random(3);
  std::uniform_real_distribution<> share(0, 1);
  constexpr double dt = 1e-3;
  int landings = 0;
  for (int trial = 0; trial < 500; ++trial) {
    State<double> before = alone.rest_state();
    for (const std::ptrdiff_t site : body.sites()) {
      const double x = share(random), y = share(random), fall = -0.02 * share(random);
      const Vec3 at(x, y, 0);
      before.x.set(site, at - slope.gap(at) * slope.normal - 0.5 * fall * dt * share(random) * slope.normal);
      before.v.set(site, fall * slope.normal + 0.1 * share(random) * Vec3::UnitY());
    }
    State<double> one = before;
    for (const std::ptrdiff_t site : body.sites()) {
      one.v.set(site, before.v.at(site) + dt * Vec3(0, 0, -testing::gravity));
      one.x.set(site, before.x.at(site) + dt * one.v.at(site));
    }
    State<double> other = one;
    alone.events()->collide(before, dt, one);
    among.events()->collide(before, dt, other);
    for (const std::ptrdiff_t site : body.sites()) {
      EXPECT_EQ(one.v.at(site), other.v.at(site));
      EXPECT_EQ(one.x.at(site), other.x.at(site));
      if (std::abs(slope.gap(one.x.at(site))) < 1e-15) ++landings;
    }
  }
  EXPECT_GT(landings, 1000);
}

TEST(Collisions, DoNotMoveWhatIsHeld) {
  Crash crash;
  const Vec3 low = crash.body.config().origin;
  crash.environment.holds = {{.box = {low, low + Vec3(1, 1, 0)}, .axes = {false, false, true}}};
  SpringSystem<double> system(crash.body, crash.environment);
  State<double> state = crash.after;
  system.events()->collide(crash.before, 0.02, state);
  double moved = 0;
  for (const std::ptrdiff_t site : crash.body.select(low, low + Vec3(1, 1, 0))) {
    EXPECT_EQ(state.x.at(site)[2], crash.after.x.at(site)[2]);
    EXPECT_EQ(state.v.at(site)[2], crash.after.v.at(site)[2]);
    moved = std::max(moved, std::abs(state.x.at(site)[0] - crash.after.x.at(site)[0]));
  }
  EXPECT_GT(moved, 1e-3);  // along the other axes it collides
}

TEST(Collisions, AreNoneWithoutPlanes) {
  const Crash crash;
  SpringSystem<double> none(crash.body, {}), soft(crash.body, {.planes = {{.contact = ContactLaw::penalty}}});
  EXPECT_FALSE(none.events()->collides());
  EXPECT_FALSE(soft.events()->collides());
}

}  // namespace
}  // namespace mss

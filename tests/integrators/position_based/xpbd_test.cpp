// Extended position-based dynamics: against plain loops, its limits at small and many steps, what it keeps.
#include <gtest/gtest.h>

#include <cstring>

#include "core/base/error.hpp"
#include "core/environment/tethered_system.hpp"
#include "integrators/integrator.hpp"
#include "integrators/position_based/xpbd_solver.hpp"
#include "reference/projected_constraints.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

std::vector<double> inverse_masses(const Body& body) {
  std::vector<double> inverse(std::size_t(body.lattice().size), 0);
  for (const std::ptrdiff_t site : body.sites()) inverse[std::size_t(site)] = 1 / body.mass(site);
  return inverse;
}

/// Largest difference of positions after a few steps from plain loops, over how far particles moved.
template <class Real>
double difference_from_plain_loops(const Body& body, double dt, int passes) {
  SpringSystem<Real> system(body, {}, {.threads = 2});
  State<Real> state = system.rest_state();
  testing::randomise(body, state, 0.1, 0.5, 3);
  State<double> plain{0, Field<double>(system.size()), Field<double>(system.size())};
  for (const std::ptrdiff_t site : body.sites()) {
    plain.x.set(site, state.x.at(site));
    plain.v.set(site, state.v.at(site));
  }
  const State<double> start = plain;
  reference::ProjectedConstraints constraints(body, inverse_masses(body), dt);
  constexpr int steps = 5;
  for (int step = 0; step < steps; ++step) {
    Field<double> u = plain.v;
    u.array() *= dt;
    constraints.forget();
    for (int pass = 0; pass < passes; ++pass) constraints.project(plain.x, u);
    plain.x.array() += u.array();
    plain.v.array() = u.array() / dt;
  }
  Work work;
  EXPECT_EQ(find_integrator("xpbd")
                .make<Real>({.dt = dt, .iterations = passes})
                ->advance(system, state, steps * dt, work),
            Status::ok);
  double largest = 0, moved = 0;
  for (const std::ptrdiff_t site : body.sites()) {
    largest = std::max(largest, (state.x.at(site) - plain.x.at(site)).norm());
    moved = std::max(moved, (start.x.at(site) - plain.x.at(site)).norm());
  }
  return largest / moved;
}

TEST(Xpbd, EqualsPlainLoopsOnEveryShape) {
  for (const auto& [name, voxels] : testing::test_shapes())
    for (const bool damped : {false, true})
      for (const int passes : {1, 4}) {
        BodyConfig config = testing::test_config(voxels);
        if (!damped) config.damping = {};
        const Body body(config);
        EXPECT_LT(difference_from_plain_loops<double>(body, 0.02, passes), 1e-11) << name << passes;
        EXPECT_LT(difference_from_plain_loops<float>(body, 0.02, passes), 1e-4) << name << passes;
      }
}

TEST(Xpbd, EqualsPlainLoopsWhereCellsAreMixed) {
  unsigned seed = 0;
  for (const auto& [name, voxels] : testing::test_shapes()) {
    const Body body(testing::mixed_config(voxels, ++seed));
    EXPECT_LT(difference_from_plain_loops<double>(body, 0.02, 2), 1e-11) << name;
    EXPECT_LT(difference_from_plain_loops<float>(body, 0.02, 2), 1e-4) << name;
  }
}

/// A spinning, stretched, undamped body in free fall.
struct XpbdScenario {
  explicit XpbdScenario(int threads = 1)
      : body([] {
          BodyConfig config = testing::test_config(VoxelGrid::box(5, 4, 6));
          config.damping = {};
          return config;
        }()),
        system(body, {.gravity = Vec3(0, 0, -9.81)}, {.threads = threads}),
        state(system.rest_state()) {
    testing::randomise(body, state, 0.1, 0.5, 7);
  }
  State<double> end(const IntegratorOptions& options, const char* method = "xpbd", double t = 0.1) {
    State<double> at = state;
    Work work;
    EXPECT_EQ(find_integrator(method).make<double>(options)->advance(system, at, t, work), Status::ok);
    return at;
  }
  double distance(const State<double>& a, const State<double>& b) const {
    double sum = 0;
    for (const std::ptrdiff_t site : body.sites()) sum += (a.x.at(site) - b.x.at(site)).squaredNorm();
    return std::sqrt(sum);
  }
  Body body;
  SpringSystem<double> system;
  State<double> state;
};

TEST(Xpbd, IsTheSameForAnyNumberOfThreads) {
  const State<double> one = XpbdScenario(1).end({.dt = 1e-3, .iterations = 2});
  for (const int threads : {2, 3, 8}) {
    const State<double> other = XpbdScenario(threads).end({.dt = 1e-3, .iterations = 2});
    EXPECT_EQ(std::memcmp(one.x.axis(0), other.x.axis(0), std::size_t(one.x.size()) * sizeof(double)), 0);
    EXPECT_EQ(std::memcmp(one.v.axis(0), other.v.axis(0), std::size_t(one.v.size()) * sizeof(double)), 0);
  }
}

TEST(Xpbd, KeepsLinearMomentum) {
  const double dt = 5e-3;
  for (const int passes : {1, 10}) {
    XpbdScenario s;
    const Field<double> x = s.state.x;
    Vec3 momentum = Vec3::Zero();
    double size = 0;
    for (const std::ptrdiff_t site : s.body.sites()) {
      momentum += s.body.mass(site) * s.state.v.at(site);
      size += s.body.mass(site) * s.state.v.at(site).norm();
    }
    const State<double> after = s.end({.dt = dt, .iterations = passes}, "xpbd", dt);
    Vec3 change = -momentum;
    for (const std::ptrdiff_t site : s.body.sites()) change += s.body.mass(site) * after.v.at(site);
    EXPECT_LT((change - s.body.total_mass() * dt * Vec3(0, 0, -9.81)).norm() / size, 1e-14) << passes;
  }
}

TEST(Xpbd, TendsToSemiImplicitEuler) {
  XpbdScenario s;
  const auto gap = [&](double dt) {
    return s.distance(s.end({.dt = dt}), s.end({.dt = dt}, "semi_implicit_euler"));
  };
  const double coarse = gap(1e-4), fine = gap(5e-5);
  EXPECT_GT(fine, 0);
  EXPECT_NEAR(coarse / fine, 2, 0.1);
}

TEST(Xpbd, IsOfFirstOrder) {
  XpbdScenario s;
  const State<double> exact = s.end({.dt = 1e-5}, "rk4");
  for (const int passes : {1, 3}) {
    const double coarse = s.distance(s.end({.dt = 1e-4, .iterations = passes}), exact),
                 fine = s.distance(s.end({.dt = 5e-5, .iterations = passes}), exact);
    EXPECT_NEAR(std::log2(coarse / fine), 1, 0.1) << passes;
  }
}

/// Positions after 0.1 s in steps of 1e-5 s, 5,000 times shorter than the explicit limit, in one precision.
template <class Real>
std::vector<Vec3> after_tiny_steps(const Body& body) {
  SpringSystem<Real> system(body, {.gravity = Vec3(0, 0, -9.81)}, {.threads = 1});
  State<Real> state = system.rest_state();
  testing::randomise(body, state, 0.1, 0.5, 7);
  Work work;
  EXPECT_EQ(find_integrator("xpbd").make<Real>({.dt = 1e-5})->advance(system, state, 0.1, work), Status::ok);
  std::vector<Vec3> positions;
  for (const std::ptrdiff_t site : body.sites()) positions.push_back(state.x.at(site));
  return positions;
}

// x - x_n of such steps has few digits left in single precision; displacements of the step, which projections
// work on, have all of theirs.
TEST(Xpbd, SinglePrecisionBearsTinySteps) {
  const Body body(testing::test_config(VoxelGrid::box(5, 4, 6)));
  const std::vector<Vec3> single = after_tiny_steps<float>(body), dbl = after_tiny_steps<double>(body);
  double largest = 0, moved = 0;
  for (std::size_t p = 0; p < single.size(); ++p) {
    largest = std::max(largest, (single[p] - dbl[p]).norm());
    moved = std::max(moved, (dbl[p] - body.rest_position(body.sites()[p])).norm());
  }
  EXPECT_GT(moved, 0.02);
  EXPECT_LT(largest, 5e-3 * moved) << largest << " of " << moved;
}

TEST(Xpbd, IsStableAtAnyStep) {
  XpbdScenario s;
  for (const double dt : {0.01, 0.1, 1.0}) {
    const State<double> end = s.end({.dt = dt}, "xpbd", 50 * dt);
    Vec3 middle = Vec3::Zero();
    for (const std::ptrdiff_t site : s.body.sites())
      middle += s.body.mass(site) / s.body.total_mass() * end.x.at(site);
    for (const std::ptrdiff_t site : s.body.sites()) EXPECT_LT((end.x.at(site) - middle).norm(), 3);
  }
}

/// Expects that small steps of xpbd end within a hundredth of the way that semi-implicit Euler goes, and that
/// this is at least `way` [m].
void expect_like_semi_implicit_euler(System<double>& system, const State<double>& start, double way) {
  const auto end = [&](const char* method) {
    State<double> state = start;
    Work work;
    EXPECT_EQ(find_integrator(method).make<double>({.dt = 1e-5})->advance(system, state, 0.1, work),
              Status::ok);
    return state;
  };
  const State<double> a = end("xpbd"), b = end("semi_implicit_euler");
  double largest = 0, moved = 0;
  for (const std::ptrdiff_t site : system.particles()) {
    largest = std::max(largest, (a.x.at(site) - b.x.at(site)).norm());
    moved = std::max(moved, (b.x.at(site) - start.x.at(site)).norm());
  }
  EXPECT_GT(moved, way);
  EXPECT_LT(largest, 0.01 * moved);
}

TEST(Xpbd, FollowsHoldsLoadsAndPenaltiesLikeSemiImplicitEuler) {
  const Body body(testing::test_config(VoxelGrid::box(2, 2, 3)));
  const Vec3 low = body.config().origin, high = low + Vec3(0.4, 0.4, 0.6);
  const Environment environment{
      .gravity = Vec3(0, 0, -1),
      .holds = {{.box = {{low[0], low[1], high[2]}, high}, .velocity = Vec3(0.1, 0, 0)}},
      .loads = {{.box = {low, {high[0], high[1], low[2]}}, .force = Vec3(0, 3, 0)}},
      .planes = {{.point = low - Vec3(0, 0, 0.001), .contact = ContactLaw::penalty}}};
  SpringSystem<double> system(body, environment, {.threads = 1});
  expect_like_semi_implicit_euler(system, system.rest_state(), 1e-3);
}

TEST(Xpbd, FollowsAWrapperLikeSemiImplicitEuler) {
  const Body body(testing::test_config(VoxelGrid::box(2, 2, 3)));
  SpringSystem<double> system(body, {}, {.threads = 1});
  TetheredSystem<double> tethered(system);
  const std::ptrdiff_t corner = body.sites().back();
  tethered.tie(Tether{.site = corner,
                      .anchor = body.rest_position(corner) + Vec3(0.1, 0.05, 0),
                      .stiffness = 50,
                      .damping = 0.1});
  expect_like_semi_implicit_euler(tethered, system.rest_state(), 1e-2);
}

/// The message of the error that a body causes.
std::string refusal(const BodyConfig& config) {
  const Body body(config);
  SpringSystem<double> system(body, {}, {.threads = 1});
  State<double> state = system.rest_state();
  Work work;
  try {
    find_integrator("xpbd").make<double>({.dt = 1e-3})->advance(system, state, 0.1, work);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Xpbd, RefusesWhatHasNoConstraint) {
  BodyConfig config = testing::test_config(VoxelGrid::box(2, 2, 2));
  EXPECT_EQ(refusal(config), "");
  config.springs.volume = -1;
  EXPECT_NE(refusal(config).find("negative"), std::string::npos);
  config.springs.volume = 1;
  config.fold_guard = 20;
  EXPECT_NE(refusal(config).find("fold_guard"), std::string::npos);
}

}  // namespace
}  // namespace mss

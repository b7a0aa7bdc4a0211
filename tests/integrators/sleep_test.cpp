// Sleep: what rests keeps its position and no cells are computed, what is disturbed wakes, and no particle
// ends further from where it would be without sleep than the bound.
#include <gtest/gtest.h>

#include <cstring>

#include "core/environment/tethered_system.hpp"
#include "core/springs/spring_system.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "integrators/integrator.hpp"

namespace mss {
namespace {

constexpr double bound = 1e-3, after = 0.2;

/// A soft column of 2 x 2 cells of 0.1 m, and so many on top of each other.
BodyConfig column(int cells) {
  BodyConfig config;
  config.voxels = VoxelGrid::box(2, 2, cells);
  config.cell_size = 0.1;
  config.density = 500;
  config.fill({.young = 1e5, .poisson = 0.3}, 0.5);
  config.damping = {.law = Damping::Law::ratio, .zeta = 1};
  return config;
}

Environment table(ContactLaw contact) {
  return {.gravity = {0, 0, -9.81}, .planes = {{.contact = contact, .friction = 0.5}}};
}

/// Explicit methods of fixed step that have a safe one.
std::vector<std::string> sleeping_methods() {
  std::vector<std::string> names;
  for (const IntegratorInfo& method : integrators())
    if (!method.implicit && !method.springs_only && method.stepping == Stepping::fixed &&
        !(method.limit && method.limit(1, 0) == 0))
      names.push_back(method.name);
  return names;
}

/// A system with its method and its state.
template <class Real>
struct Driven {
  Driven(const Body& body, const Environment& environment, const std::string& method, const SleepRule& rule,
         int threads = 1)
      : system(body, environment, Execution{.threads = threads, .sleep = rule}), state(system.rest_state()) {
    const IntegratorInfo& info = find_integrator(method);
    integrator = info.make<Real>({.dt = safe_share * stable_step(info, system.spectral_bound())});
  }
  void until(double t) { ASSERT_EQ(integrator->advance(system, state, t, work), Status::ok); }
  /// A strike on all particles of the top plane.
  void strike(const Vec3& velocity) {
    const Body& body = system.body();
    const Vec3 top = body.rest_position(body.sites().back());
    for (const std::ptrdiff_t site : body.select({-9, -9, top[2]}, {9, 9, top[2]}))
      state.v.set(site, velocity);
    integrator->reset();
    system.wake_moving(state);
  }

  SpringSystem<Real> system;
  State<Real> state;
  std::unique_ptr<Integrator<Real>> integrator;
  Work work;
};

template <class Real>
double largest_deviation(const Driven<Real>& a, const Driven<Real>& b) {
  double most = 0;
  for (const std::ptrdiff_t site : a.system.particles())
    most = std::max(most, (a.state.x.at(site) - b.state.x.at(site)).norm());
  return most;
}

template <class Real>
double fastest(const Driven<Real>& run) {
  double most = 0;
  for (const std::ptrdiff_t site : run.system.particles()) most = std::max(most, run.state.v.at(site).norm());
  return most;
}

TEST(Sleep, IsOffByDefault) {
  const Body body(column(5));
  SpringSystem<double> system(body, table(ContactLaw::impulse));
  EXPECT_FALSE(system.events()->sleeps());
  EXPECT_FALSE(system.all_asleep());
}

class Sleeping : public ::testing::TestWithParam<ContactLaw> {};

/// A column falls asleep on a table, is struck, and comes to rest again.
TEST_P(Sleeping, EndsWithinTheBoundUnderEveryMethod) {
  const Body body(column(5));
  for (const std::string& method : sleeping_methods()) {
    SCOPED_TRACE(method);
    Driven<double> run(body, table(GetParam()), method, {bound, after}),
        twin(body, table(GetParam()), method, {});
    run.until(2);
    twin.until(2);
    EXPECT_TRUE(run.system.all_asleep());
    EXPECT_EQ(fastest(run), 0);
    EXPECT_LT(largest_deviation(run, twin), bound);
    const State<double> asleep = run.state;
    const auto evaluations = run.work.force_evaluations;
    run.until(2.1);
    twin.until(2.1);
    EXPECT_TRUE((run.state.x.array() == asleep.x.array()).all());
    EXPECT_NEAR(run.state.t, 2.1, 0.01);
    EXPECT_EQ(run.work.force_evaluations, evaluations);
    run.strike({0, 0, -2});
    twin.strike({0, 0, -2});
    EXPECT_FALSE(run.system.all_asleep());
    run.until(2.15);
    twin.until(2.15);
    EXPECT_EQ(run.system.share_asleep(), 0);
    EXPECT_GT(largest_deviation(twin, Driven<double>(body, {}, method, {})), 5 * bound);
    EXPECT_LT(largest_deviation(run, twin), bound);
    run.until(5);
    twin.until(5);
    EXPECT_TRUE(run.system.all_asleep());
    EXPECT_LT(largest_deviation(run, twin), bound);
  }
}

INSTANTIATE_TEST_SUITE_P(Contact, Sleeping, ::testing::Values(ContactLaw::impulse, ContactLaw::penalty),
                         [](const auto& contact) {
                           return std::string(contact.param == ContactLaw::impulse ? "impulse" : "penalty");
                         });

/// Shaken at its foot for a while, a column wakes from below and sleeps again.
TEST(Sleep, IsEndedByHoldsThatMove) {
  const Body body(column(12));
  const Turn turn{.axis = {0, 0, 1}, .centre = {0.1, 0.1, 0}, .rate = 0.002, .until = 3};
  const Environment slow{
      .holds = {{.box = {{0, 0, 0}, {9, 9, 0}}, .turn = turn}, {.box = {{0, 0, 1.2}, {9, 9, 1.2}}}}};
  Driven<double> run(body, slow, "semi_implicit_euler", {bound, after});
  run.until(1);
  EXPECT_GT(run.system.share_asleep(), 0.5) << "most of it";
  EXPECT_FALSE(run.system.all_asleep()) << "a hold moves";
  run.until(4);
  EXPECT_TRUE(run.system.all_asleep()) << "none does any more";
}

template <class Real>
void expect_same_bits() {
  const Body body(column(12));
  std::vector<std::unique_ptr<Driven<Real>>> runs;
  for (const int threads : {1, 2, 3, 5}) {
    runs.push_back(std::make_unique<Driven<Real>>(body, table(ContactLaw::impulse), "velocity_verlet",
                                                  SleepRule{bound, after}, threads));
    runs.back()->until(3);
    runs.back()->strike({0.3, 0.2, 0});
    double least = 1, most = runs.back()->system.share_asleep();
    for (double t = 3; t < 4; t += 0.01) {
      runs.back()->until(t);
      least = std::min(least, runs.back()->system.share_asleep());
      most = std::max(most, runs.back()->system.share_asleep());
    }
    EXPECT_LT(least, 0.5);
    EXPECT_GT(most, 0.5);
    const State<Real>&a = runs.front()->state, &b = runs.back()->state;
    EXPECT_EQ(std::memcmp(a.x.axis(0), b.x.axis(0), std::size_t(a.x.size()) * sizeof(Real)), 0) << threads;
    EXPECT_EQ(std::memcmp(a.v.axis(0), b.v.axis(0), std::size_t(a.v.size()) * sizeof(Real)), 0) << threads;
  }
}

TEST(Sleep, IsTheSameBitsForAnyNumberOfThreads) {
  expect_same_bits<double>();
  expect_same_bits<float>();
}

/// While a wave runs through it only part of a long column is awake: the rest does not move.
TEST(Sleep, OfOnePartLeavesTheOtherAwake) {
  const Body body(column(60));
  const Environment foot{.holds = {{.box = {{0, 0, 0}, {9, 9, 0}}}}};
  Driven<double> run(body, foot, "semi_implicit_euler", {bound, after}),
      twin(body, foot, "semi_implicit_euler", {});
  run.until(0.3);
  ASSERT_TRUE(run.system.all_asleep());
  twin.until(0.3);
  run.strike({0, 0, -1});
  twin.strike({0, 0, -1});
  run.until(0.45);
  twin.until(0.45);
  EXPECT_GT(run.system.share_asleep(), 0.2);
  EXPECT_LT(run.system.share_asleep(), 0.9);
  EXPECT_LT(largest_deviation(run, twin), bound);
  const std::ptrdiff_t plane = body.lattice().plane;
  EXPECT_EQ(run.state.v.at(plane * 2), Vec3::Zero());
}

TEST(Sleep, IsOffWhileAParticleIsTied) {
  const Body body(column(5));
  Driven<double> run(body, table(ContactLaw::impulse), "semi_implicit_euler", {bound, after});
  run.until(1.5);
  ASSERT_TRUE(run.system.all_asleep());
  TetheredSystem<double> tethered(run.system);
  const std::ptrdiff_t site = body.sites().back();
  Tether tether = stable_tether(body.mass(site), run.system.spectral_bound(), site);
  tether.anchor = run.state.x.at(site);
  tethered.tie(tether);
  run.system.wake_all();
  run.integrator->reset();
  ASSERT_EQ(run.integrator->advance(tethered, run.state, 3, run.work), Status::ok);
  EXPECT_EQ(run.system.share_asleep(), 0);
  tethered.tie({});
  ASSERT_EQ(run.integrator->advance(tethered, run.state, 4, run.work), Status::ok);
  EXPECT_TRUE(run.system.all_asleep());
}

}  // namespace
}  // namespace mss

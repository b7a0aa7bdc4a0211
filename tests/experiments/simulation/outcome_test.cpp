// Outcomes of runs: energy that nothing supplies is found, and only that.
#include "experiments/simulation/outcome.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/springs/spring_system.hpp"
#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/disturbance.hpp"
#include "integrators/analysis/modes.hpp"

namespace mss {
namespace {

/// An undamped cube in its fastest vibration alone.
struct Vibration {
  explicit Vibration(const std::string& integrator)
      : method(find_integrator(integrator)),
        body(unit_cube({.young = 1e4, .poisson = 0.3}, 1000, 2, 0)),
        system(body, {}, {.threads = 1}),
        state(system.rest_state()) {
    Work work;
    const Mode fastest = fastest_mode(system, state, work).modes.front();
    omega = fastest.omega;
    const double extent = fastest.shape.array().abs().maxCoeff();
    state.x.array() += 1e-6 / extent * fastest.shape.array();
  }
  /// Its outcome after so many steps of dt omega = `step`, and the largest energy over the initial one.
  Outcome outcome(double step, long steps) {
    const double dt = step / omega;
    const auto integrator = method.make<double>({.dt = dt});
    SampledRun run(system, state, velocity_lag(method, dt));
    Work work;
    const Outcome outcome = run.run(
        steps, [&](long sample) { return integrator->advance(system, state, double(sample) * dt, work); });
    largest = run.extremes().max_energy / run.extremes().initial_energy;
    mean = run.mean_energy() / run.extremes().initial_energy;
    return outcome;
  }
  const IntegratorInfo& method;
  Body body;
  SpringSystem<double> system;
  State<double> state;
  double omega = 0, largest = 0, mean = 0;
};

// Each step of explicit Euler multiplies the energy of a vibration by 1 + w^2 dt^2.
TEST(Outcome, IsAGainAboveFivePercent) {
  for (const long steps : {4L, 6L}) {
    Vibration vibration("explicit_euler");
    const Outcome outcome = vibration.outcome(0.1, steps);
    EXPECT_NEAR(vibration.largest, std::pow(1.01, double(steps)), 1e-4);
    EXPECT_EQ(outcome, steps == 4 ? Outcome::stable : Outcome::gains_energy);
  }
  Vibration vibration("explicit_euler");
  EXPECT_EQ(vibration.outcome(0.1, 1000), Outcome::blows_up);  // 1.01^232 = 10
}

// Leapfrog conserves v^2 + (1 - a^2) w^2 x^2, a = w dt / 2, with v and x at one time.
TEST(Outcome, TakesEnergyAtOneTime) {
  constexpr double a = 0.45;
  Vibration leapfrog("velocity_verlet");
  EXPECT_EQ(leapfrog.outcome(2 * a, 200), Outcome::stable);
  EXPECT_NEAR(leapfrog.largest, 1, 1e-4);
  // Begins with the velocity of half a step before the start, and has 1 / (1 - a^2) times the energy.
  for (const char* name : {"semi_implicit_euler", "verlet"}) {
    Vibration lagging(name);
    EXPECT_EQ(velocity_lag(lagging.method, 0.2), 0.1);
    lagging.outcome(2 * a, 200);
    EXPECT_NEAR(lagging.largest, 1 / (1 - a * a), 0.01) << name;
    EXPECT_NEAR(lagging.mean, (1 - a * a / 2) / (1 - a * a), 0.01) << name;
  }
  EXPECT_EQ(velocity_lag(find_integrator("implicit_midpoint"), 0.2), 0);
  EXPECT_EQ(velocity_lag(find_integrator("backward_euler"), 0.2), 0);
}

TEST(Outcome, KeepsTheLeastJacobianAndTheLast) {
  Vibration vibration("velocity_verlet");
  vibration.state = vibration.system.rest_state();
  for (const std::ptrdiff_t site : vibration.body.sites())
    vibration.state.x.axis(0)[site] *= 1.2;  // is least when it has rebounded
  SampledRun run(vibration.system, vibration.state);
  const auto integrator = vibration.method.make<double>({.dt = 0.1 / vibration.omega});
  Work work;
  double least = 1e9, last = 0;
  run.run(
      400,
      [&](long sample) {
        return integrator->advance(vibration.system, vibration.state, double(sample) * 0.1 / vibration.omega,
                                   work);
      },
      [&](const Measures& m) {
        least = std::min(least, m.min_jacobian);
        last = m.min_jacobian;
      });
  EXPECT_EQ(run.extremes().min_jacobian, least);
  EXPECT_EQ(run.extremes().final_jacobian, last);
  EXPECT_LT(least, last);
  EXPECT_LT(least, 0.95);
}

TEST(Outcome, IsReadAsItIsWritten) {
  EXPECT_EQ(outcome_labels().size(), 8U);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(read_outcome(to_string(Outcome(i))), Outcome(i));
  EXPECT_EQ(to_string(Outcome::gains_energy), "gains_energy");
}

}  // namespace
}  // namespace mss

// The examples of CONTRIBUTING.md, compiled as they are printed there.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.hpp"
#include "core/springs/spring_system.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/simulation/cubes.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "tests/read_back.hpp"

namespace mss {

IntegratorInfo leapfrog();
IntegratorInfo heun();

namespace studies::safe_step {
ExperimentInfo experiment();
}

namespace {

/// The largest distance of a particle, after a while, from where RK4 puts it with a far smaller step.
double error_of(const IntegratorInfo& method, double dt) {
  const Body body(unit_cube({.young = 1e4, .poisson = 0.3}, 1000, 2, 0));
  constexpr double duration = 0.5;
  const auto final_positions = [&](const IntegratorInfo& by, double step) {
    SpringSystem<double> system(body, {});
    State<double> state = system.rest_state();
    for (const std::ptrdiff_t site : system.particles()) state.x.set(site, 1.05 * state.x.at(site));
    Work work;
    EXPECT_EQ(by.make<double>({.dt = step})->advance(system, state, duration, work), Status::ok);
    EXPECT_NEAR(state.t, duration, 1e-12);
    return state.x;
  };
  return (final_positions(method, dt).array() - final_positions(find_integrator("rk4"), 1e-3).array())
      .abs()
      .maxCoeff();
}

TEST(Contributing, TheLeapfrogIsOfSecondOrder) {
  EXPECT_EQ(leapfrog().name, "leapfrog");
  EXPECT_NEAR(std::log2(error_of(leapfrog(), 0.0025) / error_of(leapfrog(), 0.00125)), 2, 0.05);
}

TEST(Contributing, HeunsMethodIsOfSecondOrderAndUnstableWithoutDamping) {
  EXPECT_NEAR(std::log2(error_of(heun(), 0.0025) / error_of(heun(), 0.00125)), 2, 0.05);
  EXPECT_EQ(heun().limit(3, 0), 0);
  EXPECT_NEAR(heun().limit(0, 5), 2.0 / 5, 1e-9);  // |R| = 1 at z = -2
  EXPECT_THROW(stable_step(heun(), {.omega = 3, .damping = 0}), InputError);
}

TEST(Contributing, TheStudyMeasuresAndDraws) {
  const ExperimentInfo info = studies::safe_step::experiment();
  Progress progress;
  const ExperimentResult result = info.run({.quick = true}, progress);
  const Table& rows = find_table(result.tables, info.name);
  ASSERT_EQ(rows.size(), 3U);
  // The bound on the frequency grows as the number of cells, where damping is weak.
  EXPECT_NEAR(rows.number(1, "dt") / rows.number(2, "dt"), 2, 0.05);
  expect_same_drawings(info, result.tables);
  EXPECT_EQ(info.baseline.table({}, progress).size(), 2U);
}

}  // namespace
}  // namespace mss

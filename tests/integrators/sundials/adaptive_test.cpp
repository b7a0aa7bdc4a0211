// SUNDIALS' methods on a body: their work, and how they fail.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "core/body/spectral_bound.hpp"
#include "integrators/integrator.hpp"
#include "integrators/linear/linear_solver.hpp"
#include "tests/oscillator.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

struct AdaptiveScenario {
  Body body{testing::test_config(VoxelGrid::box(3, 3, 3))};
  SpringSystem<double> system{body, {.gravity = Vec3(0, 0, -9.81)}};
  State<double> state = system.rest_state();
  Work work;
  AdaptiveScenario() { testing::randomise(body, state, 0.1, 0.5, 3); }
  Status run(const std::string& method, IntegratorOptions options, double t_end = 0.1) {
    options.dt = 0;
    options.length_scale = body.config().cell_size;
    options.speed_scale = options.length_scale * spectral_bound(body).omega / 10;
    return find_integrator(method).make<double>(options)->advance(system, state, t_end, work);
  }
};

TEST(Bdf, EndsAlikeWithEveryLinearSolver) {
  AdaptiveScenario reference;
  ASSERT_EQ(reference.run("cvode_adams", {.tolerance = 1e-10}), Status::ok);
  const auto check = [&](const std::string& method, const IntegratorOptions& options) {
    AdaptiveScenario s;
    ASSERT_EQ(s.run(method, options), Status::ok);
    EXPECT_LT((s.state.x.array() - reference.state.x.array()).abs().maxCoeff(), 1e-4 * 0.2);
    // A wrong Jacobian would need many more iterations.
    EXPECT_LT(double(s.work.force_evaluations), 2.5 * double(s.work.steps));
    EXPECT_GT(s.work.jacobians, 0);
    EXPECT_GE(s.work.linear_solves, s.work.steps);
  };
  for (const LinearSolverInfo& linear : linear_solvers()) {
    SCOPED_TRACE(linear.name);
    check("cvode_bdf", {.linear_solver = linear.name, .tolerance = 1e-6});
  }
  check("cvode_bdf_klu", {.tolerance = 1e-6});
}

/// A hundredth of the tolerance takes the steps of the order of the estimate, one less than the method's,
/// which it does not where a step begins with other rates than those of its state.
TEST(ErkPair, NeedsAsManyForcesAsItsOrderSays) {
  const auto run = [](const char* method, double tolerance) {
    testing::Oscillator system(2, 0.6);
    State<double> state = system.start(0.8, 0.5);
    Work work;
    EXPECT_EQ(find_integrator(method)
                  .make<double>({.dt = 0, .tolerance = tolerance})
                  ->advance(system, state, 30, work),
              Status::ok);
    return double(work.force_evaluations);
  };
  for (const auto& [method, order] :
       {std::pair{"arkode_erk", 5}, {"arkode_verner", 6}, {"arkode_fehlberg", 8}})
    EXPECT_LT(run(method, 1e-10) / run(method, 1e-6), 1.1 * std::pow(1e4, 1.0 / order)) << method;
}

class Adaptive : public ::testing::TestWithParam<std::string> {};

TEST_P(Adaptive, SaysWhenItsStepsDoNotSuffice) {
  AdaptiveScenario s;
  EXPECT_EQ(s.run(GetParam(), {.tolerance = 1e-8, .most_steps = 7}), Status::step_limit);
  EXPECT_EQ(s.work.steps, 7);
  EXPECT_GT(s.state.t, 0);
  EXPECT_LT(s.state.t, 0.1);
}

TEST_P(Adaptive, SaysWhenForcesAreNotFinite) {
  AdaptiveScenario s;
  s.state.x.axis(0)[s.body.sites()[5]] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(s.run(GetParam(), {}), Status::non_finite);
}

INSTANTIATE_TEST_SUITE_P(Registry, Adaptive, ::testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const IntegratorInfo& method : integrators())
                             if (method.stepping == Stepping::adaptive) names.push_back(method.name);
                           return names;
                         }()),
                         [](const auto& p) { return p.param; });

}  // namespace
}  // namespace mss

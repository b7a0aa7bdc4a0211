// Newton's method on stages it can and cannot solve: failure is a status, never a silent wrong state.
#include <gtest/gtest.h>

#include "integrators/nonlinear/implicit_stage.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

struct NewtonScenario {
  Body body{testing::test_config(VoxelGrid::box(3, 3, 3))};
  SpringSystem<double> system{body, {.gravity = Vec3(0, 0, -9.81)}};
  State<double> state = system.rest_state();
  Work work;
  /// Status after `steps` steps of a method.
  Status run(const char* method, double dt, const IntegratorOptions& options, int steps = 1) {
    IntegratorOptions with_step = options;
    with_step.dt = dt;
    return find_integrator(method).make<double>(with_step)->advance(system, state, steps * dt, work);
  }
};

/// Largest |M (v - v0) - dt f| of one stage, over the weight.
double defect(NewtonScenario& s, const State<double>& before, double dt) {
  Field<double> f(s.system.size());
  s.system.force(s.state.t, s.state.x, s.state.v, f);
  double largest = 0;
  for (const std::ptrdiff_t site : s.body.sites())
    largest = std::max(
        largest, (s.body.mass(site) * (s.state.v.at(site) - before.v.at(site)) - dt * f.at(site)).norm());
  return largest / (s.body.total_mass() * 9.81 * dt);
}

TEST(Newton, SolvesStronglyDeformedStages) {
  for (const Tangent kind : {Tangent::elastic, Tangent::projected}) {
    NewtonScenario s;
    testing::randomise(s.body, s.state, 0.3, 0.5, 3);
    const State<double> before = s.state;
    ASSERT_EQ(s.run("backward_euler", 0.01, {.tangent = kind}), Status::ok);
    EXPECT_LT(defect(s, before, 0.01), 1e-7);
    EXPECT_GT(s.work.factorisations, 1);
  }
}

TEST(Newton, SolvesStagesWithACoefficientOfTheirOwnForPositions) {
  NewtonScenario s;
  testing::randomise(s.body, s.state, 0.1, 0.1, 3);
  const State<double> before = s.state;
  const ImplicitStage stage{.gamma = 0.02, .gamma_x = 0.005, .x_base = &before.x, .v_base = &before.v};
  ASSERT_EQ(Newton({}).solve(s.system, stage, s.state, s.work), Status::ok);
  EXPECT_LT(defect(s, before, stage.gamma), 1e-9);
  EXPECT_LT((s.state.x.array() - before.x.array() - stage.gamma_x * s.state.v.array()).abs().maxCoeff(),
            1e-14);
  EXPECT_LE(s.work.linear_solves, 8);  // quadratic convergence: the matrix is that of this stage
}

TEST(Newton, ElasticTangentsNeedFewerIterations) {
  NewtonScenario elastic, projected;
  for (NewtonScenario* s : {&elastic, &projected}) testing::randomise(s->body, s->state, 0.1, 0.1, 3);
  ASSERT_EQ(elastic.run("implicit_midpoint", 0.02, {.tangent = Tangent::elastic}, 5), Status::ok);
  ASSERT_EQ(projected.run("implicit_midpoint", 0.02, {.tangent = Tangent::projected}, 5), Status::ok);
  EXPECT_LT(elastic.work.factorisations, projected.work.factorisations);
}

TEST(Newton, AllLinearSolversGiveTheSameStep) {
  std::vector<State<double>> ends;
  for (const char* solver : {"cholmod", "pcg", "matrix_free"}) {
    NewtonScenario s;
    testing::randomise(s.body, s.state, 0.1, 0.1, 3);
    ASSERT_EQ(s.run("tr_bdf2", 0.01, {.linear_solver = solver, .tangent = Tangent::projected}, 3),
              Status::ok);
    ends.push_back(s.state);
  }
  for (const auto& end : ends) EXPECT_LT((end.x.array() - ends.front().x.array()).abs().maxCoeff(), 1e-9);
}

// Overdamped and spinning fast: symmetric tangents omit the rotation of dampers, which dominates here.
TEST(Newton, SaysWhenItStalls) {
  BodyConfig config = testing::test_config(VoxelGrid::box(3, 3, 3));
  config.damping.zeta = 20;
  const Body body(config);
  SpringSystem<double> system(body, {});
  State<double> state = system.rest_state();
  for (const std::ptrdiff_t site : body.sites()) {
    const Vec3 arm = state.x.at(site) - body.config().origin;
    state.v.set(site, 300 * Vec3(-arm[1], arm[0], 0));
  }
  Work work;
  EXPECT_EQ(
      find_integrator("implicit_midpoint").make<double>({.dt = 0.05})->advance(system, state, 0.05, work),
      Status::newton_stalled);
  EXPECT_EQ(work.steps, 0);
}

}  // namespace
}  // namespace mss

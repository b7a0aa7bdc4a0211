// Linear solvers: each solves the same systems, or returns a status of failure.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>

#include "integrators/linear/linear_solver.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

/// A deformed body, held at its bottom; the tangent of a step of backward Euler.
struct Problem {
  explicit Problem(double scale = 1) {
    testing::randomise(body, state, 0.1, 0.5, 11);
    for (const std::ptrdiff_t site : body.sites()) {
      state.x.set(site, scale * state.x.at(site));
      rhs.set(site, Vec3(double(site % 7) - 3, double(site % 5) - 2, double(site % 3) - 1));
    }
  }
  static BodyConfig config() { return testing::test_config(VoxelGrid::box(4, 3, 5)); }
  static Environment environment() {
    const Vec3 low = config().origin;
    return {.holds = {{.box = {low, low + Vec3(0.8, 0.6, 0)}}}};
  }
  Status solve(const char* solver, double tolerance = 1e-10) {
    const auto linear = find_linear_solver(solver).make(tolerance);
    const Status status = linear->prepare(system, 0, state.x, state.v, sum, work);
    return status == Status::ok ? linear->solve(rhs, solution, work) : status;
  }
  /// |A y - r| over |r|, of what is not held.
  double defect() {
    Field<double> image(system.size()), r = rhs;
    system.tangents()->product(0, state.x, state.v, sum, solution, image);
    double error = 0, norm = 0;
    for (const auto [site, axis] : system.tangents()->unknowns()) {
      error += std::pow(image.axis(axis)[site] - rhs.axis(axis)[site], 2);
      norm += std::pow(rhs.axis(axis)[site], 2);
    }
    return std::sqrt(error / norm);
  }

  Body body{config()};
  SpringSystem<double> system{body, environment()};
  State<double> state = system.rest_state();
  Field<double> rhs{system.size()}, solution{system.size()};
  TangentCoefficients sum{.mass = 1, .damping = 0.02, .stiffness = 4e-4, .kind = Tangent::elastic};
  Work work;
};

class Linear : public ::testing::TestWithParam<std::string> {};

TEST_P(Linear, Solves) {
  Problem p;
  ASSERT_EQ(p.solve(GetParam().c_str()), Status::ok);
  EXPECT_LT(p.defect(), 2e-10);
  EXPECT_EQ(p.work.linear_solves, 1);
  EXPECT_EQ(p.work.jacobians, 1);
  for (const std::ptrdiff_t site :
       p.body.select(p.environment().holds[0].box.lower, p.environment().holds[0].box.upper))
    EXPECT_EQ(p.solution.at(site), Vec3::Zero());
}

TEST_P(Linear, SaysWhenATangentIsIndefinite) {
  Problem p(0.4);  // springs compressed to less than half their length
  p.sum = {.mass = 1e-3, .damping = 0, .stiffness = 1, .kind = Tangent::elastic};
  EXPECT_EQ(p.solve(GetParam().c_str()), Status::not_positive_definite);
}

TEST_P(Linear, TakesTheProjectedTangentInstead) {
  Problem p(0.4);
  p.sum = {.mass = 1e-3, .damping = 0, .stiffness = 1, .kind = Tangent::elastic};
  const auto linear = find_linear_solver(GetParam()).make(1e-10);
  ASSERT_EQ(solve_tangent(*linear, p.system, 0, p.state.x, p.state.v, p.sum, p.rhs, p.solution, p.work),
            Status::ok);
  p.sum.kind = Tangent::projected;
  EXPECT_LT(p.defect(), 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Registry, Linear, ::testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const LinearSolverInfo& solver : linear_solvers())
                             names.push_back(solver.name);
                           return names;
                         }()),
                         [](const auto& p) { return p.param; });

// The matrix and the sweep multiply alike, so conjugate gradients take the same path.
TEST(ConjugateGradients, AreTheSameWithAndWithoutTheMatrix) {
  for (const double tolerance : {1e-3, 1e-6, 1e-10}) {
    Problem with, without;
    ASSERT_EQ(with.solve("pcg", tolerance), Status::ok);
    ASSERT_EQ(without.solve("matrix_free", tolerance), Status::ok);
    EXPECT_EQ(with.work.products, without.work.products);
    EXPECT_LT((with.solution.array() - without.solution.array()).abs().maxCoeff(),
              1e-12 * with.solution.array().abs().maxCoeff());
  }
}

// Big enough for sums over several ranges of sites.
TEST(ConjugateGradients, GiveTheSameBitsForAnyNumberOfThreads) {
  const Body body(testing::test_config(VoxelGrid::box(12, 12, 12)));
  const auto solve = [&](const char* name, int threads) {
    SpringSystem<double> system(body, {}, {.threads = threads});
    State<double> state = system.rest_state();
    testing::randomise(body, state, 0.1, 0.5, 5);
    Field<double> rhs(system.size()), solution(system.size());
    system.force(0, state.x, state.v, rhs);
    const auto solver = find_linear_solver(name).make(1e-8);
    Work work;
    const TangentCoefficients sum{.mass = 1, .damping = 0.01, .stiffness = 1e-4, .kind = Tangent::projected};
    EXPECT_EQ(solver->prepare(system, 0, state.x, state.v, sum, work), Status::ok);
    EXPECT_EQ(solver->solve(rhs, solution, work), Status::ok);
    EXPECT_GT(work.products, 5);
    return solution;
  };
  for (const char* name : {"matrix_free", "separable"}) {
    const Field<double> one = solve(name, 1);
    for (const int threads : {2, 3, 5, 8}) {
      const Field<double> other = solve(name, threads);
      EXPECT_EQ(std::memcmp(one.axis(0), other.axis(0), std::size_t(one.size()) * sizeof(double)), 0)
          << name << " " << threads;
    }
  }
}

// The libraries below would start as many threads as there are cores by default.
TEST(LinearSolvers, StartNoThreadsOfTheirOwn) {
  const auto threads = [] {
    const std::filesystem::directory_iterator tasks("/proc/self/task");
    return std::distance(begin(tasks), end(tasks));
  };
  const Body body(testing::test_config(VoxelGrid::box(12, 12, 12)));
  SpringSystem<double> system(body, {}, {.threads = 1});
  State<double> state = system.rest_state();
  testing::randomise(body, state, 0.1, 0.5, 5);
  const auto before = threads();
  for (const LinearSolverInfo& info : linear_solvers()) {
    Work work;
    IntegratorOptions options{.dt = 0.01, .linear_solver = info.name};
    EXPECT_EQ(find_integrator("backward_euler_linear")
                  .make<double>(options)
                  ->advance(system, state, state.t + 0.01, work),
              Status::ok);
    EXPECT_EQ(threads(), before) << info.name;
  }
}

TEST(ConjugateGradients, SayWhenTheyStall) {
  for (const char* solver : {"pcg", "matrix_free"}) {
    Problem p;
    p.sum = {.mass = 1e-3, .stiffness = 1, .kind = Tangent::projected};
    EXPECT_EQ(p.solve(solver, 1e-150), Status::linear_stalled);
    EXPECT_EQ(std::size_t(p.work.products), p.system.tangents()->unknowns().size());
  }
}

}  // namespace
}  // namespace mss

// The solver against certified values, its bounds, and how it fails.
#include "experiments/fit/least_squares.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

namespace mss::fit {
namespace {

using Eigen::VectorXd;

/// A problem of a plain function, whose every evaluation costs the same.
LeastSquaresProblem problem_of(const std::vector<Target>& targets, const VectorXd& start,
                               const std::function<Evaluation(const VectorXd&)>& model) {
  const double none = std::numeric_limits<double>::infinity();
  return {.targets = targets,
          .start = start,
          .low = VectorXd::Constant(start.size(), -none),
          .high = VectorXd::Constant(start.size(), none),
          .evaluate =
              [model](const std::vector<Trial>& trials) {
                std::vector<Evaluation> found;
                for (const Trial& trial : trials) found.push_back(model(trial.u));
                return found;
              },
          .most_evaluations = 100};
}

/// Misra1a of NIST's Statistical Reference Datasets: y = b1 (1 - exp(-b2 x)).
struct Misra {
  const std::vector<double> x{77.6,  114.9, 141.1, 190.8, 239.9, 289.0, 332.8,
                              378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0};
  const std::vector<double> y{10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02,
                              44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78};
  LeastSquaresResult solve(double b1, double b2) const {
    std::vector<Target> targets;
    for (const double value : y) targets.push_back({value, 1});
    return solve_least_squares(
        problem_of(targets, Eigen::Vector2d(std::log(b1), std::log(b2)), [&](const VectorXd& u) {
          Evaluation found;
          found.values.resize(Eigen::Index(x.size()));
          for (std::size_t i = 0; i < x.size(); ++i)
            found.values[Eigen::Index(i)] = std::exp(u[0]) * -std::expm1(-std::exp(u[1]) * x[i]);
          return found;
        }));
  }
};

TEST(LeastSquares, HasNistsCertifiedValuesAndDeviations) {
  for (const auto& [b1, b2] : {std::pair(500.0, 1e-4), std::pair(250.0, 5e-4)}) {
    const LeastSquaresResult found = Misra().solve(b1, b2);
    EXPECT_EQ(found.ended, Ended::converged);
    EXPECT_NEAR(std::exp(found.u[0]), 238.94212918, 0.01 * 2.7070075241);
    EXPECT_NEAR(std::exp(found.u[1]), 5.5015643181e-4, 0.01 * 7.2668688436e-6);
    EXPECT_NEAR(found.chi2, 0.12455138894, 1e-4);
    const VectorXd error = covariance_of(found.jacobian, found.chi2).diagonal().cwiseSqrt();
    EXPECT_NEAR(error[0], 2.7070075241 / 238.94212918, 0.05 * error[0]);
    EXPECT_NEAR(error[1], 7.2668688436e-6 / 5.5015643181e-4, 0.05 * error[1]);
    EXPECT_LE(found.evaluations, 20);
  }
}

/// A frequency and a damping ratio as of a vibrating body: sqrt(E), viscosity / sqrt(E).
Evaluation power_laws(const VectorXd& u) {
  return {.values =
              Eigen::Vector3d(3 * std::exp(u[0] / 2), 0.1 * std::exp(u[1] - u[0] / 2), -2 * std::exp(-u[0]))};
}

TEST(LeastSquares, SolvesPowerLawsInOneStepAfterTheDifferences) {
  const std::vector<Target> targets{{3 * std::exp(0.5), 0.1, true},
                                    {0.1 * std::exp(-0.75 - 0.5), 0.001, true},
                                    {-2 * std::exp(-1.0), 0.01, true}};
  const LeastSquaresResult found =
      solve_least_squares(problem_of(targets, Eigen::Vector2d::Zero(), power_laws));
  EXPECT_EQ(found.ended, Ended::converged);
  EXPECT_NEAR(found.u[0], 1, 1e-6);
  EXPECT_NEAR(found.u[1], -0.75, 1e-6);
  EXPECT_EQ(found.evaluations, 1 + 2 + 1);
}

TEST(LeastSquares, StopsAtABoundWhereTheRestIsBest) {
  const std::vector<Target> targets{{4, 1}, {1, 1}};
  LeastSquaresProblem problem = problem_of(targets, Eigen::Vector2d::Zero(), [](const VectorXd& u) {
    return Evaluation{.values = Eigen::Vector2d(u[0] + u[1], u[0] - u[1])};
  });
  problem.high[0] = 2;  // without it 2.5, 1.5
  const LeastSquaresResult found = solve_least_squares(problem);
  EXPECT_EQ(found.ended, Ended::converged);
  EXPECT_EQ(found.u[0], 2);
  EXPECT_NEAR(found.u[1], 1.5, 1e-6);
  EXPECT_NEAR(found.chi2, 0.5, 1e-6);
}

TEST(LeastSquares, HalvesStepsThatFailAndSaysSo) {
  const LeastSquaresResult found =
      solve_least_squares(problem_of({{5, 1}, {5.2, 1}}, VectorXd::Constant(1, 0), [](const VectorXd& u) {
        if (u[0] > 1.2 && u[0] < 1.7) return Evaluation{.problem = "non_finite"};
        return Evaluation{.values = Eigen::Vector2d(3 + u[0], 3 + u[0])};
      }));
  EXPECT_EQ(found.ended, Ended::converged);
  EXPECT_NEAR(found.u[0], 2.1, 1e-6);
  const auto failed = [](const TriedStep& step) { return step.problem == "non_finite"; };
  EXPECT_EQ(std::count_if(found.steps.begin(), found.steps.end(), failed), 1);
}

TEST(LeastSquares, EndsWhereNoStepIsLeftOrNoEvaluation) {
  const auto wall = [](const VectorXd& u) {
    if (u[0] > 0.5) return Evaluation{.problem = "non_finite"};
    return Evaluation{.values = VectorXd::Constant(1, u[0])};
  };
  LeastSquaresProblem problem = problem_of({{5, 1}}, VectorXd::Constant(1, 0), wall);
  const LeastSquaresResult stalled = solve_least_squares(problem);
  EXPECT_EQ(stalled.ended, Ended::stalled);
  EXPECT_NEAR(stalled.u[0], 0.5, 0.01);
  problem.most_evaluations = 3;
  EXPECT_EQ(solve_least_squares(problem).ended, Ended::too_many_evaluations);
}

TEST(LeastSquares, NamesCoordinatesThatAreNotDetermined) {
  const auto sum = problem_of({{1, 0.1}, {2, 0.1}, {1, 0.1}}, Eigen::Vector3d::Zero(), [](const VectorXd& u) {
    return Evaluation{.values = Eigen::Vector3d(u[0] + u[2], 2 * u[0] + 2 * u[2], u[1])};
  });
  const LeastSquaresResult together = solve_least_squares(sum);
  EXPECT_EQ(together.ended, Ended::undetermined);
  EXPECT_EQ(together.undetermined, (std::vector<int>{0, 2}));
  const auto alone = problem_of({{1, 0.1}, {2, 0.1}}, Eigen::Vector2d::Zero(), [](const VectorXd& u) {
    return Evaluation{.values = Eigen::Vector2d(u[0], u[0])};
  });
  EXPECT_EQ(solve_least_squares(alone).undetermined, (std::vector<int>{1}));
}

// Where a body rests does not depend on its viscosity, whatever the steps did.
TEST(LeastSquares, SecantsLeaveAloneWhatACoordinateDoesNotTouch) {
  LeastSquaresProblem problem =
      problem_of({{std::exp(2.0), 0.1}, {std::exp(1.0), 0.1}}, Eigen::Vector2d::Zero(), {});
  problem.evaluate = [](const std::vector<Trial>& trials) {
    std::vector<Evaluation> found;
    for (const Trial& trial : trials) {
      found.push_back(
          {.values = Eigen::Vector2d(std::exp(trial.u[0]), std::exp(trial.u[1]) + 0.1 * trial.u[0])});
      if (trial.only == 1) found.back().values[0] = std::nan("");
    }
    return found;
  };
  const LeastSquaresResult found = solve_least_squares(problem);
  EXPECT_EQ(found.ended, Ended::converged);
  EXPECT_NEAR(found.u[0], 2, 1e-4);
  EXPECT_EQ(found.jacobian(0, 1), 0);
  EXPECT_GT(std::abs(found.jacobian(1, 0)), 0);
}

}  // namespace
}  // namespace mss::fit

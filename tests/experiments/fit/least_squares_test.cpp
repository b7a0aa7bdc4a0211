// The solver against certified values, its bounds, and how it fails.
#include "experiments/fit/least_squares.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <tuple>

#include "experiments/fit/coarse_model.hpp"

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
    LeastSquaresProblem problem =
        problem_of(targets, Eigen::Vector2d(std::log(b1), std::log(b2)), [&](const VectorXd& u) {
          Evaluation found;
          found.values.resize(Eigen::Index(x.size()));
          for (std::size_t i = 0; i < x.size(); ++i)
            found.values[Eigen::Index(i)] = std::exp(u[0]) * -std::expm1(-std::exp(u[1]) * x[i]);
          return found;
        });
    problem.least_share = 0.01;
    return solve_least_squares(problem);
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

/// A beam of a standard linear solid with two weights: drops, frequencies [Hz] and damping ratios from the
/// complex modulus E (1 + r i w t / (1 + i w t)). u: logarithms of E, r, t.
VectorXd beam_of(const VectorXd& u) {
  constexpr double turn = 2 * std::numbers::pi;
  const double modulus = std::exp(u[0]), ratio = std::exp(u[1]), time = std::exp(u[2]);
  VectorXd values(6);
  for (const auto& [run, frequency, drop] : {std::tuple(0L, 7.7, 6.5e-3), std::tuple(1L, 3.36, 26e-3)}) {
    double omega = 0, real = modulus, imaginary = 0;
    for (int n = 0; n < 50; ++n) {
      omega = turn * frequency * std::sqrt(real);
      const double a = omega * time;
      real = modulus * (1 + ratio * a * a / (1 + a * a));
      imaginary = modulus * ratio * a / (1 + a * a);
    }
    values.segment(3 * run, 3) << -drop / modulus, omega / turn, imaginary / (2 * real);
  }
  return values;
}

/// A beam of one Maxwell branch, as measured ones are: numbers two percent off, up or down.
LeastSquaresProblem measured_beam_problem(int pattern) {
  VectorXd measured = beam_of(Eigen::Vector3d(std::log(0.95), std::log(0.25), std::log(0.045)));
  std::vector<Target> targets;
  for (int i = 0; i < 6; ++i) {
    measured[i] *= (pattern >> i) % 2 == 0 ? 1.02 : 0.98;
    targets.push_back({measured[i], 0.01 * std::abs(measured[i]), true});
  }
  return problem_of(targets, Eigen::Vector3d(0, std::log(0.15), std::log(0.03)),
                    [](const VectorXd& u) { return Evaluation{.values = beam_of(u)}; });
}

// The drops are runs of their own, which only the modulus changes.
TEST(LeastSquares, FitsThreeConstantsOfABeamInEightEvaluations) {
  for (int pattern = 0; pattern < 64; ++pattern) {
    LeastSquaresProblem problem = measured_beam_problem(pattern);
    problem.evaluate = [](const std::vector<Trial>& trials) {
      std::vector<Evaluation> found;
      for (const Trial& trial : trials) {
        found.push_back({.values = beam_of(trial.u)});
        if (trial.only <= 0) continue;
        found.back().values[0] = found.back().values[3] = std::nan("");
        found.back().share = 0.5;
      }
      return found;
    };
    const LeastSquaresResult found = solve_least_squares(problem);
    EXPECT_EQ(found.ended, Ended::converged);
    EXPECT_LE(found.evaluations, 8) << pattern;
    problem.least_share = 1e-3;
    const LeastSquaresResult exact = solve_least_squares(problem);
    EXPECT_EQ(exact.ended, Ended::converged);
    const VectorXd error = covariance_of(exact.jacobian, exact.chi2).diagonal().cwiseSqrt();
    EXPECT_LT(((found.u - exact.u).array() / error.array()).abs().maxCoeff(), 0.1) << pattern;
  }
}

// A twin of another stiffness, inertia and damping, from another start: the costly model's own minimum.
TEST(LeastSquares, ACoarseModelLeavesFewEvaluationsOfTheCostlyOne) {
  for (const int pattern : {0, 13, 27, 42, 63}) {
    LeastSquaresProblem problem = measured_beam_problem(pattern);
    const LeastSquaresProblem coarse =
        problem_of(problem.targets, Eigen::Vector3d(0.5, -3, -3), [](const VectorXd& u) {
          return Evaluation{
              .values =
                  (beam_of(u).array() * Eigen::Array<double, 6, 1>(0.8, 1.1, 0.9, 0.85, 1.15, 1.1)).matrix()};
        });
    const LeastSquaresResult found = solve_by_coarse_model(problem, coarse);
    EXPECT_EQ(found.ended, Ended::converged);
    EXPECT_LE(found.evaluations, 4) << pattern;
    problem.least_share = 1e-3;
    const LeastSquaresResult exact = solve_least_squares(problem);
    const VectorXd error = covariance_of(exact.jacobian, exact.chi2).diagonal().cwiseSqrt();
    EXPECT_LT(((found.u - exact.u).array() / error.array()).abs().maxCoeff(), 0.2) << pattern;
    const VectorXd of_twin = covariance_of(found.jacobian, found.chi2).diagonal().cwiseSqrt();
    EXPECT_LT((of_twin.array() / error.array() - 1).abs().maxCoeff(), 0.2) << pattern;
  }
}

TEST(LeastSquares, ACoarseModelThatFailsEndsTheFitWithItsReason) {
  const LeastSquaresProblem problem = measured_beam_problem(0);
  const auto broken = problem_of(problem.targets, problem.start,
                                 [](const VectorXd&) { return Evaluation{.problem = "non_finite"}; });
  const LeastSquaresResult found = solve_by_coarse_model(problem, broken);
  EXPECT_EQ(found.ended, Ended::failed_at_start);
  EXPECT_EQ(found.problem, "non_finite");
  EXPECT_EQ(found.evaluations, 0);
  const LeastSquaresResult of_costly = solve_by_coarse_model(broken, problem);
  EXPECT_EQ(of_costly.ended, Ended::failed_at_start);
  EXPECT_EQ(of_costly.evaluations, 1);
}

TEST(LeastSquares, ACoarseModelThatIsStoppedLeavesNothingKnown) {
  const LeastSquaresProblem coarse = measured_beam_problem(0);
  LeastSquaresProblem problem = coarse;
  problem.stopped = [] { return true; };
  const LeastSquaresResult found = solve_by_coarse_model(problem, coarse);
  EXPECT_EQ(found.ended, Ended::interrupted);
  EXPECT_EQ(found.u.size(), 3);
  EXPECT_EQ(found.values.size(), 0);
}

TEST(LeastSquares, ACoarseModelWithoutASolutionIsNoConvergence) {
  const LeastSquaresProblem problem = measured_beam_problem(0);
  LeastSquaresProblem coarse = problem;
  coarse.start = Eigen::Vector3d(2, -3, -1);
  coarse.most_evaluations = 4;
  EXPECT_EQ(solve_by_coarse_model(problem, coarse).ended, Ended::stalled);
}

// Uncertainties that are the same for all, whatever they are, and units as large.
TEST(LeastSquares, OnlyTheRatiosOfUncertaintiesMatter) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    LeastSquaresProblem problem = measured_beam_problem(13);
    for (Target& target : problem.targets) target.uncertainty *= scale;
    const LeastSquaresResult found = solve_least_squares(problem);
    EXPECT_EQ(found.ended, Ended::converged) << scale;
    EXPECT_NEAR(found.u[0], solve_least_squares(measured_beam_problem(13)).u[0], 1e-3) << scale;
  }
}

// Its slopes have the wrong sign: nothing that it proposes is better.
TEST(LeastSquares, AMisleadingCoarseModelEndsWithoutEvaluationsOrStalled) {
  const auto straight = problem_of({{5, 1}, {5.1, 1}}, VectorXd::Constant(1, 0), [](const VectorXd& u) {
    return Evaluation{.values = Eigen::Vector2d(u[0], u[0])};
  });
  const auto turned = problem_of({{5, 1}, {5.1, 1}}, VectorXd::Constant(1, 0), [](const VectorXd& u) {
    return Evaluation{.values = Eigen::Vector2d(4 - u[0], 4 - u[0])};
  });
  LeastSquaresProblem few = straight;
  few.most_evaluations = 6;
  const LeastSquaresResult found = solve_by_coarse_model(few, turned);
  EXPECT_NE(found.ended, Ended::converged);
  EXPECT_LE(found.evaluations, 6);
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

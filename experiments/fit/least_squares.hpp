#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

namespace mss::fit {

/// A measured number.
struct Target {
  double measured = 0;
  double uncertainty = 1;  ///< standard deviation, positive; of a fit only their ratios matter
  /// Between evaluations its logarithm is taken as linear in the coordinates, so that power laws are fitted
  /// in one step: frequency over modulus, damping over viscosity. The model's value must have its sign.
  bool logarithmic = false;
};

/// Where the model is wanted: at coordinates u, or as far as one of them changes it.
struct Trial {
  Eigen::VectorXd u;
  int only = -1;  ///< coordinate; -1: all targets
};

/// The model at a trial.
struct Evaluation {
  Eigen::VectorXd values{};  ///< a number for each target; NaN for those that the trial's coordinate leaves
  std::string problem{};     ///< why there are none, as a table says it; empty: there are
  double share = 1;          ///< of the cost of all targets
};

/// A least-squares problem in bounded coordinates u, whose model is costly and has no derivatives.
struct LeastSquaresProblem {
  std::vector<Target> targets{};
  Eigen::VectorXd start{}, low{}, high{};  ///< coordinates; bounds may be infinite
  /// The model at several trials at once.
  std::function<std::vector<Evaluation>(const std::vector<Trial>&)> evaluate{};
  std::function<bool()> stopped = [] { return false; };
  double most_evaluations = 30;  ///< of all targets
  /// Solved where the next step is below this in every coordinate, or below this share of standard errors.
  double least_step = 1e-4, least_share = 0.1;
};

enum class Ended { converged, too_many_evaluations, stalled, undetermined, failed_at_start, interrupted };

/// What was tried, in order.
struct TriedStep {
  std::string kind;  ///< "start", "difference" or "step"
  Eigen::VectorXd u;
  double evaluations = 0;  ///< so far
  double chi2 = 0;         ///< NaN of a difference, and with a problem
  bool accepted = false;
  std::string problem{};
};

struct LeastSquaresResult {
  Ended ended = Ended::converged;
  std::string problem{};            ///< of the start, if that failed
  std::vector<int> undetermined{};  ///< coordinates that the targets do not tell apart, or do not depend on
  Eigen::VectorXd u{}, values{};    ///< the best that was found
  double chi2 = 0;                  ///< sum of squared residuals over uncertainties
  /// Derivatives of the residuals (measured less model, over uncertainty) by u there, targets x coordinates.
  Eigen::MatrixXd jacobian{};
  double evaluations = 0;  ///< spent, of all targets
  std::vector<TriedStep> steps{};
};

/// Gauss-Newton with bounds and a trust region, derivatives by forward differences once, then by Broyden's
/// secants row by row (Schubert, Math. Comp. 24, 1970), so that what a coordinate does not touch stays
/// untouched; by differences again where the secants mispredict, or end further than 1 from the first ones. A
/// trial that fails or is worse halves the step. It has converged where the next step is below `least_step`,
/// or below `least_share` of standard errors, and where two steps in a row changed chi2 by no more than such
/// a step.
LeastSquaresResult solve_least_squares(const LeastSquaresProblem& problem);

/// By how much a step of `least_share` of standard errors from the least chi2 raises it: the square of that
/// times s^2, which is chi2 over the degrees of freedom; 0 without any.
double negligible_change(const LeastSquaresProblem& problem, double chi2);

/// The coordinates between which the columns of a jacobian do not tell; first those that change nothing of
/// what was measured.
std::vector<int> undetermined_coordinates(const Eigen::MatrixXd& jacobian,
                                          const std::vector<Target>& targets);

/// Standard errors and correlations from the residuals' derivatives: s^2 (J^T J)^-1 with s^2 = chi2 over the
/// degrees of freedom. Needs some, and determined coordinates.
Eigen::MatrixXd covariance_of(const Eigen::MatrixXd& jacobian, double chi2);

}  // namespace mss::fit

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "experiments/fit/least_squares.hpp"
#include "experiments/fit/observations.hpp"
#include "experiments/fit/parameters.hpp"
#include "experiments/harness/progress.hpp"

namespace mss::fit {

/// Which numbers of scenes are to make which runs fit what was measured.
struct FitProblem {
  Scene scene{};         ///< as it starts
  SceneSource source{};  ///< with the settings of the command; it is written with the values found
  std::vector<Parameter> parameters{};
  Observations data{};
  /// Settings that make every run a cheap twin of itself, by which most of the search is done; none: no twin.
  std::vector<std::string> coarse{};
  double most_evaluations = 30;  ///< of all runs
};

/// A value that was found.
struct FittedParameter {
  double value = 0;
  double low = 0, high = 0;   ///< 95 percent confidence; NaN: none
  bool at_bound = false;      ///< then the data would have it beyond
  std::string status = "ok";  ///< or why there is no interval
};

struct FitResult {
  Ended ended = Ended::converged;
  std::vector<FittedParameter> parameters;
  Eigen::MatrixXd correlation;              ///< NaN with parameters that have no interval
  std::vector<std::vector<double>> fitted;  ///< of each observation
  double chi2 = 0;                          ///< sum of squared residuals over uncertainties
  int degrees_of_freedom = 0;
  double evaluations = 0;  ///< spent, in runs of everything
  int runs = 0;            ///< of scenes
  int coarse_runs = 0;     ///< of their twins
  double seconds = 0;
  std::vector<TriedStep> steps;  ///< in coordinates
};

/// A problem without data yet, of a scene with settings. Throws InputError as load_scene() and
/// read_parameters() do.
FitProblem read_problem(const SceneSource& source, const std::vector<std::string>& settings,
                        const std::vector<std::string>& parameters);

/// Throws InputError for observations that cannot be of the scenes or of their twins, and for fewer numbers
/// than parameters.
void check_problem(FitProblem& problem);

/// Finds the values, with as many runs at once as there are cores. Throws InputError where a run fails with
/// the values that the fit starts from, and names parameters that the data do not determine.
FitResult fit(const FitProblem& problem, Progress& progress);

/// The parameters' values at coordinates.
std::vector<double> values_of(const FitProblem& problem, const Eigen::VectorXd& u);

/// The overrides that give a scene these values, in the order of the parameters; none of none.
std::vector<std::string> settings_of(const FitProblem& problem, const std::vector<double>& values);

}  // namespace mss::fit

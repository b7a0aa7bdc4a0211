#pragma once

#include <string>
#include <vector>

#include "core/springs/spring_system.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::convergence {

/// A way to solve the equations of a step: a nonlinear solver of backward Euler's and, of Newton's method,
/// the linear solver; or a method whose iterations are meant to lead there.
struct SolverPair {
  std::string nonlinear = {};
  std::string linear = {};  ///< empty: of those that need none
  std::string method = "backward_euler";

  std::string name() const {
    return nonlinear.empty() ? method : linear.empty() ? nonlinear : nonlinear + "/" + linear;
  }
};

/// Settings of `mss convergence`.
struct ConvergenceConfig {
  int cells = 7;  ///< per edge
  std::vector<std::string> starts;
  std::vector<double> dt_omega;  ///< step times the bound on frequencies
  std::vector<SolverPair> solvers;
  std::vector<int> iterations;  ///< ascending
  int repetitions = 3;
  int threads = 1;
};
ConvergenceConfig convergence_config(const ExperimentOptions& options);
/// Every nonlinear solver, Newton's method with every linear solver, and methods that are meant to lead
/// there.
std::vector<SolverPair> all_solvers();
/// The names that --scenes takes: of starts, bodies and scenes.
std::vector<std::string> convergence_scene_names();

struct ConvergenceTables {
  Table rows;
  Status status = Status::ok;
};

/// One step of backward Euler from every start, with every solver stopped after so many iterations.
///
/// The step minimises g(x) = |x - y|_M^2 / 2 + dt^2 E(x), y = x_0 + dt v_0. Of x after k iterations the rows
/// contain `gap`, (g(x) - g*) / (g(y) - g*) with g* the lowest value that any solver reached, `residual`,
/// |grad g(x)| / |grad g(y)|, and the change of linear momentum and of spin about the centre of mass, neither
/// of which the forces change: over sum m |v| and over the spin before.
ConvergenceTables measure_convergence(const ConvergenceConfig& config, Progress& progress);

/// For every start, step and solver: the iterations and the time to a gap of 1 percent.
Table convergence_summary(const Table& rows);

/// Time to within 1 percent, one row of the chart for each of the tables, whose rows are solvers; right of a
/// line, side by side, what does not come so near.
Chart time_to_percent(const std::vector<std::string>& names, const std::vector<Table>& tables,
                      const std::vector<std::string>& solvers);

/// The tables of single hard steps: the rows, their summary, and the settings that the charts mention.
std::vector<NamedTable> convergence_files(const ConvergenceConfig& config, const Table& rows);

}  // namespace mss::studies::convergence

#pragma once

#include <string>
#include <vector>

#include "core/springs/spring_system.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::stiffness {

/// An integrator and the linear solver it uses; empty for one that has its own or needs none. Methods of
/// fixed step take the safe one.
struct StiffMethod {
  std::string integrator;
  std::string linear_solver;
  int largest_cells;  ///< left out of larger bodies: it would take minutes

  std::string name() const { return linear_solver.empty() ? integrator : integrator + "/" + linear_solver; }
};

/// Settings of `mss stiffness`.
struct StiffnessConfig {
  std::vector<int> cells;
  std::string model = spring_model;
  std::vector<double> young;  ///< [Pa]
  std::vector<StiffMethod> methods;
  int repetitions = 3;
  double duration = 1.0 / 60;  ///< [s]
  double tolerance = 1e-6;
  double damping_ratio = 0.5;
  double stretch = 1.1;  ///< along z, at the start
  int threads = 1;
};
StiffnessConfig stiffness_config(const ExperimentOptions& options);

struct StiffnessTables {
  Table rows;
  Status status = Status::ok;
};
StiffnessTables measure_stiffness(const StiffnessConfig& config, Progress& progress);

/// The step, times the largest frequency, and Poisson's ratio that charts of linear solvers show.
inline constexpr double charted_dt_omega = 300;
inline constexpr double charted_poisson = 0.3;

/// All linear solvers that take a cube of this model, but those that only choose among the others.
std::vector<std::string> compared_solvers(const std::string& model = spring_model);

/// Whether a linear solver is left out of bodies with this number of cells per edge: it would take minutes.
/// `charted`: in the cases that may take longer, that of charts against cells and statics.
bool is_too_large(const std::string& solver, int cells, bool charted);

/// Settings of the comparison of linear solvers: one solve of the projected matrix of an implicit step, from
/// a bent, stretched and slightly noisy state of a cube of which one face is held, with the forces there.
struct LinearSolveConfig {
  std::vector<int> cells{10, 20, 40, 60};
  std::string model = spring_model;
  std::vector<double> dt_omega{3, 30, 300, 3000};  ///< and static
  std::vector<double> poisson{0.3, 0.45};
  int poisson_cells = 20;  ///< where the following are compared too, at charted_dt_omega
  std::vector<double> more_poisson{0.48, 0.49, 0.495, 0.499};
  std::vector<std::string> solvers = compared_solvers();
  double tolerance = 1e-6;       ///< of the residual, over the right-hand side
  int repetitions = 3;           ///< at most
  double seconds_per_row = 0.2;  ///< after which a solver is not repeated
};
LinearSolveConfig linear_solve_config(const ExperimentOptions& options);

/// Seconds to prepare a new solver on a new system, to prepare it again, and to solve; the column `seconds`
/// is the first and the last together. dt_omega 0: static. A row per case and solver, of finished cases.
Table measure_linear_solves(const LinearSolveConfig& config, Progress& progress);

/// Of the same rows: time of set-up and solve over that of `matrix_free`, where both succeeded; the same with
/// a repeated set-up.
Table linear_solve_ratios(const Table& rows);

/// Time of set-up and solve against cells.
Chart linear_solve_chart(const Table& rows);

/// Settings of the comparison of an implicit step with the explicit ones it replaces.
struct CrossoverConfig {
  std::vector<int> cells{10, 20, 40};
  std::string model = spring_model;
  std::vector<double> dt_omega{10, 30, 60, 100, 200, 300, 1000, 3000};  ///< of the implicit step
  double frame = 1.0 / 60;                                              ///< the implicit step [s]
  std::string implicit = "backward_euler_linear";
  int repetitions = 3;           ///< at most
  double seconds_per_row = 0.2;  ///< after which a method is not repeated
};
CrossoverConfig crossover_config(const ExperimentOptions& options);

/// Time and error of a frame by one implicit step, with the linear solver that is fastest there, and by the
/// fastest explicit method at its safe step; a row per size and dt omega, of finished ones. Times are of a
/// step within a run, in which what does not depend on the state is set up already; columns with `first` are
/// of the first step.
Table measure_crossover(const CrossoverConfig& config, Progress& progress);

/// Of the same rows, for a later and for the first step at each size: from which dt omega on it is cheaper,
/// interpolated.
Table crossover_summary(const Table& rows);

/// Times of explicit steps over those of implicit ones, against dt omega.
Chart crossover_chart(const Table& rows);

/// The x from which on the ratios stay above 1, interpolated in logarithms; 0: all of them do, NaN: the last
/// does not.
double last_crossing(const std::vector<ChartPoint>& ratios);

/// For every size and competitor of CHOLMOD: from which stiffness on it is slower than CHOLMOD, and how many
/// times as long it takes at least and at most.
Table stiffness_summary(const Table& rows);

/// All tables of the experiment: the rows, their summary, and the settings that the charts mention.
std::vector<NamedTable> stiffness_files(const StiffnessConfig& config, const Table& rows);

/// Time of BDF with other linear solvers divided by that with CHOLMOD, against stiffness, for all sizes.
Chart stiffness_overview(const Table& rows);

}  // namespace mss::studies::stiffness

#pragma once

#include <string>
#include <vector>

#include "core/spring_system.hpp"
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

/// For every size and competitor of CHOLMOD: from which stiffness on it is slower than CHOLMOD, and how many
/// times as long it takes at least and at most.
Table stiffness_summary(const Table& rows);

/// All tables of the experiment: the rows, their summary, and the settings that the charts mention.
std::vector<NamedTable> stiffness_files(const StiffnessConfig& config, const Table& rows);

/// Time against stiffness, for one size.
Chart stiffness_chart(const Table& rows, int cells);

/// Time of BDF with other linear solvers divided by that with CHOLMOD, against stiffness, for all sizes.
Chart stiffness_overview(const Table& rows);

}  // namespace mss::studies::stiffness

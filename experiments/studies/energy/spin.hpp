#pragma once

#include <string>
#include <vector>

#include "experiments/harness/experiment.hpp"

namespace mss::studies::energy {

/// A free undamped cube that turns and drifts, for minutes.
struct SpinConfig {
  std::string model = spring_model;
  int cells = 4;            ///< an edge of 0.5 m
  double young = 1e5;       ///< [Pa]
  double drift = 0.03;      ///< speed of its centre of mass [m/s]
  long frames = 3000;       ///< of 1/60 s
  double tolerance = 1e-6;  ///< of adaptive methods
  std::vector<std::string> integrators;
};
SpinConfig spin_config(const ExperimentOptions& options);

/// The frame, of 1/60 s, whose share of spin other studies name: after two seconds.
inline constexpr long early_frame = 120;

/// Rows, per method, at frames that grow geometrically: what is left of the energy, of the linear momentum
/// and of the angular momentum about the centre of mass, of each along its direction at the start, over that
/// at the start. Methods with a limit take their safe step, at most a frame, others a step a frame. Of a run
/// that fails, or whose energy is ten times the initial one (`blows_up`), the last row has no numbers;
/// `no safe step`: nothing was run.
struct SpinTables {
  Table rows;
  Status status = Status::ok;
};
/// A case per method; see compute_cases().
SpinTables measure_spin(const SpinConfig& config, int processes, Journal& journal, Progress& progress);

/// For every method: what is left after two seconds and at the end.
Table spin_summary(const Table& rows);

/// All tables of it: the rows, their summary, and the settings that the chart mentions.
std::vector<NamedTable> spin_files(const SpinConfig& config, const Table& rows);

/// What is left at the end, a row a method.
Chart spin_chart(const Table& summary, const Table& settings);

}  // namespace mss::studies::energy

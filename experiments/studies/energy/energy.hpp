#pragma once

#include <string>
#include <vector>

#include "core/spring_system.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::energy {

/// Settings of `mss energy`.
struct EnergyConfig {
  BodyConfig body;
  std::string model = spring_model;
  double stretch = 1.1;      ///< of the free body along z, at the start
  double step_share = 0.25;  ///< dt over the limit of central differences
  long steps = 100000;       ///< of dt; adaptive methods cover the same time
  double tolerance = 1e-6;   ///< of adaptive methods
  std::vector<std::string> integrators;
  int threads = 1;
};
EnergyConfig energy_config(const ExperimentOptions& options);

/// Rows: for windows of time that grow geometrically, the largest deviation of the energy from that at the
/// start.
struct EnergyTables {
  Table rows;
  Status status = Status::ok;
};
EnergyTables measure_energy(const EnergyConfig& config, Progress& progress);

/// For every method that was not interrupted: the largest error until a tenth of the steps and after it, and
/// the conclusion from them.
Table energy_summary(const Table& rows, long steps);

/// All tables of the experiment: the rows, their summary, and the settings that the chart mentions.
std::vector<NamedTable> energy_files(const EnergyConfig& config, const Table& rows);

}  // namespace mss::studies::energy

#pragma once

#include <string>
#include <vector>

#include "core/spring_system.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::energy {

/// What `mss energy` does.
struct EnergyConfig {
  BodyConfig body;
  std::string model = spring_model;
  double stretch = 1.1;      ///< of the free body along z, at the start
  double step_share = 0.25;  ///< dt over the limit of central differences
  long steps = 100000;       ///< of dt; adaptive methods follow the same time
  double tolerance = 1e-6;   ///< of adaptive methods
  std::vector<std::string> integrators;
  int threads = 1;
};
EnergyConfig energy_config(const ExperimentOptions& options);

/// Rows: for windows of time that grow geometrically, how far the energy was from that of the start.
struct EnergyTables {
  Table rows;
  Status status = Status::ok;
};
EnergyTables measure_energy(const EnergyConfig& config, Progress& progress);

/// For every method that was not interrupted: the largest error until a tenth of the steps and after it, and
/// what that says.
Table energy_summary(const Table& rows, long steps);

Chart energy_chart(const Table& rows, const EnergyConfig& config);

}  // namespace mss::studies::energy

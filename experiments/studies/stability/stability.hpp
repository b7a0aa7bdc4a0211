#pragma once

#include <string>
#include <vector>

#include "core/body_system.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::stability {

/// Settings of `mss stability`, which measures the largest stable step.
struct StabilityConfig {
  std::vector<int> cells;      ///< per edge of a cube
  std::vector<double> ratios;  ///< of damping to critical, of every spring
  std::vector<std::string> integrators;
  double young = 1e4, poisson = 0.3;  ///< [Pa]
  double density = 1000;              ///< [kg/m^3]
  double resolution = 0.004;          ///< relative error of a measured limit
  std::uint64_t seed = 1;             ///< of the small initial motion
  int threads = 1;
};
StabilityConfig stability_config(const ExperimentOptions& options);

/// The interval in which lies the step from which on a random small motion about rest grows [s].
struct MeasuredStep {
  /// Largest step found stable, smallest found unstable; both 0: no step is stable, infinite: every step is.
  double stable = 0, unstable = 0;
};

/// Finds it by bisection. A poor guess costs time only.
MeasuredStep measure_step(const StabilityConfig& config, const IntegratorInfo& method,
                          BodySystem<double>& system, double guess);

struct StabilityTables {
  Table rows;
  Status status = Status::ok;
};
StabilityTables measure_stability(const StabilityConfig& config, Progress& progress);

/// All tables of the experiment: the rows, and the settings that the charts mention.
std::vector<NamedTable> stability_files(const StabilityConfig& config, const Table& rows);

}  // namespace mss::studies::stability

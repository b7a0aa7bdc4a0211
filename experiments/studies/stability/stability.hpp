#pragma once

#include <string>
#include <vector>

#include "core/body_system.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::stability {

/// What `mss stability` measures: how large a step may be.
struct StabilityConfig {
  std::vector<int> cells;      ///< per edge of a cube
  std::vector<double> ratios;  ///< of damping to critical, of every spring
  std::vector<std::string> integrators;
  double young = 1e4, poisson = 0.3;  ///< [Pa]
  double density = 1000;              ///< [kg/m^3]
  double resolution = 0.004;          ///< of a measured limit, as a share of it
  std::uint64_t seed = 1;             ///< of the small motion that grows or does not
  int threads = 1;
};
StabilityConfig stability_config(const ExperimentOptions& options);

/// The step between whose ends a random small motion about rest begins to grow [s].
struct MeasuredStep {
  double stable = 0,
         unstable = 0;  ///< largest step that held, smallest that did not; 0: none held, infinite: all
};

/// Bisects, from a guess that need not be near.
MeasuredStep measure_step(const StabilityConfig& config, const IntegratorInfo& method,
                          BodySystem<double>& system, double guess);

struct StabilityTables {
  Table rows;
  Status status = Status::ok;
};
StabilityTables measure_stability(const StabilityConfig& config, Progress& progress);

}  // namespace mss::studies::stability

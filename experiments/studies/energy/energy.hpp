#pragma once

#include <string>
#include <vector>

#include "core/springs/spring_system.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::energy {

/// Settings of `mss energy`.
struct EnergyConfig {
  BodyConfig body;
  Environment environment{};
  std::string model = spring_model;
  double stretch = 1.1;      ///< of the body along z, at the start
  double step_share = 0.25;  ///< dt over the limit of central differences
  double dt = 0;             ///< [s]; 0: by step_share
  long steps = 30000;        ///< of dt; adaptive methods cover the same time
  double tolerance = 1e-6;   ///< of adaptive methods
  std::vector<std::string> integrators;
};
EnergyConfig energy_config(const ExperimentOptions& options);

/// One cell whose upper face moves up and down on the lower one, so little that it is a harmonic oscillator
/// of w^2 = 2 C11 / (rho h^2), released from its largest stretch: what every method does to its energy is
/// known in closed form. The step is such that w dt is `mode_step`.
EnergyConfig one_mode_config();
inline constexpr double mode_step = 0.25;

/// Rows: for windows of time that grow geometrically, the largest deviation of the energy from that at the
/// start.
struct EnergyTables {
  Table rows;
  Status status = Status::ok;
};
/// A case per method; see compute_cases().
EnergyTables measure_energy(const EnergyConfig& config, int processes, Journal& journal, Progress& progress);

/// For every method: the largest error until a tenth of the steps and after it, and
/// the conclusion from them.
Table energy_summary(const Table& rows, long steps);

/// All tables of the experiment: the rows, their summary, and the settings that the chart mentions.
std::vector<NamedTable> energy_files(const EnergyConfig& config, const Table& rows);

}  // namespace mss::studies::energy

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/springs/spring_system.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::stability {

/// A body and the equilibrium about which it makes small motions.
enum class Deformation {
  none,        ///< a free cube
  stretched,   ///< a cube between clamps that are 30 percent of its length further apart
  compressed,  ///< a cube between clamps that are 20 percent nearer
  bent         ///< a bar three times as long as wide, one end turned by 90 degrees against the other
};
std::string_view to_string(Deformation deformation);

/// Settings of `mss stability`, which measures the largest stable step.
struct StabilityConfig {
  std::vector<int> cells;                 ///< per edge of a free cube
  std::vector<double> ratios;             ///< of damping to critical, of every spring
  std::vector<Deformation> deformations;  ///< beside none
  int deformed_cells = 3;                 ///< across a deformed body
  std::vector<double> deformed_ratios;    ///< of its damping
  std::vector<std::string> integrators;
  double young = 1e4, poisson = 0.3;  ///< [Pa]
  double density = 1000;              ///< [kg/m^3]
  double resolution = 0.004;          ///< relative width of the interval that contains a measured limit
  std::uint64_t seed = 1;             ///< of the small initial motion
};
StabilityConfig stability_config(const ExperimentOptions& options);

/// A body in equilibrium.
struct Specimen {  // NOLINT(clang-analyzer-optin.performance.Padding): the system must follow the body
  Specimen(const StabilityConfig& config, Deformation how, int n, double damping);
  /// The system refers to the body.
  Specimen(const Specimen&) = delete;
  Specimen& operator=(const Specimen&) = delete;

  Deformation deformation;
  int cells;     ///< across
  double ratio;  ///< of damping
  Body body;
  SpringSystem<double> system;
  Status status = Status::ok;  ///< of the search for the equilibrium, and for the frequency
  State<double> equilibrium;
  double omega = 0;  ///< of the fastest mode about it [rad/s]
};

/// The interval in which lies the step from which on a random small motion about equilibrium grows [s].
struct MeasuredStep {
  /// Largest step found stable, smallest found unstable; both 0: no step is stable, infinite: every step is.
  double stable = 0, unstable = 0;
};

/// Finds it from a hundredth of the time that sound takes through a cell: by quadrupling, then by bisection.
MeasuredStep measure_step(const StabilityConfig& config, const IntegratorInfo& method, Specimen& specimen);

struct StabilityTables {
  Table rows;
  Status status = Status::ok;
};
/// A case per body and method; see compute_cases().
StabilityTables measure_stability(const StabilityConfig& config, int processes, Journal& journal,
                                  Progress& progress);

/// All tables of the experiment: the rows, and the settings that the charts mention.
std::vector<NamedTable> stability_files(const StabilityConfig& config, const Table& rows);

}  // namespace mss::studies::stability

#pragma once

#include <complex>
#include <string>
#include <vector>

#include "core/body/relaxation.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::relaxation {

/// A bar of springs without volume force (nu = 1/4), so that all of it relaxes alike, and what is done to it.
struct RelaxationConfig {
  double young = 1e5;      ///< at rest [Pa]
  int cells = 4;           ///< along it, one across
  double cell_size = 0.2;  ///< [m]
  Relaxation relaxation{.ratio = 0.5, .time = 0.2};
  std::vector<double> frequencies;   ///< of its strain, times the relaxation time
  std::vector<int> steps;            ///< a period
  std::vector<std::string> methods;  ///< that it creeps with
  std::vector<double> creep_steps;   ///< over the relaxation time
};
RelaxationConfig relaxation_config(const ExperimentOptions& options);

/// Young's modulus over that at rest, of strains that oscillate with `frequency`, times the relaxation time:
/// 1 + ratio i f / (1 + i f).
std::complex<double> complex_modulus(const Relaxation& relaxation, double frequency);
/// Strain over that at rest, t [s] after a load began that grows at a constant rate until `grown` [s] and
/// stays.
double creep(const Relaxation& relaxation, double grown, double t);

struct RelaxationTables {
  Table modulus;  ///< against frequency and steps a period
  Table creep;    ///< in time, by method and step
  Status status = Status::ok;
};
RelaxationTables measure_relaxation(const RelaxationConfig& config, Progress& progress);
std::vector<NamedTable> relaxation_files(RelaxationTables tables);
Drawings draw_relaxation(const std::vector<NamedTable>& tables);

}  // namespace mss::studies::relaxation

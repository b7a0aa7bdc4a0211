#pragma once

#include <string>
#include <vector>

#include "core/body/body_config.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::rope {

/// A rope and a square sheet of the same rubber, held at their ends or rim, and what is measured of them.
struct RopeConfig {
  ElasticConstants material{.young = 5e6, .poisson = 1.0 / 3};
  double density = 1100;
  double length = 2;           ///< of the rope, and of the sheet's edges [m]
  double thickness = 0.02;     ///< of the sheet, and the edge of the rope's section [m]
  double strain = 0.05;        ///< by which both are stretched
  double stretch = 1e-4;       ///< of the rope that hangs: its weight over E A
  double span = 1.4;           ///< between the ends of the rope that hangs [m]
  std::vector<int> links{};    ///< of the rope
  std::vector<int> squares{};  ///< along an edge of the sheet
};
RopeConfig rope_config(const ExperimentOptions& options);

struct RopeTables {
  Table waves;       ///< frequencies of rope and sheet across and along, by cells
  Table pulses;      ///< speed of a pulse across the rope, by links
  Table catenaries;  ///< of the rope that hangs, by links
  Status status = Status::ok;
};
RopeTables measure_ropes(const RopeConfig& config, Progress& progress);
std::vector<NamedTable> rope_files(RopeTables tables);
Drawings draw_ropes(const std::vector<NamedTable>& tables);

}  // namespace mss::studies::rope

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/material.hpp"
#include "experiments/experiment.hpp"

namespace mss {

/// What fills the cube, and with which volume force.
struct VolumeModel {
  std::string name;
  std::string model;                             ///< for make_system()
  std::optional<ElasticConstants> elastic = {};  ///< empty: the thesis's springs
  double thesis_volume = 0;                      ///< k_vol beside the thesis's springs [Pa]
  double small_change =
      0;  ///< change of volume over a small strain that elasticity predicts, ends glued; 0: none known
};

/// What `mss volume` does to a cube of 1 m whose ends are glued and pulled apart or together.
struct VolumeConfig {
  std::vector<int> cells;         ///< per edge
  std::vector<double> strains;    ///< of the second study
  std::vector<double> stiffness;  ///< k_vol of the third [Pa]
  double small_strain = 1e-3;     ///< of the first
  double large_strain = 0.1;      ///< of the third
  int study_cells = 8;            ///< per edge, of the second and third
  std::vector<VolumeModel> models;
};
VolumeConfig volume_config(const ExperimentOptions& options);

struct VolumeTables {
  Table rows;
  Status status = Status::ok;
};
VolumeTables measure_volume(const VolumeConfig& config, Progress& progress);

}  // namespace mss

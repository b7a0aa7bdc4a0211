#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/body_system.hpp"
#include "experiments/experiment.hpp"

namespace mss {

/// What fills the cube, and with which volume force.
struct VolumeModel {
  std::string name;
  std::string model;                   ///< for make_system()
  std::optional<double> poisson = {};  ///< of a material of E = 1416.67 Pa; empty: the thesis's springs
  double thesis_volume = 0;            ///< k_vol beside the thesis's springs [Pa]
};

/// What `mss volume` does to a cube of 1 m between two plates.
struct VolumeConfig {
  std::vector<int> cells;              ///< per edge, of the first study: glued and pulled a little
  std::vector<double> strains;         ///< of the second: glued, pulled apart or pushed together
  std::vector<double> angles;          ///< of the third: glued, the upper plate turned [degrees]
  std::vector<VolumeModel> models;     ///< of these three
  std::vector<VolumeModel> materials;  ///< of the fourth: plates without friction, pulled a very little
  double small_strain = 1e-3;          ///< of the first
  double tiny_strain = 1e-5;           ///< of the fourth
  int threads = 1;
  int study_cells = 8;  ///< per edge, of all but the first
  /// make_system(), unless a test puts something else in its place.
  std::function<std::unique_ptr<BodySystem<double>>(const std::string& model, const Body&, const Environment&,
                                                    int threads)>
      make;
};
VolumeConfig volume_config(const ExperimentOptions& options);

/// A body of that many cells per edge. The thesis's springs are the material that they are at five.
BodyConfig volume_cube(const VolumeModel& model, int cells);

struct VolumeTables {
  Table rows;
  Status status = Status::ok;
};
VolumeTables measure_volume(const VolumeConfig& config, Progress& progress);

std::vector<NamedChart> volume_charts(const Table& rows, const VolumeConfig& config);

}  // namespace mss

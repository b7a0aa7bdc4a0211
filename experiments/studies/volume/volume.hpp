#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/body_system.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::volume {

/// What fills the cube, and with which volume force.
struct VolumeModel {
  std::string name;
  std::string model;                   ///< for make_system()
  std::optional<double> poisson = {};  ///< of a material of E = 1416.67 Pa; empty: the thesis's springs
  double thesis_volume = 0;            ///< k_vol beside the thesis's springs [Pa]
};

/// What `mss volume` does to a cube of 1 m between two plates.
struct VolumeConfig {
  std::vector<int> cells;                ///< per edge, of the first study: glued and pulled a little
  std::vector<double> strains;           ///< of the second: glued, pulled apart or pushed together
  std::vector<double> angles;            ///< of the third: glued, the upper plate turned [degrees]
  std::vector<VolumeModel> models;       ///< of these three
  std::vector<VolumeModel> materials;    ///< of the fourth: plates without friction, pulled a very little
  std::vector<std::string> integrators;  ///< of the fifth: dropped, it bounces
  std::vector<double> step_shares;       ///< of the fifth: steps over the limit of central differences
  double small_strain = 1e-3;            ///< of the first
  double tiny_strain = 1e-5;             ///< of the fourth
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
  Table bounce;  ///< volume against time: of every model, and of every integrator at one step
  Status status = Status::ok;
};
VolumeTables measure_volume(const VolumeConfig& config, Progress& progress);

/// Step of the runs that others are compared with, by RK4; over the limit of central differences.
inline constexpr double exact_bounce_step = 0.1;

/// The fifth study: adds to both tables. False if stopped.
bool measure_bounces(const VolumeConfig& config, VolumeTables& tables, Progress& progress);

/// What a row of the first table tells.
struct VolumeRow {
  std::string study, model, integrator;
  int cells = 0;
  double strain = 0;
  double angle = 0;  ///< [degrees]
  double step = 0;   ///< over the limit of central differences; 0: the method's own, or none
  SpringConstants springs{};
  double drift = 0, drift_thesis = 0, worst_cell = 0;
  double predicted = 0;   ///< by elasticity, to first order; 0 too where nothing is
  double difference = 0;  ///< of the drift of a bounce, to an exact run's
  Status status = Status::ok;
};
/// Adds it; of a failed run what it measured is missing.
void add_row(Table& rows, const VolumeRow& row);

/// Largest change of a cell's volume, over its volume at rest.
double worst_cell(const Body& body, const Field<double>& x);

std::vector<NamedChart> volume_charts(const VolumeTables& tables, const VolumeConfig& config);

}  // namespace mss::studies::volume

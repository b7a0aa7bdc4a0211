#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/springs/body_system.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::volume {

/// The parts of the study, in the order of the table: a cube between plates, clamped to both and stretched a
/// little at several resolutions, stretched or compressed, or twisted; between plates without friction,
/// stretched far, and very little; and a cube that falls and bounces.
enum class Study { cells, strain, twist, tension, free, bounce };
const char* to_string(Study study);

/// What carries the forces in the cube.
enum class Filling { thesis_springs, springs, mollemans, elements, mean_elements };
const char* to_string(Filling filling);

/// A filling with its material.
struct VolumeModel {
  std::string name;
  Filling filling = Filling::springs;
  std::string model;                   ///< for make_system()
  std::optional<double> poisson = {};  ///< of a material of E = 1416.67 Pa; empty: the thesis's springs
  double thesis_volume = 0;            ///< k_vol beside the thesis's springs [Pa]
};

/// The model of Study::bounce with all integrators, whose worst cells are charted: calibrated springs of this
/// Poisson's ratio.
inline constexpr Filling detailed_filling = Filling::springs;
inline constexpr double detailed_poisson = 0.45;

/// What `mss volume` does to a cube of 1 m.
struct VolumeConfig {
  std::vector<int> cells;                ///< per edge, of Study::cells
  std::vector<double> strains;           ///< of Study::strain
  std::vector<double> angles;            ///< of Study::twist [degrees]
  std::vector<VolumeModel> models;       ///< of all but Study::free and tension
  std::vector<VolumeModel> materials;    ///< of Study::free
  std::vector<double> tensions;          ///< strains of Study::tension
  std::vector<VolumeModel> stretched;    ///< of Study::tension
  std::vector<std::string> integrators;  ///< of Study::bounce
  std::vector<double> step_shares;       ///< of Study::bounce: steps over the limit of central differences
  double small_strain = 1e-3;            ///< of Study::cells
  double tiny_strain = 1e-5;             ///< of Study::free
  int study_cells = 8;                   ///< per edge, of Study::strain, twist, tension and free
  /// make_system(), unless a test replaces it.
  std::function<std::unique_ptr<BodySystem<double>>(const std::string& model, const Body&,
                                                    const Environment&)>
      make;
};
VolumeConfig volume_config(const ExperimentOptions& options);

/// A cube of that many cells per edge. The thesis's springs are scaled to be the same material as at five.
BodyConfig volume_cube(const VolumeModel& model, int cells);

struct VolumeTables {
  Table rows;
  Table bounce;  ///< volume against time: of every model, and of every integrator at one step
  Table limit;   ///< of central differences for the model with all integrators: true, guaranteed, their ratio
  Status status = Status::ok;
};
/// A case per body at rest, and one per model that falls; see compute_cases().
VolumeTables measure_volume(const VolumeConfig& config, int processes, Journal& journal, Progress& progress);

Table empty_rows();
Table empty_bounce();
Table empty_limit();

/// All tables under the names of their files; `volume_models` has the filling and material of every model.
std::vector<NamedTable> volume_files(const VolumeConfig& config, VolumeTables tables);

/// Step of the reference runs of Study::bounce, by RK4, over the limit of central differences.
inline constexpr double reference_bounce_step = 0.1;

/// Study::bounce of one model.
VolumeTables measure_bounce(const VolumeConfig& config, const VolumeModel& model);

/// A row of the first table.
struct VolumeRow {
  Study study = Study::cells;
  std::string model, integrator;
  int cells = 0;
  double strain = 0;
  double angle = 0;  ///< [degrees]
  double step = 0;   ///< over the limit of central differences; 0: an adaptive method, or no motion
  SpringConstants springs{};
  double drift = 0, drift_thesis = 0, worst_cell = 0;
  double predicted = 0;   ///< by elasticity, to first order; 0 too where there is no prediction
  double difference = 0;  ///< of the drift from that of the reference run, the largest of a bounce
  bool refused = false;   ///< a method that cannot take the scene in such steps
  Status status = Status::ok;
};
/// Adds it; if the run failed, its measurements are missing.
void add_row(Table& rows, const VolumeRow& row);

/// Largest relative change of a cell's volume.
double worst_cell(const Body& body, const Field<double>& x);

Drawings draw_volume(const std::vector<NamedTable>& tables);

}  // namespace mss::studies::volume

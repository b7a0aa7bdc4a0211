#pragma once

#include <string>
#include <vector>

#include "core/scene/scene.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/harness/ring_down.hpp"

namespace mss::studies::beam {

/// A weight at the beam's end: its name in reference/beam and the scene that has it.
struct BeamLoad {
  std::string name;   ///< "none", "52 g", "102 g"
  std::string scene;  ///< one that comes with the program
};
const std::vector<BeamLoad>& beam_loads();

/// The silicone, as the scenes have it but for these settings.
struct BeamMaterial {
  std::string name;
  std::vector<std::string> settings{};  ///< "table.key=value"
  int cells = 0;                        ///< across, that it is for; 0: any
};

/// The marker whose motion is measured, of reference::beam_markers().
inline constexpr std::size_t ringing_marker = 1;

struct BeamConfig {
  std::vector<BeamMaterial> materials;
  std::vector<int> cells;             ///< across, of equilibria: multiples of three, for the cells are cubes
  std::vector<int> ringing_cells;     ///< of ring-downs
  std::vector<BeamLoad> ringing;      ///< loads that ring
  std::vector<std::string> settings;  ///< of all scenes, by the user
  int fit_cells = 0;                  ///< across, of the beam that materials are fitted with; 0: none is
};
BeamConfig beam_config(const ExperimentOptions& options);

/// The settings that give a scene so many cells across.
std::vector<std::string> beam_cells(int across);

/// A load's scene with other cells: `cells` across. Throws InputError as load_scene() does.
Scene beam_scene(const BeamConfig& config, const BeamMaterial& material, const BeamLoad& load, int cells);

/// How far points of the beam have sunk at rest, in the order of the markers [m].
struct BeamRest {
  Status status = Status::ok;
  std::vector<double> drops{};         ///< of the points of the beam
  std::vector<double> centre_drops{};  ///< of the markers' centres, which turn with the free end
};
BeamRest beam_at_rest(const Scene& scene);

/// The height of marker 1 about its rest, sampled while the beam rings down.
struct BeamMotion {
  std::string status = "ok";
  std::vector<double> times{};    ///< [s] since it had moved as far as where measured times begin
  std::vector<double> heights{};  ///< [m]
};
BeamMotion beam_motion(const Scene& scene, double rest_drop);

/// Fits materials to the measured runs "none a" and "102 g a", with so many cells across, and adds their
/// numbers as rows. Stopped: those that are finished.
std::vector<BeamMaterial> fit_beam(int cells, Progress& progress, Table& fits);
Table empty_beam_fits();

struct BeamTables {
  Table drops;      ///< of markers at rest, computed beside measured
  Table comsol;     ///< where COMSOL's are known, of the finest cells beside
  Table ring_down;  ///< frequency and damping
  Table turns;      ///< turning points
  Table motion;     ///< computed
  Table fits;       ///< numbers of fitted materials
  Status status = Status::ok;
};
BeamTables measure_beam(BeamConfig config, Progress& progress);

/// Turning points that frequency and damping are taken from: three periods of upper and of lower peaks. Later
/// ones of a measured motion are nearer to noise and to what the rest drifts.
inline constexpr int ringing_turns = 8;

/// Frequency and damping of a measured run, by the function that a computed motion goes through.
RingDown measured_ring_down(const std::string& run);

std::vector<NamedTable> beam_files(BeamTables tables);
Drawings draw_beam(const std::vector<NamedTable>& tables);

}  // namespace mss::studies::beam

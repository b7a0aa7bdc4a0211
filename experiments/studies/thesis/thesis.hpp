#pragma once

#include <string>
#include <vector>

#include "core/body/body.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::thesis {

/// The springs of a cell of Figs. 2-1 to 2-3.
struct CellSprings {
  std::string name;
  Topology topology = Topology::full;
  SpringConstants springs{};
};
/// All 28 with the thesis's constants; without face diagonals; with one of each face; edges alone.
std::vector<CellSprings> cell_springs();

/// How a cube between two plates is deformed before it is released: the upper plate moves by `shift` [cube
/// edges] and turns about the vertical.
struct Deformation {
  std::string name;
  Vec3 shift = Vec3::Zero();
  double turn = 0;  ///< [degrees]
};

/// How springs are changed for a landing, and what is landed on.
struct LandingCase {
  std::string name;
  ContactLaw contact = ContactLaw::thesis;
  double all = 1;         ///< factor of all stiffnesses
  double body = 1;        ///< of body diagonals, in addition
  double step = 1;        ///< of the step
  double fold_guard = 0;  ///< k_g over the shear modulus
};

/// What `mss thesis` measures.
struct ThesisConfig {
  std::vector<Deformation> deformations;  ///< of released cubes, 3 x 3 x 3 cells
  std::vector<int> direction_cells;       ///< per edge of the cubes loaded in several directions
  std::vector<double> volume_shares;      ///< k_vol over the shear modulus, the first 0
  int shape_cells = 6;                    ///< per edge of the stretched cube
  double shape_strain = 0.2;              ///< of it
  std::vector<int> twist_cells;           ///< per edge of twisted cubes
  double twist_angle = 90;                ///< to which they are turned, at most 90 [degrees]
  std::vector<LandingCase> landing_cases;
  std::vector<double> landing_speeds;  ///< [m/s]
  std::vector<int> frame_cells;        ///< per edge of the cubes that `mss view` shows
  int frames = 0;                      ///< drawn of each
  int timing_repetitions = 0;
  int threads = 1;
};
ThesisConfig thesis_config(const ExperimentOptions& options);

/// Fig. 2-1: what remains of a deformation when the load is gone, and mechanisms.
Table measure_unloading(const ThesisConfig& config, const Progress& progress);
/// Fig. 2-2: Young's and shear moduli by direction, measured and in closed form.
Table measure_directions(const ThesisConfig& config, const Progress& progress);
/// Fig. 5-1: the scenes of the figure as they end.
Table measure_figure_5_1(const Progress& progress);
/// The cube of Fig. 5-1 in finer cells and turned further, the material constant: angle against folding.
Table measure_twists(const ThesisConfig& config, const Progress& progress);
/// Section 3.1: time of the estimate and of the exact volume, per cell.
Table measure_volume_time(const ThesisConfig& config, const Progress& progress);
/// Chapter 3 and eq. 1-2: what a volume force does to volume and shape.
Table measure_shape(const ThesisConfig& config, const Progress& progress);
/// Fig. 5-4 and section 5.2.2: landings at every speed, on all cores.
Table measure_landings(const ThesisConfig& config, Progress& progress);
/// Section 5.2.1: frames a second of `mss view`.
Table measure_frames(const ThesisConfig& config, const Progress& progress);

/// Stiffness of the infinite lattice of a body's springs, shared `weighted`, and of its volume force; Voigt
/// notation with engineering shear strains, axes along edges [Pa].
Eigen::Matrix<double, 6, 6> lattice_stiffness(const Body& body);

/// One line for every item of the thesis: its number beside what it is to be compared with.
Table summary_table(const std::vector<NamedTable>& parts);

Drawings draw_thesis(const std::vector<NamedTable>& tables);

}  // namespace mss::studies::thesis

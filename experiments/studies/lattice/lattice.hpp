#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/body/phonons.hpp"
#include "experiments/harness/experiment.hpp"

namespace mss::studies::lattice {

/// Calibrated springs.
struct LatticeMaterial {
  double poisson = 0.3;
  double face_share = 0.5;
  /// [N/m] for cells of 1 m, of a material of E = 1 Pa: speeds and limits depend on neither.
  SpringConstants springs() const;
  std::string name() const;
};

struct LatticeConfig {
  std::vector<LatticeMaterial> dispersive;  ///< whose waves are measured
  std::vector<double> wavelengths;          ///< in cells
  int directions = 24;                     ///< per right angle, over which the slowest and fastest are sought
  std::vector<int> standing_cells;         ///< per edge of the bodies whose vibrations are measured
  std::vector<LatticeMaterial> strained;   ///< whose limits of stability are sought
  std::vector<LatticeMaterial> stretched;  ///< whose bodies are stepped beside their limits
  int stretched_cells = 12;                ///< per edge of those
  std::vector<LatticeMaterial> relaxed;    ///< whose law at large strain is measured
  int relaxed_cells = 4;                   ///< per edge of those
};
LatticeConfig lattice_config(const ExperimentOptions& options);

/// Longitudinal is the wave that moves most along its direction; of the two others one is the slower shear.
enum class WaveKind { longitudinal, slow_shear, fast_shear };
inline constexpr std::array<WaveKind, 3> wave_kinds{WaveKind::longitudinal, WaveKind::slow_shear,
                                                    WaveKind::fast_shear};
const char* to_string(WaveKind kind);

/// Phase speeds of the three waves over those of the continuum.
using PhaseSpeeds = std::array<double, 3>;
PhaseSpeeds phase_speeds(const LatticeMaterial& material, const Vec3& direction, double cells_per_wavelength);

struct LatticeTables {
  Table dispersion;  ///< phase speeds by direction, and the slowest and fastest of all
  Table standing;    ///< vibrations of bodies, stepped, beside the frequency of the lattice's waves
  Table limits;      ///< strains beyond which lattices are unstable
  Table growth;      ///< bodies stepped beside those strains
  Table law;         ///< energy and stress of lattices that relax, beside those of Cauchy and Born
  Status status = Status::ok;
};
LatticeTables measure_lattice(const LatticeConfig& config, Progress& progress);

/// Rows of one part each.
void add_dispersion(const LatticeConfig& config, const LatticeMaterial& material, Table& rows);
void add_standing_waves(const LatticeMaterial& material, int cells, Table& rows);
void add_limits(const LatticeMaterial& material, Table& rows);
void add_growth(const LatticeMaterial& material, int cells, Table& rows);
Table empty_dispersion();
Table empty_standing();
Table empty_limits();
Table empty_growth();
void add_law(const LatticeMaterial& material, int cells, Table& rows);
Table empty_law();

std::vector<NamedTable> lattice_files(LatticeTables tables);
Drawings draw_lattice(const std::vector<NamedTable>& tables);

}  // namespace mss::studies::lattice

#pragma once

#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "core/body/material.hpp"

// Lattice dynamics of the infinite `weighted` full lattice (M. Born and K. Huang, Dynamical Theory of Crystal
// Lattices (1954), sections 24 and 26), deformed by one gradient F, rest to present, everywhere. About it a
// wave of displacements u exp(i (q.n - omega t)), n the integer place of a particle, obeys
// rho h^3 omega^2 u = K(q) u with
//   K(q) = sum_s 4 sin^2(q.n_s / 2) (dT/dL d d^T + T/L (I - d d^T)) + k_vol / h^3 g g^T:
// the thirteen springs s of a site, each from the particle 0 to n_s, have the tension T at the length L along
// d. g = h^2 cof(F) a is how a cell's volume goes with u, a_x = 2 sin(q_x/2) cos(q_y/2) cos(q_z/2) and so on
// what the wave adds to the mean of its edges along an axis. The pressure of the volume force adds nothing:
// the second variation of det(F) is zero where all edges change along u. K is real and symmetric and has the
// period 2 pi in each component of q. The guard against folding is left out.

namespace mss {

/// K(q) [N/m] at phases q per cell [rad].
Eigen::Matrix3d wave_stiffness(const SpringConstants& springs, double cell_size, const Eigen::Matrix3d& F,
                               const Eigen::Vector3d& phases);

/// Nominal stress of the deformed lattice, force by area at rest [Pa].
Eigen::Matrix3d lattice_stress(const SpringConstants& springs, double cell_size, const Eigen::Matrix3d& F);

/// The wave that the lattice resists least: the smallest eigenvalue of K(q) over 4 sum_i sin^2(q_i / 2), that
/// is, over (k h)^2 where waves are long, so that these count as short ones do.
struct SoftestWave {
  double stiffness = 0;  ///< [N/m]; negative: the wave grows, by any method and at any step
  Eigen::Vector3d phases = Eigen::Vector3d::Zero();
  /// Whether it is so long that the springs are a continuum to it.
  bool is_long() const { return phases.cwiseAbs().maxCoeff() < 0.01; }
};
/// Over all q: the best of a grid of the Brillouin zone and of long waves, followed downhill.
SoftestWave softest_wave(const SpringConstants& springs, double cell_size, const Eigen::Matrix3d& F);

/// Deformations of growing strain along which stability is sought.
struct StrainPath {
  enum class Kind {
    tension,      ///< the sides free of stress
    compression,  ///< the same
    shear         ///< simple shear along one edge of the cells, in planes across another
  };
  enum class Direction { edge, face_diagonal, body_diagonal };
  Kind kind = Kind::tension;
  Direction along = Direction::edge;  ///< of tension and compression

  /// Such as "tension along [110]".
  std::string name() const;
};
const char* to_string(StrainPath::Kind kind);

/// Tension and compression along edges, face and body diagonals, and shear.
const std::vector<StrainPath>& strain_paths();

/// F at a strain, not negative, along a path. Not finite beyond where free sides find a stable place: with a
/// negative volume stiffness they give way at some tension.
Eigen::Matrix3d strained_gradient(const SpringConstants& springs, double cell_size, const StrainPath& path,
                                  double strain);

/// Where a lattice loses stability: beyond, a wave grows, or free sides find no rest. Boundaries that hold
/// the wave or the sides delay that, and dampers slow it down.
struct PhononLimit {
  StrainPath path{};
  double strain = std::numeric_limits<double>::infinity();  ///< infinite: stable as far as was looked
  SoftestWave wave{};                                       ///< that grows there
  /// Whether the sides give way, and no wave grows before.
  bool is_of_sides() const { return wave.stiffness == 0 && std::isfinite(strain); }
};
/// Beyond, limits are not looked for.
inline constexpr double farthest_strain = 0.9;

/// To 1e-4 of strain, looked for up to `most`, which is below 1 in compression.
PhononLimit phonon_limit(const SpringConstants& springs, double cell_size, const StrainPath& path,
                         double most);

/// Of each kind of path the direction of the smallest limit, looked for up to most(kind).
std::vector<PhononLimit> least_phonon_limits(
    const SpringConstants& springs, double cell_size,
    const std::function<double(StrainPath::Kind)>& most = [](StrainPath::Kind) { return farthest_strain; });

}  // namespace mss

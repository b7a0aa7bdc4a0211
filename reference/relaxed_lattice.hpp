#pragma once

#include <Eigen/Core>

#include "core/body/material.hpp"

namespace mss::reference {

/// A cube of the lattice whose surface moves with a gradient F and whose inside finds its own places: the
/// particles and springs of Algorithm 1, which walks over cells, and knows no rule of Cauchy and Born. Inside
/// they begin beside F x by up to `disturbance` of a cell, at random, and are relaxed until no force is left.
struct RelaxedLattice {
  double energy = 0;     ///< per volume at rest [J/m^3]
  double moved = 0;      ///< farthest of an inner particle from F x, in cells
  bool at_rest = false;  ///< whether forces fell to 1e-11 of what springs would have at a strain of 1
};
RelaxedLattice relax_lattice(const SpringConstants& springs, double cell_size, int cells,
                             const Eigen::Matrix3d& F, double disturbance);

/// The slope of that energy by F, by central differences of the places of the surface: the nominal stress
/// [Pa].
Eigen::Matrix3d relaxed_stress(const SpringConstants& springs, double cell_size, int cells,
                               const Eigen::Matrix3d& F, double disturbance);

}  // namespace mss::reference

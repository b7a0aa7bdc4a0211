#pragma once

// The guard against folding of one cell, for the sweeps, which do not include Eigen; see fold_guard.hpp.

namespace mss {

/// Adds to the forces [N] on a cell's corners, by corner and
/// axis, those of its guard against folding at these positions [m]. `stiffness` guarded_corner_stiffness(),
/// `shortest` guarded_length(); see fold_guard.hpp.
void add_fold_guard_force(double stiffness, double shortest, const double (&corners)[8][3],
                          double (&force)[8][3]);
/// Adds the change of these forces, to first order, when the corners move along `directions`.
void add_fold_guard_change(double stiffness, double shortest, const double (&corners)[8][3],
                           const double (&directions)[8][3], bool projected, double (&change)[8][3]);

/// Adds the xx, yy, zz, yz, zx, xy of the corners' own 3 x 3 blocks of that derivative, negative.
void add_fold_guard_diagonal(double stiffness, double shortest, const double (&corners)[8][3], bool projected,
                             double (&blocks)[8][6]);

}  // namespace mss

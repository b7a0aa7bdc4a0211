#pragma once

#include <optional>
#include <vector>

#include "core/springs/solid_system.hpp"

namespace mss {

/// Cauchy stress of a solid's cells [Pa], symmetric and positive in tension, by level in the order of
/// Body::for_each_cell(): of each the mean over the cell, by the virial of the forces f_c on its corners x_c
/// of what is in it,
///   sigma = -1 / (f V) sum_c f_c x_c^T = 1 / (f V) [sum_s (T + c dL/dt) d d^T / L + ...],
/// its springs and dampers, as far as they are its own (CellSprings), its volume force, a pressure, and its
/// guard against folding; or its finite elements. Of a virial that is not symmetric, as those of linear
/// elements and of Mollemans's force are, the symmetric part. V is the cell's volume now (trilinear_volume),
/// f its filled share: the stress is that of the material, of several parts their mean. Where strain is
/// uniform and nothing moves it is dW/dF F^T / det F of the stored energy W. Thompson, Plimpton and Mattson,
/// J. Chem. Phys. 131 (2009), 154107, without their kinetic term: cells move with what is in them.
///
/// It has no meaning where a cell is inside out, and no bound where its volume vanishes. In single precision
/// it errs by some 1e-7 of the moduli. Nothing where the model has no virials of cells. Ghosts must be up to
/// date.
using CellStress = std::optional<std::vector<Eigen::Matrix3d>>;
template <class Real>
CellStress cell_stress(const SolidSystem<Real>& system, const State<Real>& state);

/// The stress in uniaxial tension that has as much energy of distortion: sqrt(3/2) of the deviator's norm.
double von_mises(const Eigen::Matrix3d& stress);

}  // namespace mss

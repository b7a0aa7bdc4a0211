#pragma once

#include <vector>

#include "core/base/field.hpp"
#include "core/body/body.hpp"

// How far cells are distorted. Ghosts of other ranks must be up to date.

namespace mss {

/// Largest | |d|/L0 - 1 | of a spring that the lattices have, whatever fills their cells.
template <class Real>
double max_stretch(const std::vector<Level>& levels, const Field<Real>& x);

/// Smallest signed volume of a cell corner's three edges, over that at rest: 1 at rest, 0 or less where a
/// cell is inverted.
template <class Real>
double min_jacobian(const std::vector<Level>& levels, const Field<Real>& x);

}  // namespace mss

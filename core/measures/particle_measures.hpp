#pragma once

#include "core/body/body.hpp"

namespace mss {

// Numbers per particle of a level for the colours of a picture, at positions x [m] of the whole. The largest
// stretch and the smallest Jacobian of all particles are those of Measures.

/// Largest | |d|/L0 - 1 | of the springs that end in the particle at a site.
double stretch_at(const Level& level, const Field<double>& x, std::ptrdiff_t site);

/// Mean volume of the cells that touch the particle at a site, over their volume at rest.
double volume_ratio_at(const Level& level, const Field<double>& x, std::ptrdiff_t site);

/// Smallest signed volume that the edges of a cell span at the particle at a site, over h^3.
double jacobian_at(const Level& level, const Field<double>& x, std::ptrdiff_t site);

}  // namespace mss

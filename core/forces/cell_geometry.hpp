#pragma once

#include <array>

#include "core/base/field.hpp"

namespace mss {

/// Volume of the trilinear hexahedron with corners c = bx + 2 by + 4 bz [m^3]; exact for curved faces.
double trilinear_volume(const std::array<Vec3, 8>& corners);

/// The thesis's estimate of the same, eq. 3-5 and 3-6: one-point quadrature.
double thesis_volume(const std::array<Vec3, 8>& corners);

/// Signed volume spanned by the three edges at a corner [m^3]; h^3 at rest, negative where the cell is
/// inverted.
double corner_volume(const std::array<Vec3, 8>& corners, int corner);

}  // namespace mss

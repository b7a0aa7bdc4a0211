#pragma once

// The volume force of a cell for the loops that compute it, of vectors of any kind with +, - and cross(): eq.
// 3-7 is the gradient of k_vol (V - V0)^2 / (2 V0), V = X.(Y x Z) by the mean edges X, Y, Z of eq. 3-5. The
// same for single cells is in cell_geometry.hpp. Nothing here may call an inline function of the standard
// library, see kernel_number.hpp.

#include "core/base/formula.hpp"

namespace mss {

#include "core/forces/cell_formulas.inc"

/// Four times the mean edges, from the body diagonals a = 7-0, b = 6-1, c = 5-2, d = 4-3.
template <class Vector>
struct Edges {
  Vector x, y, z;
  MSS_INLINE Edges(const Vector& a, const Vector& b, const Vector& c, const Vector& d)
      : x(mean_edge_x(a, b, c, d)), y(mean_edge_y(a, b, c, d)), z(mean_edge_z(a, b, c, d)) {}
};

/// The gradient of X.(Y x Z) by X, Y and Z.
template <class Vector>
struct EdgeSlopes {
  Vector x, y, z;
  MSS_INLINE explicit EdgeSlopes(const Edges<Vector>& e)
      : x(slope_by_edge(e.y, e.z)), y(slope_by_edge(e.z, e.x)), z(slope_by_edge(e.x, e.y)) {}
};

/// What corner 0, 1, 2 or 3 gets of a gradient by X, Y and Z, over -1/4; the opposite corners 7 to 4 get the
/// opposite.
template <int corner, class Vector>
MSS_INLINE Vector at_corner(const Vector& x, const Vector& y, const Vector& z) {
  static_assert(corner >= 0 && corner < 4);
  if constexpr (corner == 0) return at_corner_0(x, y, z);
  if constexpr (corner == 1) return at_corner_1(x, y, z);
  if constexpr (corner == 2) return at_corner_2(x, y, z);
  if constexpr (corner == 3) return at_corner_3(x, y, z);
}
template <int corner, class Vector>
MSS_INLINE Vector at_corner(const EdgeSlopes<Vector>& by) {
  return at_corner<corner>(by.x, by.y, by.z);
}

}  // namespace mss

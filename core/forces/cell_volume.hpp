#pragma once

// The volume force of a cell for the loops that compute it, of vectors of any kind with +, - and cross(): eq.
// 3-7 is the gradient of k_vol (V - V0)^2 / (2 V0), V = X.(Y x Z) by the mean edges X, Y, Z of eq. 3-5. The
// same for single cells is in cell_geometry.hpp. Nothing here may call an inline function of the standard
// library, see kernel_number.hpp.

#include "core/base/kernel_number.hpp"

namespace mss {

/// Four times the mean edges, from the body diagonals a = 7-0, b = 6-1, c = 5-2, d = 4-3.
template <class Vector>
struct Edges {
  Vector x, y, z;
  MSS_INLINE Edges(const Vector& a, const Vector& b, const Vector& c, const Vector& d)
      : Edges((a - b) + (c - d), a + b, c + d) {}

 private:
  MSS_INLINE Edges(const Vector& along_x, const Vector& ab, const Vector& cd)
      : x(along_x), y(ab - cd), z(ab + cd) {}
};

/// The gradient of X.(Y x Z) by X, Y and Z.
template <class Vector>
struct EdgeSlopes {
  Vector x, y, z;
  MSS_INLINE explicit EdgeSlopes(const Edges<Vector>& e)
      : x(cross(e.y, e.z)), y(cross(e.z, e.x)), z(cross(e.x, e.y)) {}
};

/// What corner 0, 1, 2 or 3 gets of a gradient by X, Y and Z, over -1/4; the opposite corners 7 to 4 get the
/// opposite.
template <int corner, class Vector>
MSS_INLINE Vector at_corner(const Vector& x, const Vector& y, const Vector& z) {
  static_assert(corner >= 0 && corner < 4);
  if constexpr (corner == 0) return (z + y) + x;
  if constexpr (corner == 1) return (z + y) - x;
  if constexpr (corner == 2) return (z - y) + x;
  if constexpr (corner == 3) return (z - y) - x;
}
template <int corner, class Vector>
MSS_INLINE Vector at_corner(const EdgeSlopes<Vector>& by) {
  return at_corner<corner>(by.x, by.y, by.z);
}

}  // namespace mss

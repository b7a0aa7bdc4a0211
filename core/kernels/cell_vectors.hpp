#pragma once

// Vectors of three packs, and what kernels over cells share: the springs of a site. Included once per
// instruction set, see simd.hpp.

#include "core/forces/cell_volume.hpp"
#include "core/forces/spring_law.hpp"
#include "core/kernels/simd.hpp"
#include "core/kernels/sweep.hpp"

namespace mss::MSS_ISA {

template <class Real>
struct Vec {
  Pack<Real> x, y, z;
};
template <class Real>
MSS_INLINE Vec<Real> operator-(const Vec<Real>& a, const Vec<Real>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class Real>
MSS_INLINE Vec<Real> operator+(const Vec<Real>& a, const Vec<Real>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class Real>
MSS_INLINE Vec<Real> operator-(const Vec<Real>& a) {
  return {-a.x, -a.y, -a.z};
}
template <class Real>
MSS_INLINE Vec<Real> operator*(Pack<Real> s, const Vec<Real>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class Real>
MSS_INLINE Pack<Real> dot(const Vec<Real>& a, const Vec<Real>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
/// a.a, a little more than zero: sites without a particle may coincide, and 0 * infinity must not arise
/// there.
template <class Real>
MSS_INLINE Pack<Real> squared_norm(const Vec<Real>& a) {
  return a.x * a.x + (a.y * a.y + (a.z * a.z + Real(1e-30)));
}
template <class Real>
MSS_INLINE Vec<Real> cross(const Vec<Real>& a, const Vec<Real>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class Real>
MSS_INLINE Vec<Real> load(const ConstStreams<Real>& s, std::ptrdiff_t i) {
  return {load(s.axis[0] + i), load(s.axis[1] + i), load(s.axis[2] + i)};
}
template <class Real>
MSS_INLINE Vec<Real> load(const Streams<Real>& s, std::ptrdiff_t i) {
  return {load(s.axis[0] + i), load(s.axis[1] + i), load(s.axis[2] + i)};
}
template <class Real>
MSS_INLINE void store(const Streams<Real>& s, std::ptrdiff_t i, const Vec<Real>& v) {
  store(s.axis[0] + i, v.x);
  store(s.axis[1] + i, v.y);
  store(s.axis[2] + i, v.z);
}
template <class Real>
MSS_INLINE Vec<Real> shift_in(const Vec<Real>& previous, const Vec<Real>& v) {
  return {shift_in(previous.x, v.x), shift_in(previous.y, v.y), shift_in(previous.z, v.z)};
}

/// Symmetric 3 x 3 matrices.
template <class Real>
struct Symmetric {
  Pack<Real> xx, yy, zz, yz, zx, xy;

  MSS_INLINE void add(Pack<Real> scale, const Vec<Real>& d) {
    const Vec<Real> s = scale * d;
    xx = xx + s.x * d.x;
    yy = yy + s.y * d.y;
    zz = zz + s.z * d.z;
    yz = yz + s.y * d.z;
    zx = zx + s.z * d.x;
    xy = xy + s.x * d.y;
  }
  MSS_INLINE void add_identity(Pack<Real> scale) {
    xx = xx + scale;
    yy = yy + scale;
    zz = zz + scale;
  }
  MSS_INLINE Pack<Real> determinant() const {
    return xx * (yy * zz - yz * yz) + (xy * (zx * yz - xy * zz) + zx * (xy * yz - zx * yy));
  }
  /// By cofactors, of the matrix over xx, so that they do not overflow in single precision.
  MSS_INLINE Vec<Real> solve(const Vec<Real>& b) const {
    const Pack<Real> unit = Real(1) / xx, y = unit * yy, z = unit * zz, p = unit * yz, q = unit * zx,
                     r = unit * xy;
    const Pack<Real> axx = y * z - p * p, axy = q * p - r * z, azx = r * p - q * y, ayy = z - q * q,
                     ayz = r * q - p, azz = y - r * r;
    const Pack<Real> scale = unit / (axx + (r * axy + q * azx));
    return scale * Vec<Real>{axx * b.x + (axy * b.y + azx * b.z), axy * b.x + (ayy * b.y + ayz * b.z),
                             azx * b.x + (ayz * b.y + azz * b.z)};
  }
};

/// The corners each of a site's thirteen springs joins, in the order of mss::spring_slots.
inline constexpr int spring_ends[springs_per_site][2] = {
    {0, 1}, {0, 2}, {0, 4}, {0, 3}, {0, 5}, {0, 6}, {1, 2}, {1, 4}, {2, 4}, {0, 7}, {1, 6}, {2, 5}, {3, 4}};

/// The group of each, in the order of mss::slot_of_group.
inline constexpr int spring_group[springs_per_site] = {0, 1, 2, 3, 4, 5, 3, 4, 5, 6, 6, 6, 6};

template <class Real>
MSS_INLINE Pack<Real> positive_part(Pack<Real> a) {
  const Pack<Real> zero{};
  return a > zero ? a : zero;
}

}  // namespace mss::MSS_ISA

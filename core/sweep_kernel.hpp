#pragma once

// The structured sweep: all spring, damping and volume forces of a lattice body in one pass, and the update of a
// particle as soon as its force is complete. Included once per instruction set, see simd.hpp.
//
// A block is W sites that follow each other in a plane. For each site the sweep evaluates the thirteen springs and
// the volume force of the cell whose lower corner it is. Corner c = bx + 2 by + 4 bz of that cell is another site,
// and what it receives is passed on:
//   (x+1) corners one lane further, by shift_in, the last lane through `carry`;
//   (y+1) corners to `own`, one row further; (z+1) corners to `above`, for the next plane.
// A site's force is complete when its own block is done and the sums from the plane below are there. The order of
// additions does not depend on where a thread's slab begins, so results are the same bits for any thread count.
//
// Contraction of a*b+c into fused multiply-adds is on here (-ffp-contract=fast), the rest of fast-math is not.

#include "core/simd.hpp"
#include "core/sweep.hpp"

namespace mss::MSS_ISA {

template <class Real>
struct Vec {
  Pack<Real> x, y, z;
};
template <class Real>
[[gnu::always_inline]] inline Vec<Real> operator-(const Vec<Real>& a, const Vec<Real>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class Real>
[[gnu::always_inline]] inline Vec<Real> operator+(const Vec<Real>& a, const Vec<Real>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class Real>
[[gnu::always_inline]] inline Vec<Real> operator*(Pack<Real> s, const Vec<Real>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class Real>
[[gnu::always_inline]] inline Pack<Real> dot(const Vec<Real>& a, const Vec<Real>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class Real>
[[gnu::always_inline]] inline Vec<Real> cross(const Vec<Real>& a, const Vec<Real>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class Real>
[[gnu::always_inline]] inline Vec<Real> load(const ConstStreams<Real>& s, std::ptrdiff_t i) {
  return {load(s.axis[0] + i), load(s.axis[1] + i), load(s.axis[2] + i)};
}
template <class Real>
[[gnu::always_inline]] inline Vec<Real> load(const Streams<Real>& s, std::ptrdiff_t i) {
  return {load(s.axis[0] + i), load(s.axis[1] + i), load(s.axis[2] + i)};
}
template <class Real>
[[gnu::always_inline]] inline void store(const Streams<Real>& s, std::ptrdiff_t i, const Vec<Real>& v) {
  store(s.axis[0] + i, v.x);
  store(s.axis[1] + i, v.y);
  store(s.axis[2] + i, v.z);
}
template <class Real>
[[gnu::always_inline]] inline Vec<Real> shift_in(const Vec<Real>& previous, const Vec<Real>& v) {
  return {shift_in(previous.x, v.x), shift_in(previous.y, v.y), shift_in(previous.z, v.z)};
}

/// The corners of W neighbouring cells and one block's coefficients.
template <class Real, bool Damped>
struct Block {
  static constexpr int W = lanes<Real>;
  const SweepPlane<Real>& p;
  const Real* coefficient;
  std::ptrdiff_t corner[8];
  Vec<Real> force[8];

  [[gnu::always_inline]] Vec<Real> d(int a, int b) const { return load(p.x, corner[b]) - load(p.x, corner[a]); }

  /// Force of spring `slot` between corners a and b, divided by d. Eq. 2-3 and 2-5, with 2-6 as a projection.
  [[gnu::always_inline]] Pack<Real> tension(int slot, int a, int b, const Vec<Real>& d) const {
    // Sites without a particle may coincide; the smallest safe number keeps 0 * infinity away from them.
    const Pack<Real> r = rsqrt(dot(d, d) + Real(1e-30));
    const Real* c = coefficient + 3 * W * slot;
    const Pack<Real> k = load(c), k_rest = load(c + W);
    if constexpr (Damped) {
      const Vec<Real> u = load(p.v, corner[b]) - load(p.v, corner[a]);
      return k + r * (load(c + 2 * W) * (r * dot(d, u)) - k_rest);
    } else {
      return k - r * k_rest;
    }
  }

  [[gnu::always_inline]] void spring(int slot, int a, int b) {
    const Vec<Real> s = d(a, b);
    const Pack<Real> f = tension(slot, a, b, s);
    force[a] = force[a] + f * s;
    force[b] = force[b] - f * s;
  }

  /// Body diagonals and the volume force, which push opposite corners oppositely: sets all eight forces.
  ///
  /// With the diagonals a = 7-0, b = 6-1, c = 5-2, d = 4-3 the mean edges of eq. 3-5 are
  ///   4X = a - b + c - d,  4Y = a + b - c - d,  4Z = a + b + c + d,
  /// and eq. 3-7 is the gradient of k_vol (V - V0)^2 / (2 V0), V = X.(Y x Z).
  [[gnu::always_inline]] void cell() {
    const Vec<Real> a = d(0, 7), b = d(1, 6), c = d(2, 5), e = d(3, 4);
    const Vec<Real> x = (a - b) + (c - e), y = (a + b) - (c + e), z = (a + b) + (c + e);
    const Vec<Real> yz = cross(y, z), zx = cross(z, x), xy = cross(x, y);
    // The edges are four times too long: V is 64 and a face 16 times too large; k_vol / (4 V0) makes up for that.
    const Pack<Real> volume = Real(1.0 / 64) * dot(x, yz);
    const Pack<Real> pressure = load(coefficient + 3 * W * springs_per_site) * (volume - p.rest_volume);
    const Vec<Real> px = pressure * yz, py = pressure * zx, pz = pressure * xy;
    const Vec<Real> ha = tension(9, 0, 7, a) * a + (pz + py + px);
    const Vec<Real> hb = tension(10, 1, 6, b) * b + (pz + py - px);
    const Vec<Real> hc = tension(11, 2, 5, c) * c + (pz - py + px);
    const Vec<Real> he = tension(12, 3, 4, e) * e + (pz - py - px);
    const Vec<Real> zero{};
    force[0] = ha;
    force[1] = hb;
    force[2] = hc;
    force[3] = he;
    force[4] = zero - he;
    force[5] = zero - hc;
    force[6] = zero - hb;
    force[7] = zero - ha;
  }

  [[gnu::always_inline]] void faces() {
    spring(3, 0, 3);
    spring(4, 1, 2);
    spring(5, 0, 5);
    spring(6, 1, 4);
    spring(7, 0, 6);
    spring(8, 2, 4);
  }

  [[gnu::always_inline]] void edges() {
    spring(0, 0, 1);
    spring(1, 0, 2);
    spring(2, 0, 4);
  }
};

template <class Real, bool Damped>
void sweep_blocks(SweepPlane<Real>& p) {
  constexpr int W = lanes<Real>;
  const std::ptrdiff_t row = p.row, plane = p.plane;
  // A block longer than a row meets its own (y+1) corners: their sums are then added to, not begun.
  const bool narrow = row < W;
  Vec<Real> carry[4] = {};
  for (int i = 0; i < 4; ++i) {
    carry[i].x[W - 1] = p.carry[i][0];
    carry[i].y[W - 1] = p.carry[i][1];
    carry[i].z[W - 1] = p.carry[i][2];
  }
  for (std::ptrdiff_t b = p.first_block; b < p.last_block; ++b) {
    const std::ptrdiff_t q = b * W;
    const std::uint32_t entry = p.entry[b];
    const std::uint32_t content = p.content[entry];
    Block<Real, Damped> block{
        p,
        p.dictionary + std::ptrdiff_t(entry) * (coefficients_per_lane * W),
        {q, q + 1, q + row, q + row + 1, q + plane, q + plane + 1, q + plane + row, q + plane + row + 1},
        {}};
    if ((content & block_cells) != 0) block.cell();
    if ((content & block_faces) != 0) block.faces();
    if ((content & block_edges) != 0) block.edges();
    const auto& f = block.force;
    const Vec<Real> y = f[2] + shift_in(carry[1], f[3]), yz = f[6] + shift_in(carry[3], f[7]);
    store(p.own, q, load(p.own, q) + (f[0] + shift_in(carry[0], f[1])));
    store(p.above, q, load(p.above, q) + (f[4] + shift_in(carry[2], f[5])));
    if (narrow) {
      store(p.own, q + row, load(p.own, q + row) + y);
      store(p.above, q + row, load(p.above, q + row) + yz);
    } else {
      store(p.own, q + row, y);
      store(p.above, q + row, yz);
    }
    carry[0] = f[1];
    carry[1] = f[3];
    carry[2] = f[5];
    carry[3] = f[7];
  }
  for (int i = 0; i < 4; ++i) {
    p.carry[i][0] = carry[i].x[W - 1];
    p.carry[i][1] = carry[i].y[W - 1];
    p.carry[i][2] = carry[i].z[W - 1];
  }
}

template <class Real>
void sweep_damped(SweepPlane<Real>& p) {
  sweep_blocks<Real, true>(p);
}
template <class Real>
void sweep_undamped(SweepPlane<Real>& p) {
  sweep_blocks<Real, false>(p);
}

template <class Real>
[[gnu::always_inline]] inline Vec<Real> total_force(const FinishPlane<Real>& p, std::ptrdiff_t q) {
  return load(p.own, q) + load(p.below, q);
}

/// f / m + g where there is a particle, 0 elsewhere.
template <class Real>
[[gnu::always_inline]] inline Vec<Real> acceleration(const FinishPlane<Real>& p, std::ptrdiff_t q) {
  const Pack<Real> zero{};
  const Pack<Real> inverse_mass = load(p.inverse_mass + q);
  const auto present = inverse_mass > zero;
  const Vec<Real> gravity{present ? zero + p.gravity[0] : zero, present ? zero + p.gravity[1] : zero,
                          present ? zero + p.gravity[2] : zero};
  return inverse_mass * total_force(p, q) + gravity;
}

template <class Real>
[[gnu::always_inline]] inline void update(const FinishPlane<Real>& p, std::ptrdiff_t q, const Vec<Real>& a) {
  const Vec<Real> zero{};
  const Vec<Real> v_old = load(p.v, q);
  const Vec<Real> v_new = (v_old + (zero.x + p.kick_before) * a) + (zero.x + p.kick_after) * a;
  const Vec<Real> step = (zero.x + p.drift_old) * v_old + (zero.x + p.drift_new) * v_new;
  store(p.v, q, v_new);
  store(p.x, q, load(p.x, q) + step);
}

template <class Real>
void store_force(const FinishPlane<Real>& p) {
  for (std::ptrdiff_t q = p.first; q < p.last; q += lanes<Real>) store(p.out, q, total_force(p, q));
}
template <class Real>
void store_acceleration(const FinishPlane<Real>& p) {
  for (std::ptrdiff_t q = p.first; q < p.last; q += lanes<Real>) store(p.out, q, acceleration(p, q));
}
template <class Real>
void kick_drift(const FinishPlane<Real>& p) {
  for (std::ptrdiff_t q = p.first; q < p.last; q += lanes<Real>) update(p, q, acceleration(p, q));
}
template <class Real>
void kick_drift_stored(const FinishPlane<Real>& p) {
  for (std::ptrdiff_t q = p.first; q < p.last; q += lanes<Real>) update(p, q, load(p.own, q));
}

template <class Real>
SweepKernel<Real> make_kernel(const char* name) {
  return {name,
          lanes<Real>,
          sweep_damped<Real>,
          sweep_undamped<Real>,
          store_force<Real>,
          store_acceleration<Real>,
          kick_drift<Real>,
          kick_drift_stored<Real>};
}

}  // namespace mss::MSS_ISA

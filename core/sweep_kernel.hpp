#pragma once

// The structured sweep: all spring, damping and volume forces of a lattice body in one pass, and the update
// of a particle as soon as its force is complete. Included once per instruction set, see simd.hpp.
//
// A block is W sites that follow each other in a plane. For each site the sweep evaluates the thirteen
// springs and the volume force of the cell whose lower corner it is. Corner c = bx + 2 by + 4 bz of that cell
// is another site, and what it receives is passed on:
//   (x+1) corners one lane further, by shift_in, the last lane through `carry`;
//   (y+1) corners to `own`, one row further; (z+1) corners to `above`, for the next plane.
// A site's force is complete when its own block is done and the sums from the plane below are there. The
// order of additions does not depend on where a thread's slab begins, so results are the same bits for any
// thread count.
//
// Contraction of a*b+c into fused multiply-adds is on here (-ffp-contract=fast), the rest of fast-math is
// not.

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
[[gnu::always_inline]] inline Vec<Real> operator-(const Vec<Real>& a) {
  return {-a.x, -a.y, -a.z};
}
template <class Real>
[[gnu::always_inline]] inline Vec<Real> operator*(Pack<Real> s, const Vec<Real>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class Real>
[[gnu::always_inline]] inline Pack<Real> dot(const Vec<Real>& a, const Vec<Real>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
/// a.a, a little more than zero: sites without a particle may coincide, and 0 * infinity must not arise
/// there.
template <class Real>
[[gnu::always_inline]] inline Pack<Real> squared_norm(const Vec<Real>& a) {
  return a.x * a.x + (a.y * a.y + (a.z * a.z + Real(1e-30)));
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

/// The corners each of a site's thirteen springs joins, in the order of mss::spring_slots.
inline constexpr int spring_ends[springs_per_site][2] = {
    {0, 1}, {0, 2}, {0, 4}, {0, 3}, {0, 5}, {0, 6}, {1, 2}, {1, 4}, {2, 4}, {0, 7}, {1, 6}, {2, 5}, {3, 4}};

/// W neighbouring cells: where their corners are, and their coefficients.
template <class Real, bool Damped>
struct Block {
  static constexpr int W = lanes<Real>;
  const SweepPlane<Real>& p;
  const Real* coefficient;
  std::ptrdiff_t corner[8];

  [[gnu::always_inline]] Vec<Real> difference(const ConstStreams<Real>& s, int spring) const {
    return load(s, corner[spring_ends[spring][1]]) - load(s, corner[spring_ends[spring][0]]);
  }

  /// Differences d along the springs and what they pull with, divided by |d|: eq. 2-3 and 2-5, with 2-6 as a
  /// projection. Several springs at a time, stage by stage: one alone is a chain of operations too long for
  /// the processor to see past its end.
  template <int N>
  [[gnu::always_inline]] void tensions(const int (&spring)[N], Vec<Real> (&d)[N], Pack<Real> (&f)[N]) const {
    Pack<Real> r[N];
    for (int i = 0; i < N; ++i) d[i] = difference(p.x, spring[i]);
    for (int i = 0; i < N; ++i) r[i] = scaled_rsqrt(squared_norm(d[i]));
    for (int i = 0; i < N; ++i) {
      const Real* c = coefficient + 3 * W * spring[i];
      const Pack<Real> k = load(c), k_rest = load(c + W);
      if constexpr (Damped)
        f[i] = k + r[i] * ((load(c + 2 * W) * dot(d[i], difference(p.v, spring[i]))) * r[i] - k_rest);
      else
        f[i] = k - r[i] * k_rest;
    }
  }

  /// Forces of springs on their first corners.
  template <int N>
  [[gnu::always_inline]] void pulls(const int (&spring)[N], Vec<Real> (&g)[N]) const {
    Pack<Real> f[N];
    tensions(spring, g, f);
    for (int i = 0; i < N; ++i) g[i] = f[i] * g[i];
  }

  /// Forces of body diagonals and volume on corners 0 to 3; corners 7 to 4 receive the opposite.
  ///
  /// With the diagonals a = 7-0, b = 6-1, c = 5-2, d = 4-3 the mean edges of eq. 3-5 are
  ///   4X = a - b + c - d,  4Y = a + b - c - d,  4Z = a + b + c + d,
  /// and eq. 3-7 is the gradient of k_vol (V - V0)^2 / (2 V0), V = X.(Y x Z).
  [[gnu::always_inline]] void cell(Vec<Real> (&h)[4]) const {
    Vec<Real> d[4];
    Pack<Real> f[4];
    tensions({9, 10, 11, 12}, d, f);
    const Vec<Real> sum = d[0] + d[1], difference = d[0] - d[1], other_sum = d[2] + d[3];
    const Vec<Real> x = difference + (d[2] - d[3]), y = sum - other_sum, z = sum + other_sum;
    const Vec<Real> yz = cross(y, z), zx = cross(z, x), xy = cross(x, y);
    // The edges are four times too long: V is 64 and a face 16 times too large; k_vol / (4 V0) makes up for
    // that.
    const Pack<Real> volume = Real(1.0 / 64) * dot(x, yz);
    const Pack<Real> pressure = load(coefficient + 3 * W * springs_per_site) * (volume - p.rest_volume);
    const Vec<Real> px = pressure * yz, upper = pressure * (xy + zx), lower = pressure * (xy - zx);
    h[0] = f[0] * d[0] + (upper + px);
    h[1] = f[1] * d[1] + (upper - px);
    h[2] = f[2] * d[2] + (lower + px);
    h[3] = f[3] * d[3] + (lower - px);
  }
};

/// The last (x+1) corners' forces of a block: own, own one row on, above, above one row on.
template <class Real>
struct Carry {
  Vec<Real> x[4];
};

/// One block. The springs come in the order in which their sums can be passed on, so that few stay open.
template <class Real, bool Damped, std::uint32_t Content>
[[gnu::always_inline]] inline void do_block(const SweepPlane<Real>& p, std::ptrdiff_t q,
                                            const Real* coefficient, Carry<Real>& carry) {
  constexpr bool edges = (Content & block_edges) != 0, faces = (Content & block_faces) != 0,
                 cells = (Content & block_cells) != 0;
  const std::ptrdiff_t row = p.row, plane = p.plane;
  const bool narrow =
      row < lanes<Real>;  // a block longer than a row meets its own (y+1) corners: it adds to their sums
  const Block<Real, Damped> block{
      p,
      coefficient,
      {q, q + 1, q + row, q + row + 1, q + plane, q + plane + 1, q + plane + row, q + plane + row + 1}};

  Vec<Real> h[4] = {};
  if constexpr (cells) block.cell(h);
  Vec<Real> f0 = h[0], f1 = h[1], f2 = h[2], f3 = h[3], f4 = -h[3], f5 = -h[2], f6 = -h[1], f7 = -h[0];

  if constexpr (faces) {
    Vec<Real> g[3];
    block.pulls({2, 4, 5}, g);  // 0-4, 0-5, 0-6
    f0 = f0 + (g[0] + g[1] + g[2]);
    f4 = f4 - g[0];
    f5 = f5 - g[1];
    f6 = f6 - g[2];
  }
  const Vec<Real> yz = f6 + shift_in(carry.x[3], f7);
  store(p.above, q + row, narrow ? load(p.above, q + row) + yz : yz);

  if constexpr (faces) {
    Vec<Real> g[3];
    block.pulls({3, 7, 8}, g);  // 0-3, 1-4, 2-4
    f0 = f0 + g[0];
    f1 = f1 + g[1];
    f2 = f2 + g[2];
    f3 = f3 - g[0];
    f4 = f4 - (g[1] + g[2]);
  } else if constexpr (edges) {
    Vec<Real> g[1];
    block.pulls({2}, g);  // 0-4
    f0 = f0 + g[0];
    f4 = f4 - g[0];
  }
  store(p.above, q, load(p.above, q) + (f4 + shift_in(carry.x[2], f5)));

  if constexpr (faces) {
    Vec<Real> g[3];
    block.pulls({0, 1, 6}, g);  // 0-1, 0-2, 1-2
    f0 = f0 + (g[0] + g[1]);
    f1 = f1 - (g[0] - g[2]);
    f2 = f2 - (g[1] + g[2]);
  } else if constexpr (edges) {
    Vec<Real> g[2];
    block.pulls({0, 1}, g);  // 0-1, 0-2
    f0 = f0 + (g[0] + g[1]);
    f1 = f1 - g[0];
    f2 = f2 - g[1];
  }
  const Vec<Real> y = f2 + shift_in(carry.x[1], f3);
  store(p.own, q, load(p.own, q) + (f0 + shift_in(carry.x[0], f1)));
  store(p.own, q + row, narrow ? load(p.own, q + row) + y : y);
  carry = {{f1, f3, f5, f7}};
}

template <class Real, bool Damped>
void sweep_blocks(SweepPlane<Real>& argument) {
  constexpr int W = lanes<Real>;
  const SweepPlane<Real> p = argument;  // a copy that the stores below cannot reach
  Carry<Real> carry{};
  for (int i = 0; i < 4; ++i) {
    carry.x[i].x[W - 1] = p.carry[i][0];
    carry.x[i].y[W - 1] = p.carry[i][1];
    carry.x[i].z[W - 1] = p.carry[i][2];
  }
  for (std::ptrdiff_t b = p.first_block; b < p.last_block; ++b) {
    const std::uint32_t entry = p.entry[b];
    const Real* coefficient = p.dictionary + std::ptrdiff_t(entry) * (coefficients_per_lane * W);
    switch (p.content[entry]) {
      case 0:
        do_block<Real, Damped, 0>(p, b * W, coefficient, carry);
        break;
      case block_edges | block_faces:  // upper faces of the body, or neither body diagonals nor volume
        do_block<Real, Damped, block_edges | block_faces>(p, b * W, coefficient, carry);
        break;
      case block_edges | block_cells:  // no face diagonals
        do_block<Real, Damped, block_edges | block_cells>(p, b * W, coefficient, carry);
        break;
      default:
        do_block<Real, Damped, block_edges | block_faces | block_cells>(p, b * W, coefficient, carry);
    }
  }
  for (int i = 0; i < 4; ++i) {
    argument.carry[i][0] = carry.x[i].x[W - 1];
    argument.carry[i][1] = carry.x[i].y[W - 1];
    argument.carry[i][2] = carry.x[i].z[W - 1];
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
          rsqrt_scale<Real>,
          sweep_damped<Real>,
          sweep_undamped<Real>,
          store_force<Real>,
          store_acceleration<Real>,
          kick_drift<Real>,
          kick_drift_stored<Real>};
}

}  // namespace mss::MSS_ISA

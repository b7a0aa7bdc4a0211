#pragma once

// The structured sweep: all spring, damping and volume forces of a lattice body in one pass, and the update
// of a particle as soon as its force is complete. Included once per instruction set, see simd.hpp.
//
// A block is W sites that follow each other in a plane, see sweep_blocks.hpp. For each site the sweep
// evaluates the thirteen springs and the volume force of the cell whose lower corner it is. Corner c = bx + 2
// by + 4 bz of that cell is another site, and the forces on it are passed on:
//   (x+1) corners one lane further, by shift_in, the last lane through `carry`;
//   (y+1) corners to `own`, one row further; (z+1) corners to `above`, for the next plane.
// A site's force is complete when its own block is done and the sums from the plane below are there. The
// order of additions does not depend on where a thread's slab begins, so results are the same bits for any
// thread count.
//
// Contraction of a*b+c into fused multiply-adds is on here (-ffp-contract=fast), the rest of fast-math is
// not.

#include "core/forces/cell_fold_guard.hpp"
#include "core/kernels/cell_vectors.hpp"
#include "core/kernels/local_step_loops.hpp"
#include "core/kernels/sweep.hpp"

namespace mss::MSS_ISA {

/// GuardedCorner::may_act's bound on the volume of edges of these squared lengths in sum.
template <class Real>
MSS_INLINE Pack<Real> guarded_volume(Pack<Real> shortest, Pack<Real> squared) {
  const Pack<Real> shortest2 = shortest * shortest, most = Real(0.5) * (squared - shortest2);
  return shortest * (most > shortest2 ? most : shortest2);
}

/// A spring's stiffness and damping as b C + c K need them: across I + along d d^T.
template <class Real>
struct SpringBlock {
  Pack<Real> across, along;
};

/// W neighbouring cells: where their corners are, and their coefficients.
template <class Real>
struct Cells {
  static constexpr int W = lanes<Real>;
  const SweepPlane<Real>& p;
  const Real* coefficient;
  std::ptrdiff_t corner[8];

  MSS_INLINE Vec<Real> difference(const ConstStreams<Real>& s, int spring) const {
    return load(s, corner[spring_ends[spring][1]]) - load(s, corner[spring_ends[spring][0]]);
  }

  /// Springs in progress: differences d along them, |d|^2 and a first estimate of 1/|d|.
  template <int... Spring>
  struct PendingSprings {
    static constexpr int count = sizeof...(Spring);
    static constexpr int spring[count] = {Spring...};
    Vec<Real> d[count];
    Pack<Real> squared[count], estimate[count];
  };

  /// The first half of the work on a few springs.
  template <int... Spring>
  MSS_INLINE PendingSprings<Spring...> start() const {
    PendingSprings<Spring...> s;
    for (int i = 0; i < s.count; ++i) s.d[i] = difference(p.x, s.spring[i]);
    for (int i = 0; i < s.count; ++i) s.squared[i] = squared_norm(s.d[i]);
    for (int i = 0; i < s.count; ++i) s.estimate[i] = rsqrt_estimate(s.squared[i]);
    return s;
  }

  /// Whether any of them may have a corner near folding. Edges along x are (X + y P + z R + y z W) / 4 with y
  /// and z -1 or 1, those along y (Y + z Q + x P + z x W) / 4, and so on around. Those of a corner differ
  /// from the mean ones by no more than r, r^2 = 3/16 (2 P^2 + 2 Q^2 + 2 R^2 + 3 W^2), and so does its
  /// smallest stretch. GuardedCorner::may_act bounds that of the mean.
  MSS_INLINE bool is_near_folding() const {
    // In guarded lengths r is at most 7/2 r^2 + 1/14; a hundredth is for rounding.
    const Real begins = Real(1 / 14.0 + 1.01) * p.guarded_length, per_square = Real(3.5) / p.guarded_length;
    const Pack<Real> zero{};
    const auto guarded = guard_stiffness() > zero;
    const Vec<Real> a = difference(p.x, 9), b = difference(p.x, 10), c = difference(p.x, 11),
                    d = difference(p.x, 12), ab = ends_sum(9) - ends_sum(10),
                    cd = ends_sum(11) - ends_sum(12);
    const Edges<Vec<Real>> mean(a, b, c, d);
    const Vec<Real> mode_p = ab - cd, mode_q = (ends_sum(9) + ends_sum(10)) - (ends_sum(11) + ends_sum(12)),
                    mode_r = ab + cd, mode_w = (a - b) - (c - d);
    const Pack<Real> squared =
        Real(3.0 / 8) * (dot(mode_p, mode_p) + (dot(mode_q, mode_q) + dot(mode_r, mode_r))) +
        Real(9.0 / 16) * dot(mode_w, mode_w);
    const Pack<Real> length2 = dot(mean.x, mean.x) + (dot(mean.y, mean.y) + dot(mean.z, mean.z));
    const Pack<Real> bound = guarded_volume<Real>(per_square * squared + begins, Real(1.0 / 16) * length2);
    return any(guarded & (Real(1.0 / 64) * dot(mean.x, cross(mean.y, mean.z)) <= bound));
  }
  /// Where the two ends of a spring are, added.
  MSS_INLINE Vec<Real> ends_sum(int spring) const {
    return load(p.x, corner[spring_ends[spring][1]]) + load(p.x, corner[spring_ends[spring][0]]);
  }

  /// Of the group that a spring belongs to.
  MSS_INLINE Pack<Real> weight(int spring) const { return load(coefficient + W * spring_group[spring]); }
  MSS_INLINE Pack<Real> own_damping(int spring) const {
    return load(coefficient + W * (weights_per_lane + spring));
  }
  MSS_INLINE Pack<Real> spring_damping(int spring) const {
    return p.own_dampings ? own_damping(spring) : weight(spring) * p.interior.damping[spring];
  }
  /// T / |d|, with r = rsqrt_scale / |d|.
  MSS_INLINE Pack<Real> undamped_tension(int spring, Pack<Real> r) const {
    return weight(spring) * tension_over_length<Pack<Real>>(p.interior.stiffness[spring],
                                                            p.interior.rest_pull[spring],
                                                            p.interior.rest_length[spring], r);
  }
  MSS_INLINE Pack<Real> volume_stiffness() const {
    return p.interior.volume * load(coefficient + p.volume_weight);
  }
  MSS_INLINE Pack<Real> guard_stiffness() const {
    return p.interior.guard * load(coefficient + p.guard_weight);
  }

  /// For each cell, whether GuardedCorner::may_act() holds of any of its corners.
  MSS_INLINE auto guard_may_act() const {
    constexpr Real rounding = Real(1.01);
    const Pack<Real> shortest = Pack<Real>{} + rounding * p.guarded_length;
    const auto edge = [&](int c, int axis) {
      return load(p.x, corner[c | 1 << axis]) - load(p.x, corner[c & ~(1 << axis)]);
    };
    auto any_acts = shortest < Pack<Real>{};
    for (int c = 0; c < 8; ++c) {
      const Vec<Real> x = edge(c, 0), y = edge(c, 1), z = edge(c, 2);
      any_acts = any_acts |
                 (dot(x, cross(y, z)) <= guarded_volume<Real>(shortest, dot(x, x) + (dot(y, y) + dot(z, z))));
    }
    return any_acts;
  }
  /// Calls add(stiffness, lane, pull) for one cell after the other that its guard may act on, and adds the
  /// result to the cell's forces.
  template <class Add>
  MSS_INLINE void guard_each(Vec<Real> (&force)[8], Add&& add) const {
    const auto acts = guard_may_act();
    const Pack<Real> stiffnesses = guard_stiffness();
    for (int lane = 0; lane < W; ++lane) {
      const double stiffness = stiffnesses[lane];
      if (!(stiffness > 0) || !acts[lane]) continue;
      double pull[8][3] = {};
      add(stiffness, lane, pull);
      for (int c = 0; c < 8; ++c) {
        force[c].x[lane] += Real(pull[c][0]);
        force[c].y[lane] += Real(pull[c][1]);
        force[c].z[lane] += Real(pull[c][2]);
      }
    }
  }
  /// The corners of one of them.
  MSS_INLINE void gather(const ConstStreams<Real>& s, int lane, double (&at)[8][3]) const {
    for (int c = 0; c < 8; ++c)
      for (int a = 0; a < 3; ++a) at[c][a] = s.axis[a][corner[c] + lane];
  }

  /// The 3 x 3 block of spring i of those started, across I + along d d^T.
  template <bool Projected, int... Spring>
  MSS_INLINE SpringBlock<Real> spring_block(const PendingSprings<Spring...>& s, int i) const {
    constexpr Real unscale = 1 / (rsqrt_scale<Real> * rsqrt_scale<Real>);
    const Pack<Real> r = scaled_rsqrt(s.squared[i], s.estimate[i]);
    const int spring = s.spring[i];
    Pack<Real> across = undamped_tension(spring, r);
    if constexpr (Projected) across = positive_part<Real>(across);
    const Pack<Real> k = spring_stiffness<Pack<Real>>(weight(spring) * p.interior.stiffness[spring],
                                                      p.interior.rest_length[spring] * r);
    const Pack<Real> along = (unscale * p.stiffness) * (k - across) + p.damping * spring_damping(spring);
    return {p.stiffness * across, along * (r * r)};
  }

  /// Adds f to the first end of a spring and takes it from the second.
  MSS_INLINE static void add_spring_force(int spring, const Vec<Real>& f, Vec<Real> (&force)[8]) {
    const int* ends = spring_ends[spring];
    force[ends[0]] = force[ends[0]] + f;
    force[ends[1]] = force[ends[1]] - f;
  }
};

enum class Dampers { none, weighted, own };

/// Forces of springs and cells.
template <class Real, Dampers Damped>
struct Force : Cells<Real> {
  using Cells<Real>::W, Cells<Real>::p, Cells<Real>::coefficient;
  template <int... Spring>
  using PendingSprings = typename Cells<Real>::template PendingSprings<Spring...>;

  /// The second half: the force of spring i of them, divided by |d|. Eq. 2-3 and 2-5, with 2-6 as a
  /// projection.
  template <int... Spring>
  MSS_INLINE Pack<Real> tension(const PendingSprings<Spring...>& s, int i) const {
    const Pack<Real> r = scaled_rsqrt(s.squared[i], s.estimate[i]);
    const int spring = s.spring[i];
    if constexpr (Damped == Dampers::own) {
      const Pack<Real> w = this->weight(spring), k = w * p.interior.stiffness[spring],
                       k_rest = w * p.interior.rest_pull[spring];
      const Pack<Real> rate = this->own_damping(spring) * dot(s.d[i], this->difference(p.v, spring));
      return tension_over_length<Pack<Real>>(k, k_rest, p.interior.rest_length[spring], r, rate * r);
    } else if constexpr (Damped == Dampers::weighted) {
      const Pack<Real> rate = p.interior.damping[spring] * dot(s.d[i], this->difference(p.v, spring));
      return this->weight(spring) *
             tension_over_length<Pack<Real>>(p.interior.stiffness[spring], p.interior.rest_pull[spring],
                                             p.interior.rest_length[spring], r, rate * r);
    } else {
      return this->undamped_tension(spring, r);
    }
  }

  template <int... Spring>
  MSS_INLINE void pull(const PendingSprings<Spring...>& s, Vec<Real> (&force)[8]) const {
    for (int i = 0; i < s.count; ++i) this->add_spring_force(s.spring[i], tension(s, i) * s.d[i], force);
  }

  /// Body diagonals and the volume force, which push opposite corners oppositely: sets all eight forces.
  /// Eq. 3-7 is the gradient of k_vol (V - V0)^2 / (2 V0), V = X.(Y x Z).
  template <std::uint32_t Content>
  MSS_INLINE void cell(Vec<Real> (&force)[8]) const {
    const auto s = this->template start<9, 10>();
    const auto t = this->template start<11, 12>();
    Vec<Real> push[4] = {};
    if constexpr ((Content & block_volumes) != 0) {
      const Edges<Vec<Real>> e(s.d[0], s.d[1], t.d[0], t.d[1]);
      const EdgeSlopes<Vec<Real>> by(e);
      // The edges are four times too long: V is 64 and a face 16 times too large; k_vol / (4 V0) makes up for
      // that.
      const Pack<Real> volume = Real(1.0 / 64) * dot(e.x, by.x);
      const Pack<Real> pressure = this->volume_stiffness() * (volume - p.rest_volume);
      const Vec<Real> px = pressure * by.x, upper = pressure * (by.z + by.y),
                      lower = pressure * (by.z - by.y);
      push[0] = upper + px;  // at_corner() with fewer operations
      push[1] = upper - px;
      push[2] = lower + px;
      push[3] = lower - px;
    }
    if constexpr ((Content & block_bodies) != 0) {
      push[0] = tension(s, 0) * s.d[0] + push[0];
      push[1] = tension(s, 1) * s.d[1] + push[1];
      push[2] = tension(t, 0) * t.d[0] + push[2];
      push[3] = tension(t, 1) * t.d[1] + push[3];
    }
    for (int i = 0; i < 4; ++i) force[i] = push[i];
    for (int i = 0; i < 4; ++i) force[7 - i] = -force[i];
  }

  /// Pushes corners that are near folding apart, see fold_guard.hpp.
  void guard(Vec<Real> (&force)[8]) const {
    this->guard_each(force, [&](double stiffness, int lane, double(&pull)[8][3]) {
      double x[8][3];
      this->gather(p.x, lane, x);
      add_fold_guard_force(stiffness, p.guarded_length, x, pull);
    });
  }
};

/// How forces change, to first order, along the directions in p.v: -(b C + c K) times these. See
/// element_tangents.hpp for the matrices.
template <class Real, bool Projected>
struct ForceChange : Cells<Real> {
  using Cells<Real>::W, Cells<Real>::p, Cells<Real>::coefficient;
  template <int... Spring>
  using PendingSprings = typename Cells<Real>::template PendingSprings<Spring...>;

  /// across (e - u u.e) + along u u.e, of spring i, whose ends move apart by e.
  template <int... Spring>
  MSS_INLINE Vec<Real> response(const PendingSprings<Spring...>& s, int i, const Vec<Real>& e) const {
    const SpringBlock<Real> b = this->template spring_block<Projected>(s, i);
    return b.across * e + (b.along * dot(s.d[i], e)) * s.d[i];
  }

  template <int... Spring>
  MSS_INLINE void pull(const PendingSprings<Spring...>& s, Vec<Real> (&force)[8]) const {
    for (int i = 0; i < s.count; ++i)
      this->add_spring_force(s.spring[i], response(s, i, this->difference(p.v, s.spring[i])), force);
  }

  template <std::uint32_t>
  MSS_INLINE void cell(Vec<Real> (&force)[8]) const {
    const auto s = this->template start<9, 10>();
    const auto t = this->template start<11, 12>();
    const Vec<Real> change[4] = {this->difference(p.v, 9), this->difference(p.v, 10),
                                 this->difference(p.v, 11), this->difference(p.v, 12)};
    const Edges<Vec<Real>> e(s.d[0], s.d[1], t.d[0], t.d[1]), de(change[0], change[1], change[2], change[3]);
    const EdgeSlopes<Vec<Real>> by(e);
    Pack<Real> stiffness = p.stiffness * this->volume_stiffness();
    if constexpr (Projected) stiffness = positive_part<Real>(stiffness);
    const Pack<Real> swelling = Real(1.0 / 64) * (dot(de.x, by.x) + (dot(de.y, by.y) + dot(de.z, by.z)));
    Vec<Real> px = (stiffness * swelling) * by.x, py = (stiffness * swelling) * by.y,
              pz = (stiffness * swelling) * by.z;
    if constexpr (!Projected) {
      const Pack<Real> pressure = stiffness * (Real(1.0 / 64) * dot(e.x, by.x) - p.rest_volume);
      px = px + pressure * (cross(de.y, e.z) + cross(e.y, de.z));
      py = py + pressure * (cross(de.z, e.x) + cross(e.z, de.x));
      pz = pz + pressure * (cross(de.x, e.y) + cross(e.x, de.y));
    }
    force[0] = response(s, 0, change[0]) + at_corner<0>(px, py, pz);
    force[1] = response(s, 1, change[1]) + at_corner<1>(px, py, pz);
    force[2] = response(t, 0, change[2]) + at_corner<2>(px, py, pz);
    force[3] = response(t, 1, change[3]) + at_corner<3>(px, py, pz);
    for (int i = 0; i < 4; ++i) force[7 - i] = -force[i];
  }

  void guard(Vec<Real> (&force)[8]) const {
    this->guard_each(force, [&](double stiffness, int lane, double(&pull)[8][3]) {
      double x[8][3], u[8][3];
      this->gather(p.x, lane, x);
      this->gather(p.v, lane, u);
      add_fold_guard_change(p.stiffness * stiffness, p.guarded_length, x, u, Projected, pull);
    });
  }
};

/// The blocks on the diagonal of b C + c K in place of forces: their xx, yy, zz, or, if Mixed, yz, zx, xy.
template <class Real, bool Projected, bool Mixed>
struct DiagonalBlock : Cells<Real> {
  using Cells<Real>::p;
  template <int... Spring>
  using PendingSprings = typename Cells<Real>::template PendingSprings<Spring...>;

  /// The three numbers of d d^T.
  MSS_INLINE static Vec<Real> square(const Vec<Real>& d) {
    if constexpr (Mixed)
      return {d.y * d.z, d.z * d.x, d.x * d.y};
    else
      return {d.x * d.x, d.y * d.y, d.z * d.z};
  }
  template <int... Spring>
  MSS_INLINE Vec<Real> block_of(const PendingSprings<Spring...>& s, int i) const {
    const SpringBlock<Real> b = this->template spring_block<Projected>(s, i);
    const Vec<Real> along = b.along * square(s.d[i]);
    if constexpr (Mixed)
      return along;
    else
      return along + Vec<Real>{b.across, b.across, b.across};
  }

  template <int... Spring>
  MSS_INLINE void pull(const PendingSprings<Spring...>& s, Vec<Real> (&sums)[8]) const {
    for (int i = 0; i < s.count; ++i) {
      const Vec<Real> block = block_of(s, i);
      for (const int end : spring_ends[s.spring[i]]) sums[end] = sums[end] + block;
    }
  }

  template <std::uint32_t>
  MSS_INLINE void cell(Vec<Real> (&sums)[8]) const {
    const auto s = this->template start<9, 10>();
    const auto t = this->template start<11, 12>();
    const Edges<Vec<Real>> e(s.d[0], s.d[1], t.d[0], t.d[1]);
    const EdgeSlopes<Vec<Real>> by(e);
    Pack<Real> stiffness = Real(1.0 / 64) * p.stiffness * this->volume_stiffness();
    if constexpr (Projected) stiffness = positive_part<Real>(stiffness);
    sums[0] = stiffness * square(at_corner<0>(by)) + block_of(s, 0);
    sums[1] = stiffness * square(at_corner<1>(by)) + block_of(s, 1);
    sums[2] = stiffness * square(at_corner<2>(by)) + block_of(t, 0);
    sums[3] = stiffness * square(at_corner<3>(by)) + block_of(t, 1);
    for (int i = 0; i < 4; ++i) sums[7 - i] = sums[i];
  }

  void guard(Vec<Real> (&sums)[8]) const {
    this->guard_each(sums, [&](double stiffness, int lane, double(&pull)[8][3]) {
      double x[8][3], blocks[8][6] = {};
      this->gather(p.x, lane, x);
      add_fold_guard_diagonal(p.stiffness * stiffness, p.guarded_length, x, Projected, blocks);
      for (int c = 0; c < 8; ++c)
        for (int a = 0; a < 3; ++a) pull[c][a] += blocks[c][Mixed ? 3 + a : a];
    });
  }
};

/// The last (x+1) corners' forces of a block: own, own one row on, above, above one row on.
template <class Real>
struct Carry {
  Vec<Real> x[4];
};

/// Adds the forces on four corners of one plane to that plane's sums: corners `c`, of (x+1), (y+1), and both.
template <class Real>
MSS_INLINE void pass_on(const SweepPlane<Real>& p, const Streams<Real>& sums, std::ptrdiff_t q,
                        const Vec<Real> (&f)[8], const Carry<Real>& carry, int c) {
  const Vec<Real> y = f[c + 2] + shift_in(carry.x[c / 2 + 1], f[c + 3]);
  store(sums, q, load(sums, q) + (f[c] + shift_in(carry.x[c / 2], f[c + 1])));
  // A block longer than a row contains its own (y+1) corners: it adds to their sums instead of beginning
  // them.
  store(sums, q + p.row, p.row < lanes<Real> ? load(sums, q + p.row) + y : y);
}

template <class Block, class Real>
MSS_INLINE Block block_at(const SweepPlane<Real>& p, std::ptrdiff_t q, const Real* coefficient) {
  const std::ptrdiff_t row = p.row, plane = p.plane;
  return {{p,
           coefficient,
           {q, q + 1, q + row, q + row + 1, q + plane, q + plane + 1, q + plane + row, q + plane + row + 1}}};
}

/// What the guard against folding adds. Rare: it is a function of its own that takes copies, so
/// that the other values can stay in registers.
template <class Block, class Real>
[[gnu::noinline]] void push_apart(SweepPlane<Real> p, std::ptrdiff_t q, const Real* coefficient,
                                  Vec<Real> (&push)[8]) {
  block_at<Block>(p, q, coefficient).guard(push);
}

/// One block. A spring is one chain of dependent operations, and the processor looks ahead by only
/// about three springs: so they are computed in pairs, each started before the one before it is finished, and
/// those of the (z+1) corners first, so that their sums need not wait in registers.
template <class Block, std::uint32_t Content, class Real>
MSS_INLINE void do_block(const SweepPlane<Real>& p, std::ptrdiff_t q, const Real* coefficient,
                         Carry<Real>& carry) {
  const auto block = block_at<Block>(p, q, coefficient);
  bool near_folding = false;
  if constexpr ((Content & block_guards) != 0) near_folding = block.is_near_folding();
  Vec<Real> f[8] = {};
  if constexpr ((Content & (block_bodies | block_volumes)) != 0) block.template cell<Content>(f);
  if constexpr ((Content & block_guards) != 0)
    if (near_folding) [[unlikely]] {
      Vec<Real> push[8] = {};
      push_apart<Block>(p, q, coefficient, push);
      for (int c = 0; c < 8; ++c) f[c] = f[c] + push[c];
    }
  if constexpr ((Content & block_faces) != 0) {
    const auto s24 = block.template start<2, 4>();
    const auto s53 = block.template start<5, 3>();
    block.pull(s24, f);
    const auto s78 = block.template start<7, 8>();
    block.pull(s53, f);
    const auto s01 = block.template start<0, 1>();
    block.pull(s78, f);
    pass_on(p, p.above, q, f, carry, 4);
    const auto s6 = block.template start<6>();
    block.pull(s01, f);
    block.pull(s6, f);
  } else {
    if constexpr ((Content & block_edges) != 0) block.pull(block.template start<0, 1, 2>(), f);
    pass_on(p, p.above, q, f, carry, 4);
  }
  pass_on(p, p.own, q, f, carry, 0);
  carry = {{f[1], f[3], f[5], f[7]}};
}

/// Has the compiler keep it on the stack: twelve registers more are worth more inside a block.
template <class Real>
MSS_INLINE void keep_in_memory(Carry<Real>& carry) {
  asm("" : "+m"(carry));
}

template <class Real>
MSS_INLINE Carry<Real> carry_in(const SweepPlane<Real>& p) {
  constexpr int last = lanes<Real> - 1;
  Carry<Real> carry{};
  for (int i = 0; i < 4; ++i) {
    carry.x[i].x[last] = p.carry[i][0];
    carry.x[i].y[last] = p.carry[i][1];
    carry.x[i].z[last] = p.carry[i][2];
  }
  return carry;
}
template <class Real>
MSS_INLINE void carry_out(const Carry<Real>& carry, SweepPlane<Real>& p) {
  constexpr int last = lanes<Real> - 1;
  for (int i = 0; i < 4; ++i) {
    p.carry[i][0] = carry.x[i].x[last];
    p.carry[i][1] = carry.x[i].y[last];
    p.carry[i][2] = carry.x[i].z[last];
  }
}

template <class Real>
MSS_INLINE const Real* coefficients_of(const SweepPlane<Real>& p, std::uint32_t entry) {
  return p.dictionary + std::ptrdiff_t(entry) * p.entry_size;
}

/// Fetches the coefficients of the block after the next: bodies that are no boxes have more of them than a
/// second-level cache holds.
template <class Real>
MSS_INLINE void prefetch_coefficients(const SweepPlane<Real>& p, const std::uint32_t* entry,
                                      const Real* coefficient) {
  constexpr int line = 64 / int(sizeof(Real));
  const Real* next = coefficients_of(p, entry[2]);
  if (next == coefficient) return;
  for (int i = 0; i < p.entry_size; i += line) __builtin_prefetch(next + i);
}

/// Of any body. `Guards`: block_guards or 0.
template <class Block, std::uint32_t Guards, class Real>
void sweep_any(SweepPlane<Real>& argument) {
  constexpr std::uint32_t cells = block_bodies | block_volumes;
  const SweepPlane<Real> p = argument;  // a copy that the stores below cannot reach
  Carry<Real> carry = carry_in(p);
  const std::uint32_t* entry = p.entry;
  for (const BlockRun* run = p.first_run; run < p.last_run; ++run)
    for (std::ptrdiff_t q = run->first, last = run->last; q < last; q += lanes<Real>, ++entry) {
      const std::uint32_t kind = *entry;
      const Real* coefficient = coefficients_of(p, kind);
      const std::uint32_t content = p.content[kind];
      prefetch_coefficients(p, entry, coefficient);
      keep_in_memory(carry);
      if constexpr (Guards != 0)
        // Of force changes, which have no leaner sweep; without it here forces of full bodies are 4 to 6 %
        // slower.
        if (content == (block_edges | block_faces | Guards)) {
          do_block<Block, block_edges | block_faces | Guards>(p, q, coefficient, carry);
          continue;
        }
      switch (content) {
        case 0:
          do_block<Block, 0>(p, q, coefficient, carry);
          break;
        case block_edges:
          do_block<Block, block_edges>(p, q, coefficient, carry);
          break;
        case block_edges | block_faces:  // upper faces of the body, or neither body diagonals nor volume
          do_block<Block, block_edges | block_faces>(p, q, coefficient, carry);
          break;
        case block_edges | block_bodies | Guards:  // no face diagonals
        case block_edges | block_volumes | Guards:
        case block_edges | cells | Guards:
          do_block<Block, block_edges | cells | Guards>(p, q, coefficient, carry);
          break;
        default:
          do_block<Block, block_edges | block_faces | cells | Guards>(p, q, coefficient, carry);
      }
    }
  carry_out(carry, argument);
}

/// Of bodies whose cells contain no more than `Content` anywhere.
template <class Block, std::uint32_t Content, class Real>
void sweep_all_with(SweepPlane<Real>& argument) {
  constexpr std::uint32_t upper = Content & (block_edges | block_faces);  // faces of the body
  const SweepPlane<Real> p = argument;  // a copy that the stores below cannot reach
  Carry<Real> carry = carry_in(p);
  const std::uint32_t* entry = p.entry;
  for (const BlockRun* run = p.first_run; run < p.last_run; ++run)
    for (std::ptrdiff_t q = run->first, last = run->last; q < last; q += lanes<Real>, ++entry) {
      const std::uint32_t kind = *entry;
      const Real* coefficient = coefficients_of(p, kind);
      const std::uint32_t content = p.content[kind];
      prefetch_coefficients(p, entry, coefficient);
      keep_in_memory(carry);
      switch (content) {
        case 0:
          do_block<Block, 0>(p, q, coefficient, carry);
          break;
        case upper:
          do_block<Block, upper>(p, q, coefficient, carry);
          break;
        default:
          do_block<Block, Content>(p, q, coefficient, carry);
      }
    }
  carry_out(carry, argument);
}

template <class Real>
MSS_INLINE Vec<Real> total_force(const FinishPlane<Real>& p, std::ptrdiff_t q) {
  return load(p.own, q) + load(p.below, q);
}

/// f / m + g where there is a particle, 0 elsewhere.
template <class Real>
MSS_INLINE Vec<Real> acceleration(const FinishPlane<Real>& p, std::ptrdiff_t q) {
  const Pack<Real> zero{};
  const Pack<Real> inverse_mass = load(p.inverse_mass + q);
  const auto present = inverse_mass > zero;
  const Vec<Real> gravity{present ? zero + p.gravity[0] : zero, present ? zero + p.gravity[1] : zero,
                          present ? zero + p.gravity[2] : zero};
  return inverse_mass * total_force(p, q) + gravity;
}

template <class Real>
MSS_INLINE void update(const FinishPlane<Real>& p, std::ptrdiff_t q, const Vec<Real>& a) {
  const Vec<Real> zero{};
  const Vec<Real> v_old = load(p.v, q);
  const Vec<Real> v_new = (v_old + (zero.x + p.kick_before) * a) + (zero.x + p.kick_after) * a;
  const Vec<Real> step = (zero.x + p.drift_old) * v_old + (zero.x + p.drift_new) * v_new;
  store(p.v, q, v_new);
  store(p.x, q, load(p.x, q) + step);
}

/// Calls finish(q) of every block.
template <class Real, class Finish>
MSS_INLINE void finish_each_block(const FinishPlane<Real>& p, Finish&& finish) {
  for (const BlockRun* run = p.first_run; run < p.last_run; ++run)
    for (std::ptrdiff_t q = run->first, last = run->last; q < last; q += lanes<Real>) finish(q);
}

template <class Real>
void store_force(const FinishPlane<Real>& p) {
  finish_each_block(p, [&](std::ptrdiff_t q) { store(p.out, q, total_force(p, q)); });
}
template <class Real>
void store_acceleration(const FinishPlane<Real>& p) {
  finish_each_block(p, [&](std::ptrdiff_t q) { store(p.out, q, acceleration(p, q)); });
}
template <class Real>
void store_product(const FinishPlane<Real>& p) {
  const Pack<Real> zero{};
  finish_each_block(p, [&](std::ptrdiff_t q) {
    const Pack<Real> inverse_mass = load(p.inverse_mass + q);
    const Pack<Real> mass = inverse_mass > zero ? p.mass / inverse_mass : zero;
    store(p.out, q, mass * load(p.direction, q) - total_force(p, q));
  });
}
template <class Real>
void kick_drift(const FinishPlane<Real>& p) {
  finish_each_block(p, [&](std::ptrdiff_t q) { update(p, q, acceleration(p, q)); });
}
template <class Real>
void kick_drift_stored(const FinishPlane<Real>& p) {
  finish_each_block(p, [&](std::ptrdiff_t q) { update(p, q, load(p.own, q)); });
}

/// One for each content.
template <class Real, class Block>
ForceSweeps<Real> make_force_sweeps() {
  constexpr std::uint32_t faces = block_edges | block_faces;
  return {sweep_any<Block, 0, Real>, sweep_all_with<Block, faces, Real>,
          sweep_all_with<Block, faces | block_bodies, Real>,
          sweep_all_with<Block, faces | block_volumes, Real>,
          sweep_all_with<Block, block_edges | block_bodies | block_volumes, Real>};
}
/// Of bodies that are rarer, and worth less time to compile: a leaner one only where there are no body
/// diagonals, as in calibrated materials.
template <class Real, class Block, std::uint32_t Guards>
ForceSweeps<Real> make_few_force_sweeps() {
  const Sweep<Real> any = sweep_any<Block, Guards, Real>,
                    no_bodies =
                        sweep_all_with<Block, block_edges | block_faces | block_volumes | Guards, Real>;
  return {any, no_bodies, any, no_bodies, any};
}

template <class Real, std::uint32_t Guards, bool Projected>
typename Sweeps<Real>::DiagonalSweeps make_diagonal_sweeps() {
  return {sweep_any<DiagonalBlock<Real, Projected, false>, Guards, Real>,
          sweep_any<DiagonalBlock<Real, Projected, true>, Guards, Real>};
}

template <class Real, Dampers Damped, std::uint32_t Guards>
ForceSweeps<Real> force_sweeps() {
  if constexpr (Guards == 0 && Damped != Dampers::own)
    return make_force_sweeps<Real, Force<Real, Damped>>();
  else
    return make_few_force_sweeps<Real, Force<Real, Damped>, Guards>();
}

/// `Guards`: block_guards or 0.
template <class Real, std::uint32_t Guards>
Sweeps<Real> make_sweeps() {
  return {force_sweeps<Real, Dampers::own, Guards>(),       force_sweeps<Real, Dampers::weighted, Guards>(),
          force_sweeps<Real, Dampers::none, Guards>(),      sweep_any<ForceChange<Real, false>, Guards, Real>,
          sweep_any<ForceChange<Real, true>, Guards, Real>, make_diagonal_sweeps<Real, Guards, false>(),
          make_diagonal_sweeps<Real, Guards, true>()};
}

template <class Real>
SweepKernel<Real> make_sweep_kernel(const char* name) {
  return {name,
          lanes<Real>,
          rsqrt_scale<Real>,
          make_sweeps<Real, 0>(),
          make_sweeps<Real, block_guards>(),
          store_force<Real>,
          store_acceleration<Real>,
          store_product<Real>,
          kick_drift<Real>,
          kick_drift_stored<Real>,
          short_step<Real>};
}

}  // namespace mss::MSS_ISA

#pragma once

// Vertex block descent, W particles of a colour at once, see vbd_kernel.hpp. Included once per instruction
// set, see simd.hpp.

#include "core/base/lattice.hpp"
#include "core/kernels/cell_vectors.hpp"
#include "integrators/position_based/vbd_kernel.hpp"

namespace mss::MSS_ISA {

inline constexpr int middle = sites_around / 2;

template <int sign, class Real>
MSS_INLINE Vec<Real> with_sign(const Vec<Real>& v) {
  if constexpr (sign > 0)
    return v;
  else
    return -v;
}

/// W particles and all that is around them.
template <class Real, bool Damped>
struct VertexBlock {
  static constexpr int W = lanes<Real>;
  const Descent<Real>& p;
  const Real* coefficient;
  std::ptrdiff_t first;
  Vec<Real> x[sites_around];  ///< only of planes that were taken
  Vec<Real> moved;            ///< of the particles themselves
  Vec<Real> force;
  Pack<Real> isotropic;  ///< of the Hessian, times the identity
  Symmetric<Real> hessian{};

  MSS_INLINE VertexBlock(const Descent<Real>& descent, const Real* numbers, std::ptrdiff_t i)
      : p(descent), coefficient(numbers), first(i), moved(load(p.moved, p.around[middle] + i)) {
    isotropic = load(coefficient + W * (2 * sites_around + 8));
    force = isotropic * (load(p.target, p.around[middle] + i) - moved);
  }

  /// Positions of the nine sites of a plane, from 0 for that below.
  MSS_INLINE void take_plane(int plane) {
    for (int n = 9 * plane; n < 9 * (plane + 1); ++n)
      x[n] = load(p.before, p.around[n] + first) + load(p.moved, p.around[n] + first);
  }
  MSS_INLINE void add_springs_to_plane(int plane) {
    for (int n = 9 * plane; n < 9 * (plane + 1); ++n)
      if (n != middle) add_spring(n);
  }

  MSS_INLINE void add_spring(int other) {
    constexpr Real unscale = 1 / (rsqrt_scale<Real> * rsqrt_scale<Real>);
    const Vec<Real> d = x[other] - x[middle];
    const Pack<Real> squared = squared_norm(d), r = scaled_rsqrt(squared, rsqrt_estimate(squared));
    const Pack<Real> k = load(coefficient + W * other), ratio = p.rest_length[other] * r;
    Pack<Real> pull = tension_over_length(k, ratio);
    const Pack<Real> across = positive_part<Real>(pull);
    Pack<Real> along = unscale * (spring_stiffness(k, ratio) - across);
    if constexpr (Damped) {
      const Pack<Real> damping = load(coefficient + W * (sites_around + other));
      pull = pull + damping * (dot(d, load(p.moved, p.around[other] + first) - moved) * (r * r));
      along = along + damping;
    }
    force = force + pull * d;
    isotropic = isotropic + across;
    hessian.add(along * (r * r), d);
  }

  /// Of the cell whose corner `own` the particle is. Edges are four times too long, see the sweep, so the
  /// volume is 64 times too large, and so is its gradient.
  template <int own>
  MSS_INLINE void add_volume() {
    const Pack<Real> stiffness = load(coefficient + W * (2 * sites_around + own));
    constexpr const int(&at)[8] = corner_places.of[own];
    const Edges<Vec<Real>> e(x[at[7]] - x[at[0]], x[at[6]] - x[at[1]], x[at[5]] - x[at[2]],
                             x[at[4]] - x[at[3]]);
    const EdgeSlopes<Vec<Real>> by(e);
    const Vec<Real> slope = (with_sign<corner_sign(own, 0)>(by.x) + with_sign<corner_sign(own, 1)>(by.y)) +
                            with_sign<corner_sign(own, 2)>(by.z);
    const Pack<Real> excess = dot(e.x, by.x) - p.rest_volume;
    force = force - (stiffness * excess) * slope;
    hessian.add(stiffness, slope);
  }
};

/// Particles that may meet a plane, one by one, from where they were before the pass.
template <class Real>
void move_in_contact(const DescentContact<Real>& contact, std::ptrdiff_t own, const Symmetric<Real>& h,
                     const Vec<Real>& force, const Vec<Real>& moved) {
  for (int lane = 0; lane < lanes<Real>; ++lane)
    contact.move(own + lane, {h.xx[lane], h.yy[lane], h.zz[lane], h.yz[lane], h.zx[lane], h.xy[lane]},
                 {force.x[lane], force.y[lane], force.z[lane]},
                 {moved.x[lane], moved.y[lane], moved.z[lane]});
}

template <class Real, bool Damped>
void descend(const Descent<Real>& argument, std::ptrdiff_t first, std::ptrdiff_t last) {
  constexpr int W = lanes<Real>;
  const Descent<Real> p = argument;  // a copy that the stores below cannot reach
  const Pack<Real> zero{};
  for (std::ptrdiff_t i = first; i < last; i += W) {
    const std::uint32_t entry = p.entry[i / W];
    if (entry == 0) continue;
    const std::ptrdiff_t own = p.around[middle] + i;
    const Real* coefficient = p.dictionary + std::ptrdiff_t(entry) * descent_coefficients * W;
    VertexBlock<Real, Damped> s(p, coefficient, i);
    const bool below = (p.planes[entry] & plane_below) != 0, above = (p.planes[entry] & plane_above) != 0;
    s.take_plane(1);
    if (below) {
      s.take_plane(0);
      s.add_springs_to_plane(0);
    }
    s.add_springs_to_plane(1);
    if (above) {
      s.take_plane(2);
      s.add_springs_to_plane(2);
      s.template add_volume<0>();
      s.template add_volume<1>();
      s.template add_volume<2>();
      s.template add_volume<3>();
    }
    if (below) {
      s.template add_volume<4>();
      s.template add_volume<5>();
      s.template add_volume<6>();
      s.template add_volume<7>();
    }
    // Held axes do not move, and the others as if they were alone.
    const Vec<Real> w = load(p.inverse_mass, own);
    const auto fx = w.x > zero, fy = w.y > zero, fz = w.z > zero;
    Symmetric<Real>& h = s.hessian;
    h.add_identity(s.isotropic);
    h.xx = fx ? h.xx : zero + Real(1);
    h.yy = fy ? h.yy : zero + Real(1);
    h.zz = fz ? h.zz : zero + Real(1);
    h.xy = (fx & fy) ? h.xy : zero;
    h.yz = (fy & fz) ? h.yz : zero;
    h.zx = (fz & fx) ? h.zx : zero;
    const Vec<Real> force{fx ? s.force.x : zero, fy ? s.force.y : zero, fz ? s.force.z : zero};
    store(p.moved, own, s.moved + h.solve(force));
    if (p.contact != nullptr && p.contact->touches(own, W))
      move_in_contact(*p.contact, own, h, force, s.moved);
  }
}

template <class Real>
VbdKernel<Real> make_vbd_kernel(const char* name) {
  return {name, lanes<Real>, rsqrt_scale<Real>, descend<Real, false>, descend<Real, true>};
}

}  // namespace mss::MSS_ISA

#pragma once

// Projections of constraints, Gauss-Seidel over colours of cells: Macklin, Mueller and Chentanez, XPBD:
// position-based simulation of compliant constrained dynamics, MIG 2016, eq. 18 and 26. W cells of a colour
// are projected at once, of each the thirteen springs that its site owns and its volume, one after the other.
// Included once per instruction set, see simd.hpp.

#include "core/cell_vectors.hpp"
#include "core/projection.hpp"

namespace mss::MSS_ISA {

enum class Kind { undamped, damped, general };

/// W cells of a colour: the displacements of their corners while their constraints are projected.
template <class Real, Kind kind>
struct ProjectedCells {
  static constexpr int W = lanes<Real>;
  const Projection<Real>& p;
  std::ptrdiff_t cell;
  const Real* coefficient;
  Real* multiplier;
  Vec<Real> u[8];

  MSS_INLINE std::ptrdiff_t at(int corner) const { return p.corner[corner] + cell; }

  MSS_INLINE void take() {
    for (int c = 0; c < 8; ++c) u[c] = load(p.moved, at(c));
  }
  MSS_INLINE void put() const {
    for (int c = 0; c < 8; ++c) store(p.moved, at(c), u[c]);
  }

  /// Moves two corners apart by `impulse` over their masses.
  MSS_INLINE void push_apart(int a, int b, const Vec<Real>& impulse) {
    if constexpr (kind == Kind::general) {
      const Vec<Real> wa = load(p.inverse_mass, at(a)), wb = load(p.inverse_mass, at(b));
      u[a] = {u[a].x + wa.x * impulse.x, u[a].y + wa.y * impulse.y, u[a].z + wa.z * impulse.z};
      u[b] = {u[b].x - wb.x * impulse.x, u[b].y - wb.y * impulse.y, u[b].z - wb.z * impulse.z};
    } else {
      u[a] = u[a] + load(p.inverse_mass.axis[0] + at(a)) * impulse;
      u[b] = u[b] - load(p.inverse_mass.axis[0] + at(b)) * impulse;
    }
  }

  /// One spring, in two halves as in the sweep.
  struct Started {
    Vec<Real> d, du;
    Pack<Real> squared, estimate;
  };
  MSS_INLINE Started start(int spring) const {
    const int a = spring_ends[spring][0], b = spring_ends[spring][1];
    Started s;
    s.du = u[a] - u[b];
    s.d = (load(p.before, at(a)) - load(p.before, at(b))) + s.du;
    s.squared = squared_norm(s.d);
    s.estimate = rsqrt_estimate(s.squared);
    return s;
  }
  MSS_INLINE void finish(int spring, const Started& s) {
    const Real* c = coefficient + 3 * W * spring;
    const Pack<Real> r = scaled_rsqrt(s.squared, s.estimate);
    Pack<Real> lambda = load(c) * (p.rest_length[spring] - s.squared * r);
    if constexpr (kind != Kind::undamped) lambda = lambda - load(c + W) * (dot(s.d, s.du) * r);
    if constexpr (kind == Kind::general) {
      Real* kept = multiplier + W * spring;
      const Pack<Real> before = load(kept);
      lambda = lambda - load(c + 2 * W) * before;
      store(kept, before + lambda);
    }
    push_apart(spring_ends[spring][0], spring_ends[spring][1], (lambda * r) * s.d);
  }

  /// Springs without a common end, side by side: each is one chain of dependent operations.
  template <int... Spring>
  MSS_INLINE void project() {
    constexpr int springs[] = {Spring...};
    constexpr int count = sizeof...(Spring);
    Started s[count];
    for (int i = 0; i < count; ++i) s[i] = start(springs[i]);
    for (int i = 0; i < count; ++i) finish(springs[i], s[i]);
  }

  /// Eq. 3-7's volume and its gradient, from edges that are four times too long: grad V of corner c < 4 is
  /// -slope[c] / 64, that of the opposite corner slope[c] / 64.
  MSS_INLINE void project_volume() {
    Vec<Real> x[8];
    for (int c = 0; c < 8; ++c) x[c] = load(p.before, at(c)) + u[c];
    const Edges<Real> e(x[7] - x[0], x[6] - x[1], x[5] - x[2], x[4] - x[3]);
    const Vec<Real> yz = cross(e.y, e.z), zx = cross(e.z, e.x), xy = cross(e.x, e.y);
    const Vec<Real> slope[4] = {(xy + zx) + yz, (xy + zx) - yz, (xy - zx) + yz, (xy - zx) - yz};
    const Pack<Real> volume = Real(1.0 / 64) * dot(e.x, yz);
    Pack<Real> mobility{};
    for (int c = 0; c < 4; ++c) mobility = mobility + mobility_of(c, slope[c]) + mobility_of(7 - c, slope[c]);
    const Pack<Real> stiffness = load(coefficient + 3 * W * springs_per_site);
    Pack<Real> lambda = stiffness * (p.rest_volume - volume);
    if constexpr (kind == Kind::general) lambda = lambda - load(multiplier + W * springs_per_site);
    lambda = lambda / ((Real(1.0 / 4096) * stiffness) * mobility + Real(1));
    if constexpr (kind == Kind::general) {
      Real* kept = multiplier + W * springs_per_site;
      store(kept, load(kept) + lambda);
    }
    const Pack<Real> pull = Real(1.0 / 64) * lambda;
    for (int c = 0; c < 4; ++c) push_apart(7 - c, c, pull * slope[c]);
  }
  /// w |slope|^2.
  MSS_INLINE Pack<Real> mobility_of(int corner, const Vec<Real>& slope) const {
    if constexpr (kind == Kind::general) {
      const Vec<Real> w = load(p.inverse_mass, at(corner));
      return w.x * (slope.x * slope.x) + (w.y * (slope.y * slope.y) + w.z * (slope.z * slope.z));
    } else {
      return load(p.inverse_mass.axis[0] + at(corner)) * dot(slope, slope);
    }
  }
};

template <class Real, Kind kind>
void project_cells(const Projection<Real>& argument) {
  constexpr int W = lanes<Real>;
  const Projection<Real> p = argument;  // a copy that the stores below cannot reach
  for (std::ptrdiff_t cell = p.first; cell < p.last; cell += W) {
    const std::uint32_t entry = p.entry[cell / W];
    if (entry == 0) continue;
    ProjectedCells<Real, kind> cells{p,
                                     cell,
                                     p.dictionary + std::ptrdiff_t(entry) * projection_coefficients * W,
                                     p.multipliers + cell * constraints_per_cell,
                                     {}};
    cells.take();
    cells.project_volume();
    cells.template project<3, 10, 11>();
    cells.template project<4, 12>();
    cells.template project<5, 7>();
    cells.template project<9>();
    cells.template project<0, 8>();
    cells.template project<1>();
    cells.template project<2, 6>();
    cells.put();
  }
}

template <class Real>
void predict(const ProjectionStep<Real>& p) {
  const Pack<Real> dt = Pack<Real>{} + p.dt, dt2 = dt * dt;
  const Streams<Real> v = p.v, moved = p.moved;
  for (std::ptrdiff_t i = p.first; i < p.last; i += lanes<Real>)
    store(moved, i, dt * load(v, i) + dt2 * load(p.acceleration, i));
}

template <class Real>
void finish(const ProjectionStep<Real>& p) {
  const Pack<Real> rate = Pack<Real>{} + Real(1) / p.dt;
  for (std::ptrdiff_t i = p.first; i < p.last; i += lanes<Real>) {
    const Vec<Real> u = load(p.moved, i);
    store(p.x, i, load(p.x, i) + u);
    store(p.v, i, rate * u);
  }
}

template <class Real>
ProjectionKernel<Real> make_projection_kernel(const char* name) {
  return {name,
          lanes<Real>,
          rsqrt_scale<Real>,
          predict<Real>,
          finish<Real>,
          project_cells<Real, Kind::undamped>,
          project_cells<Real, Kind::damped>,
          project_cells<Real, Kind::general>};
}

}  // namespace mss::MSS_ISA

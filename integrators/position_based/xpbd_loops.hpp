#pragma once

// Projections of constraints, Gauss-Seidel over colours of cells: Macklin, Mueller and Chentanez, XPBD:
// position-based simulation of compliant constrained dynamics, MIG 2016, eq. 18 and 26. W cells of a colour
// are projected at once, of each the thirteen springs that its site owns and its volume, one after the other.
// Included once per instruction set, see simd.hpp.

#include "core/kernels/cell_vectors.hpp"
#include "integrators/position_based/xpbd_kernel.hpp"

namespace mss::MSS_ISA {

enum class Kind { undamped, damped, general };

/// `blocks` times W cells of a colour, one block behind the other: the displacements of their first corners
/// while their constraints are projected. Projections of a cell wait for each other; those of another block
/// fill the time.
template <class Real, Kind kind, int blocks, int corners>
struct ProjectedCells {
  static constexpr int W = lanes<Real>;
  const Projection<Real>& p;
  std::ptrdiff_t cell;
  const Real* coefficient[blocks];
  Vec<Real> u[blocks][corners];

  MSS_INLINE ProjectedCells(const Projection<Real>& projection, std::ptrdiff_t first)
      : p(projection), cell(first) {
    for (int b = 0; b < blocks; ++b)
      coefficient[b] =
          p.dictionary + std::ptrdiff_t(p.entry[cell / W + b]) * std::ptrdiff_t(projection_coefficients * W);
    for (int c = 0; c < corners; ++c)
      for (int b = 0; b < blocks; ++b) u[b][c] = load(p.moved, at(b, c));
  }
  MSS_INLINE void put() const {
    for (int c = 0; c < corners; ++c)
      for (int b = 0; b < blocks; ++b) store(p.moved, at(b, c), u[b][c]);
  }

  MSS_INLINE std::ptrdiff_t at(int block, int corner) const { return p.corner[corner] + cell + block * W; }
  MSS_INLINE Real* multiplier(int block, int constraint) const {
    return p.multipliers + (cell + std::ptrdiff_t(W) * block) * constraints_per_cell +
           std::ptrdiff_t(W) * constraint;
  }

  /// Moves two corners apart by the impulse `size` d over their masses.
  MSS_INLINE void push_apart(int block, int a, int b, Pack<Real> size, const Vec<Real>& d) {
    Vec<Real>&ua = u[block][a], &ub = u[block][b];
    if constexpr (kind == Kind::general) {
      const Vec<Real> wa = load(p.inverse_mass, at(block, a)), wb = load(p.inverse_mass, at(block, b));
      const Vec<Real> impulse = size * d;
      ua = {ua.x + wa.x * impulse.x, ua.y + wa.y * impulse.y, ua.z + wa.z * impulse.z};
      ub = {ub.x - wb.x * impulse.x, ub.y - wb.y * impulse.y, ub.z - wb.z * impulse.z};
    } else {
      ua = ua + (size * load(p.inverse_mass.axis[0] + at(block, a))) * d;
      ub = ub - (size * load(p.inverse_mass.axis[0] + at(block, b))) * d;
    }
  }

  /// One spring, in two halves as in the sweep.
  struct PendingSprings {
    Vec<Real> d, du;
    Pack<Real> squared, estimate;
  };
  MSS_INLINE PendingSprings start(int block, int spring) const {
    const int a = spring_ends[spring][0], b = spring_ends[spring][1];
    PendingSprings s;
    s.du = u[block][a] - u[block][b];
    s.d = (load(p.before, at(block, a)) - load(p.before, at(block, b))) + s.du;
    s.squared = squared_norm(s.d);
    s.estimate = rsqrt_estimate(s.squared);
    return s;
  }
  MSS_INLINE void finish(int block, int spring, const PendingSprings& s) {
    constexpr Real scale2 = rsqrt_scale<Real> * rsqrt_scale<Real>;
    const Real* c = coefficient[block] + 3 * W * spring;
    const Pack<Real> r = scaled_rsqrt(s.squared, s.estimate);
    Pack<Real> lambda = load(c) * spring_shortening(p.rest_length[spring], s.squared, r);
    const Pack<Real> ratio = (Real(1) / scale2 * p.rest_length[spring]) * r,
                     factor = projection_factor(ratio, mobility(block, spring) * (scale2 * load(c)));
    lambda = (factor * law_secant(strain_of_ratio(ratio))) * lambda;
    if constexpr (kind != Kind::undamped) lambda = lambda - factor * (load(c + W) * (dot(s.d, s.du) * r));
    if constexpr (kind == Kind::general) {
      Real* kept = multiplier(block, spring);
      const Pack<Real> before = load(kept);
      lambda = lambda - factor * (load(c + 2 * W) * before);
      store(kept, before + lambda);
    }
    push_apart(block, spring_ends[spring][0], spring_ends[spring][1], lambda * r, s.d);
  }

  /// Of a spring's two ends, if the law asks for it.
  MSS_INLINE Pack<Real> mobility(int block, int spring) const {
    return load(p.inverse_mass.axis[0] + at(block, spring_ends[spring][0])) +
           load(p.inverse_mass.axis[0] + at(block, spring_ends[spring][1]));
  }

  /// Springs without a common end, side by side: each is one chain of dependent operations.
  template <int... Spring>
  MSS_INLINE void project() {
    constexpr int springs[] = {Spring...};
    constexpr int count = sizeof...(Spring);
    PendingSprings s[blocks][count];
    for (int i = 0; i < count; ++i)
      for (int b = 0; b < blocks; ++b) s[b][i] = start(b, springs[i]);
    for (int i = 0; i < count; ++i)
      for (int b = 0; b < blocks; ++b) finish(b, springs[i], s[b][i]);
  }

  /// Eq. 3-7's volume and its gradient, from edges that are four times too long: grad V of corner c < 4 is
  /// -slope[c] / 64, that of the opposite corner slope[c] / 64.
  MSS_INLINE void project_volume(int block) {
    Vec<Real> x[8];
    for (int c = 0; c < 8; ++c) x[c] = load(p.before, at(block, c)) + u[block][c];
    const Edges<Vec<Real>> e(x[7] - x[0], x[6] - x[1], x[5] - x[2], x[4] - x[3]);
    const EdgeSlopes<Vec<Real>> by(e);
    const Vec<Real> slope[4] = {at_corner<0>(by), at_corner<1>(by), at_corner<2>(by), at_corner<3>(by)};
    const Pack<Real> volume = Real(1.0 / 64) * dot(e.x, by.x);
    Pack<Real> mobility{};
    for (int c = 0; c < 4; ++c)
      mobility = mobility + mobility_of(block, c, slope[c]) + mobility_of(block, 7 - c, slope[c]);
    const Pack<Real> stiffness = load(coefficient[block] + 3 * W * springs_per_site);
    Pack<Real> lambda = stiffness * (p.rest_volume - volume);
    if constexpr (kind == Kind::general) lambda = lambda - load(multiplier(block, springs_per_site));
    lambda = lambda / ((Real(1.0 / 4096) * stiffness) * mobility + Real(1));
    if constexpr (kind == Kind::general) {
      Real* kept = multiplier(block, springs_per_site);
      store(kept, load(kept) + lambda);
    }
    const Pack<Real> pull = Real(1.0 / 64) * lambda;
    for (int c = 0; c < 4; ++c) push_apart(block, 7 - c, c, pull, slope[c]);
  }
  /// w |slope|^2.
  MSS_INLINE Pack<Real> mobility_of(int block, int corner, const Vec<Real>& slope) const {
    if constexpr (kind == Kind::general) {
      const Vec<Real> w = load(p.inverse_mass, at(block, corner));
      return w.x * (slope.x * slope.x) + (w.y * (slope.y * slope.y) + w.z * (slope.z * slope.z));
    } else {
      return load(p.inverse_mass.axis[0] + at(block, corner)) * dot(slope, slope);
    }
  }

  /// Zeros change nothing, so what is left out here makes no difference where it is zero.
  MSS_INLINE void project_flat() {
    project<3>();
    project<0>();
    project<1>();
    project<6>();
  }
  MSS_INLINE void project_all() {
    for (int b = 0; b < blocks; ++b) project_volume(b);
    project<3, 10, 11>();
    project<4, 12>();
    project<5, 7>();
    project<9>();
    project<0, 8>();
    project<1>();
    project<2, 6>();
  }
};

template <class Real, Kind kind>
void project_cells(const Projection<Real>& argument, std::ptrdiff_t first, std::ptrdiff_t last) {
  constexpr int W = lanes<Real>;
  const Projection<Real> p = argument;  // a copy that the stores below cannot reach
  const auto project = [&]<int blocks>(std::ptrdiff_t cell, bool is_flat) {
    if (is_flat) {
      ProjectedCells<Real, kind, blocks, 4> cells(p, cell);
      cells.project_flat();
      cells.put();
    } else {
      ProjectedCells<Real, kind, blocks, 8> cells(p, cell);
      cells.project_all();
      cells.put();
    }
  };
  for (std::ptrdiff_t cell = first; cell < last;) {
    const std::uint32_t* entry = p.entry + cell / W;
    const bool is_pair = cell + W < last && entry[0] != 0 && entry[1] != 0;
    if (is_pair)
      project.template operator()<2>(cell, p.is_flat[entry[0]] != 0 && p.is_flat[entry[1]] != 0);
    else if (entry[0] != 0)
      project.template operator()<1>(cell, p.is_flat[entry[0]] != 0);
    cell += is_pair ? 2 * W : W;
  }
}

/// u = dt v, then target = u + dt^2 a.
template <class Real>
MSS_INLINE void predict_from(const ProjectionStep<Real>& p, std::ptrdiff_t i, const Vec<Real>& v) {
  const Pack<Real> dt = Pack<Real>{} + p.dt;
  const Vec<Real> u = dt * v;
  store(p.moved, i, u);
  store(p.target, i, u + (dt * dt) * load(p.acceleration, i));
}

template <class Real>
void predict(const ProjectionStep<Real>& argument) {
  const ProjectionStep<Real> p = argument;
  for (std::ptrdiff_t i = p.first; i < p.last; i += lanes<Real>) predict_from(p, i, load(p.v, i));
}

template <class Real>
void proceed(const ProjectionStep<Real>& argument) {
  const ProjectionStep<Real> p = argument;
  const Pack<Real> rate = Pack<Real>{} + Real(1) / p.dt;
  for (std::ptrdiff_t i = p.first; i < p.last; i += lanes<Real>) {
    const Vec<Real> u = load(p.moved, i);
    store(p.x, i, load(p.x, i) + u);
    predict_from(p, i, rate * u);
  }
}

template <class Real>
void finish(const ProjectionStep<Real>& argument) {
  const ProjectionStep<Real> p = argument;
  const Pack<Real> rate = Pack<Real>{} + Real(1) / p.dt;
  for (std::ptrdiff_t i = p.first; i < p.last; i += lanes<Real>) {
    const Vec<Real> u = load(p.moved, i);
    store(p.x, i, load(p.x, i) + u);
    store(p.v, i, rate * u);
  }
}

template <class Real>
XpbdKernel<Real> make_xpbd_kernel(const char* name) {
  return {name,
          lanes<Real>,
          rsqrt_scale<Real>,
          predict<Real>,
          proceed<Real>,
          finish<Real>,
          project_cells<Real, Kind::undamped>,
          project_cells<Real, Kind::damped>,
          project_cells<Real, Kind::general>};
}

}  // namespace mss::MSS_ISA

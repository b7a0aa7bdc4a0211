#pragma once

// The loops of reduction_kernels.hpp. Included once per instruction set, see core/kernels/simd.hpp.

#include <cstddef>

#include "core/kernels/simd.hpp"
#include "integrators/reduction/reduction_kernels.hpp"

namespace mss::MSS_ISA {

template <class Real>
inline constexpr int packs_of_panel = panel_rows / lanes<Real>;

template <class Real>
inline void expand(const Panels<Real>& a, const Real* base, const Real* q, Real* out) {
  constexpr std::ptrdiff_t w = lanes<Real>;
  constexpr int packs = packs_of_panel<Real>;
  const Real* column = a.values;
  for (std::ptrdiff_t panel = 0; panel < a.panels; ++panel, base += panel_rows, out += panel_rows) {
    Pack<Real> sum[packs];
    for (int k = 0; k < packs; ++k) sum[k] = load(base + w * k);
    for (int c = 0; c < a.columns; ++c, column += panel_rows)
      for (int k = 0; k < packs; ++k) sum[k] += q[c] * load(column + w * k);
    for (int k = 0; k < packs; ++k) store(out + w * k, sum[k]);
  }
}

inline void project(const Panels<double>& a, const double* f, double* p) {
  constexpr std::ptrdiff_t w = lanes<double>;
  Pack<double> sum[most_coordinates] = {};
  const double* column = a.values;
  for (std::ptrdiff_t panel = 0; panel < a.panels; ++panel, f += panel_rows) {
    constexpr int packs = packs_of_panel<double>;
    Pack<double> force[packs];
    for (int k = 0; k < packs; ++k) force[k] = load(f + w * k);
    for (int c = 0; c < a.columns; ++c, column += panel_rows)
      for (int k = 0; k < packs; ++k) sum[c] += force[k] * load(column + w * k);
  }
  for (int c = 0; c < a.columns; ++c) {
    p[c] = 0;
    for (int lane = 0; lane < w; ++lane) p[c] += sum[c][lane];
  }
}

/// With `packs` vectors in a row.
template <int packs>
inline void cubic_force_of(const CubicForce& polynomial, const double* q, double* f) {
  constexpr std::ptrdiff_t w = lanes<double>;
  const double *linear = polynomial.linear, *quadratic = polynomial.quadratic, *cubic = polynomial.cubic;
  Pack<double> force[packs] = {};
  for (int a = 0; a < polynomial.coordinates; ++a) {
    Pack<double> of_a[packs];
    for (int i = 0; i < packs; ++i, linear += w) of_a[i] = load(linear);
    for (int b = 0; b <= a; ++b) {
      Pack<double> of_b[packs];
      for (int i = 0; i < packs; ++i, quadratic += w) of_b[i] = load(quadratic);
      for (int c = 0; c <= b; ++c)
        for (int i = 0; i < packs; ++i, cubic += w) of_b[i] += q[c] * load(cubic);
      for (int i = 0; i < packs; ++i) of_a[i] += q[b] * of_b[i];
    }
    for (int i = 0; i < packs; ++i) force[i] += q[a] * of_a[i];
  }
  for (int i = 0; i < packs; ++i) store(f + w * i, force[i]);
}

/// Rows of up to 32 numbers have vectors that stay in registers; longer ones are rare.
inline void cubic_force(const CubicForce& polynomial, const double* q, double* f) {
  constexpr int packs_of_padding = coordinate_padding / lanes<double>;
  switch (polynomial.padded / coordinate_padding) {
    case 1:
      return cubic_force_of<packs_of_padding>(polynomial, q, f);
    case 2:
      return cubic_force_of<2 * packs_of_padding>(polynomial, q, f);
    case 3:
      return cubic_force_of<3 * packs_of_padding>(polynomial, q, f);
    case 4:
      return cubic_force_of<4 * packs_of_padding>(polynomial, q, f);
    default:
      CubicForce longest = polynomial;
      longest.padded = most_coordinates;
      return cubic_force_of<most_coordinates / lanes<double>>(longest, q, f);
  }
}

inline ReductionKernels make_reduction_kernels(const char* name) {
  return {.name = name,
          .expand = expand<double>,
          .expand_single = expand<float>,
          .project = project,
          .cubic_force = cubic_force};
}

}  // namespace mss::MSS_ISA

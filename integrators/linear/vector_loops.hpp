#pragma once

// The loops of vector_kernels.hpp. Included once per instruction set, see core/kernels/simd.hpp.

#include <cstddef>

#include "core/kernels/independent_loop.hpp"
#include "core/kernels/simd.hpp"
#include "integrators/linear/vector_kernels.hpp"

namespace mss::MSS_ISA {

/// Rows of a tile of a transform: with three columns of vectors, as many sums as there are registers for.
inline constexpr int tile_rows = vector_bytes == 64 ? 8 : 4;

/// Rows [row, row + tile_rows) and columns [column, column + width lanes) of a transform.
template <int width, bool scaled>
MSS_INLINE void transform_tile(const AxisTransform& t, std::ptrdiff_t row, int column) {
  constexpr std::ptrdiff_t w = lanes<double>;
  Pack<double> sum[tile_rows][width] = {};
  const double* in = t.in + row;
  const double* basis = t.basis + column;
  for (int k = 0; k < t.n; ++k, in += t.stride, basis += t.columns) {
    Pack<double> b[width];
    for (int c = 0; c < width; ++c) b[c] = load(basis + w * c);
    for (int r = 0; r < tile_rows; ++r)
      for (int c = 0; c < width; ++c) sum[r][c] += in[r] * b[c];
  }
  for (int r = 0; r < tile_rows; ++r) {
    const std::ptrdiff_t at = (row + r) * t.n + column;
    for (int c = 0; c < width; ++c)
      store(t.out + at + w * c, scaled ? sum[r][c] * load(t.scale + at + w * c) : sum[r][c]);
  }
}

/// What a row's last vector writes beyond it belongs to the beginning of the next row, which is written
/// later: rows in ascending order, of each the last columns first.
template <bool scaled>
MSS_INLINE void transform_rows(const AxisTransform& t, std::ptrdiff_t row) {
  constexpr std::ptrdiff_t w = lanes<double>;
  const int vectors = (t.n + w - 1) / w;
  int first = (vectors - 1) / 3 * 3;
  const int rest = vectors - first;
  if (rest == 1)
    transform_tile<1, scaled>(t, row, w * first);
  else if (rest == 2)
    transform_tile<2, scaled>(t, row, w * first);
  else
    transform_tile<3, scaled>(t, row, w * first);
  while (first > 0) transform_tile<3, scaled>(t, row, w * (first -= 3));
}

/// One row at a time, where there are fewer than a tile has.
template <bool scaled>
inline void transform_row(const AxisTransform& t, std::ptrdiff_t row) {
  for (int l = 0; l < t.n; ++l) {
    double sum = 0;
    for (int k = 0; k < t.n; ++k) sum += t.in[k * t.stride + row] * t.basis[k * t.columns + l];
    t.out[row * t.n + l] = scaled ? sum * t.scale[row * t.n + l] : sum;
  }
}

template <bool scaled>
inline void transform_all(const AxisTransform& t) {
  std::ptrdiff_t row = 0;
  for (; row + tile_rows <= t.count; row += tile_rows) transform_rows<scaled>(t, row);
  if (row == t.count) return;
  if (t.count >= tile_rows) return transform_rows<scaled>(t, t.count - tile_rows);  // some rows again
  for (; row < t.count; ++row) transform_row<scaled>(t, row);
}

inline void transform(const AxisTransform& t) {
  if (t.scale)
    transform_all<true>(t);
  else
    transform_all<false>(t);
}

inline double dot(const double* a, const double* b, std::ptrdiff_t n) {
  constexpr std::ptrdiff_t w = lanes<double>;
  Pack<double> sum[4] = {};
  std::ptrdiff_t i = 0;
  for (; i + 4 * w <= n; i += 4 * w)
    for (int u = 0; u < 4; ++u) sum[u] += load(a + i + w * u) * load(b + i + w * u);
  const Pack<double> all = (sum[0] + sum[1]) + (sum[2] + sum[3]);
  double total = 0;
  for (int lane = 0; lane < w; ++lane) total += all[lane];
  for (; i < n; ++i) total += a[i] * b[i];
  return total;
}

inline void add(double a, const double* x, double* y, std::ptrdiff_t n) {
  for (std::ptrdiff_t i = 0; i < n; ++i) y[i] += a * x[i];
}

inline void move(double a, const double* p, double b, const double* x_base, double* v, double* x,
                 std::ptrdiff_t n) {
  MSS_INDEPENDENT
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    v[i] += a * p[i];
    x[i] = x_base[i] + b * v[i];
  }
}

inline void gradient(const double* m, const double* v, const double* v_base, double b, double* g,
                     std::ptrdiff_t n) {
  MSS_INDEPENDENT
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const double value = m[i] * (v[i] - v_base[i]) - b * g[i];
    g[i] = m[i] != 0 ? value : 0;
  }
}

inline VectorKernels make_vector_kernels(const char* name) {
  return {.name = name, .transform = transform, .dot = dot, .add = add, .move = move, .gradient = gradient};
}

}  // namespace mss::MSS_ISA

#pragma once

// The loops of rest_kernel.hpp. Included once per instruction set, see core/kernels/simd.hpp.

#include <utility>

#include "core/kernels/simd.hpp"
#include "integrators/linear/rest_kernel.hpp"

namespace mss::MSS_ISA {

using Floats = Pack<float>;
inline constexpr std::ptrdiff_t width = lanes<float>;

/// How the ends of a slot's spring differ along an axis: -1, 0 or 1. The first end has the lower site.
constexpr int direction_of(std::size_t slot, int axis) {
  return corner_bit(spring_slots[slot].b, axis) - corner_bit(spring_slots[slot].a, axis);
}

template <int sign>
MSS_INLINE void add_signed(Floats& sum, Floats value) {
  if constexpr (sign > 0) sum += value;
  if constexpr (sign < 0) sum -= value;
}

/// Adds what the two springs of a slot that end at a site pull it with.
template <std::size_t slot>
MSS_INLINE void pull(const RestStencil& a, const float* const d[3], std::ptrdiff_t s, const Floats u[3],
                     Floats f[3]) {
  constexpr int x = direction_of(slot, 0), y = direction_of(slot, 1), z = direction_of(slot, 2);
  const std::ptrdiff_t next = s + a.offset[slot], last = s - a.offset[slot];
  Floats ahead{}, behind{};
  const auto add = [&]<int axis, int sign>() {
    if constexpr (sign != 0) {
      add_signed<sign>(ahead, load(d[axis] + next) - u[axis]);
      add_signed<sign>(behind, load(d[axis] + last) - u[axis]);
    }
  };
  add.template operator()<0, x>();
  add.template operator()<1, y>();
  add.template operator()<2, z>();
  const Floats force = load(a.spring[slot] + s) * ahead + load(a.spring[slot] + last) * behind;
  add_signed<x>(f[0], force);
  add_signed<y>(f[1], force);
  add_signed<z>(f[2], force);
}

template <std::size_t... slot>
MSS_INLINE void pull_all(std::integer_sequence<std::size_t, slot...>, const RestStencil& a,
                         const float* const d[3], std::ptrdiff_t s, const Floats u[3], Floats f[3]) {
  (pull<slot>(a, d, s, u, f), ...);
}

/// Adds the volume forces of the eight cells around a site.
MSS_INLINE void push(const RestStencil& a, const float* pressure, std::ptrdiff_t s, Floats f[3]) {
  const float* p = pressure + s;
  const std::ptrdiff_t row = a.row, plane = a.plane;
  const Floats p0 = load(p), p1 = load(p - 1), p2 = load(p - row), p3 = load(p - row - 1),
               p4 = load(p - plane), p5 = load(p - plane - 1), p6 = load(p - plane - row),
               p7 = load(p - plane - row - 1);
  const Floats upper = (p0 + p1) + (p2 + p3), lower = (p4 + p5) + (p6 + p7);
  f[0] += ((p0 - p1) + (p2 - p3)) + ((p4 - p5) + (p6 - p7));
  f[1] += ((p0 + p1) - (p2 + p3)) + ((p4 + p5) - (p6 + p7));
  f[2] += upper - lower;
}

/// The blocks' inverses times r.
MSS_INLINE void precondition(const RestStencil& a, std::ptrdiff_t s, const Floats r[3], Floats out[3]) {
  const Floats yz = load(a.inverse[3] + s), zx = load(a.inverse[4] + s), xy = load(a.inverse[5] + s);
  out[0] = load(a.inverse[0] + s) * r[0] + (xy * r[1] + zx * r[2]);
  out[1] = load(a.inverse[1] + s) * r[1] + (xy * r[0] + yz * r[2]);
  out[2] = load(a.inverse[2] + s) * r[2] + (zx * r[0] + yz * r[1]);
}

template <bool Update>
inline void smooth_range(const RestStencil& a, const RestSmoothing& step, std::ptrdiff_t first,
                         std::ptrdiff_t last) {
  for (std::ptrdiff_t s = first; s < last; s += width) {
    Floats u[3], f[3]{};
    for (int c = 0; c < 3; ++c) u[c] = load(step.d[c] + s);
    pull_all(std::make_index_sequence<spring_slots.size()>{}, a, step.d, s, u, f);
    push(a, step.pressure, s, f);
    const Floats mass = load(a.mass + s);
    Floats r[3];
    for (int c = 0; c < 3; ++c) {
      r[c] = load(step.r[c] + s) + (f[c] - mass * u[c]);
      store(step.r[c] + s, r[c]);
    }
    if constexpr (Update) {
      Floats change[3];
      precondition(a, s, r, change);
      for (int c = 0; c < 3; ++c) {
        const Floats d = step.keep * u[c] + step.add * change[c];
        store(step.direction[c] + s, d);
        store(step.z[c] + s, load(step.z[c] + s) + d);
      }
    }
  }
}

inline void smooth(const RestStencil& a, const RestSmoothing& step, std::ptrdiff_t first,
                   std::ptrdiff_t last) {
  if (step.direction[0])
    smooth_range<true>(a, step, first, last);
  else
    smooth_range<false>(a, step, first, last);
}

/// Sums over four edges along an axis of differences of d between their ends.
MSS_INLINE Floats four_edges(const float* d, std::ptrdiff_t along, std::ptrdiff_t one, std::ptrdiff_t other) {
  return ((load(d + along) - load(d)) + (load(d + along + one) - load(d + one))) +
         ((load(d + along + other) - load(d + other)) +
          (load(d + along + one + other) - load(d + one + other)));
}

inline void pressure(const RestStencil& a, const float* const d[3], float* out, std::ptrdiff_t first,
                     std::ptrdiff_t last) {
  const std::ptrdiff_t row = a.row, plane = a.plane;
  for (std::ptrdiff_t s = first; s < last; s += width)
    store(out + s,
          load(a.cell + s) * (four_edges(d[0] + s, 1, row, plane) + four_edges(d[1] + s, row, 1, plane) +
                              four_edges(d[2] + s, plane, 1, row)));
}

inline void start(const RestStencil& a, const float* const r[3], float add, bool continued, float* const d[3],
                  float* const z[3], std::ptrdiff_t first, std::ptrdiff_t last) {
  for (std::ptrdiff_t s = first; s < last; s += width) {
    Floats value[3], change[3];
    for (int c = 0; c < 3; ++c) value[c] = load(r[c] + s);
    precondition(a, s, value, change);
    for (int c = 0; c < 3; ++c) {
      store(d[c] + s, add * change[c]);
      const Floats before = continued ? load(z[c] + s) : Floats{};
      store(z[c] + s, before + add * change[c]);
    }
  }
}

/// out = a + (b + c) / 2; nullptr: none.
MSS_INLINE void add_halves(const float* a, const float* b, const float* c, float* out, std::ptrdiff_t n) {
  if (b && c)
    for (std::ptrdiff_t i = 0; i < n; ++i) out[i] = a[i] + 0.5F * (b[i] + c[i]);
  else if (b || c) {
    const float* one = b ? b : c;
    for (std::ptrdiff_t i = 0; i < n; ++i) out[i] = a[i] + 0.5F * one[i];
  } else
    for (std::ptrdiff_t i = 0; i < n; ++i) out[i] = a[i];
}

/// Along z, then y, then x. Behind the last plane and row of an odd number of cells there is nothing.
inline void restrict_plane(const RestTransfer& t, const float* fine, float* coarse, int plane,
                           float* scratch) {
  const int ny = t.fine_cells[1], nz = t.fine_cells[2], k = 2 * plane;
  const std::ptrdiff_t row = t.fine_row, used = row * (ny + 1);
  const float* at = fine + t.fine_plane * k;
  float *sums = scratch, *line = scratch + used + 1;
  if (k <= nz)
    add_halves(at, k > 0 ? at - t.fine_plane : nullptr, k < nz ? at + t.fine_plane : nullptr, sums, used);
  else
    for (std::ptrdiff_t i = 0; i < used; ++i) sums[i] = 0.5F * (at - t.fine_plane)[i];
  for (int j = 0; j <= t.coarse_cells[1]; ++j) {
    const int l = 2 * j;
    const float* from = sums + row * l;
    if (l <= ny)
      add_halves(from, l > 0 ? from - row : nullptr, l < ny ? from + row : nullptr, line, row);
    else
      for (std::ptrdiff_t i = 0; i < row; ++i) line[i] = 0.5F * (from - row)[i];
    line[-1] = line[row] = line[row + 1] = 0;
    float* to = coarse + t.coarse_plane * plane + t.coarse_row * j;
    for (std::ptrdiff_t i = 0; i <= t.coarse_cells[0]; ++i)
      to[i] = line[2 * i] + 0.5F * (line[2 * i - 1] + line[2 * i + 1]);
  }
}

/// even[0], odd[0], even[1], odd[1] ...
MSS_INLINE void store_interleaved(float* to, Floats even, Floats odd) {
#if defined(__AVX512F__)
  store(to, __builtin_shufflevector(even, odd, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23));
  store(to + width,
        __builtin_shufflevector(even, odd, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31));
#elif defined(__AVX2__)
  store(to, __builtin_shufflevector(even, odd, 0, 8, 1, 9, 2, 10, 3, 11));
  store(to + width, __builtin_shufflevector(even, odd, 4, 12, 5, 13, 6, 14, 7, 15));
#else
  store(to, __builtin_shufflevector(even, odd, 0, 4, 1, 5));
  store(to + width, __builtin_shufflevector(even, odd, 2, 6, 3, 7));
#endif
}

/// A row between two of means. `beyond`: what lies behind it may be overwritten.
inline void interpolate_row(const RestTransfer& t, const float* one, const float* other, float* out,
                            bool beyond) {
  if (beyond) {
    for (std::ptrdiff_t i = 0; i < t.coarse_row; i += width) {
      const Floats here = 0.5F * (load(one + i) + load(other + i)),
                   next = 0.5F * (load(one + i + 1) + load(other + i + 1));
      store_interleaved(out + 2 * i, here, 0.5F * (here + next));
    }
    return;
  }
  const auto mean = [&](std::ptrdiff_t i) { return 0.5F * (one[i] + other[i]); };
  for (std::ptrdiff_t i = 0; 2 * i < t.fine_row; ++i) out[2 * i] = mean(i);
  for (std::ptrdiff_t i = 0; 2 * i + 1 < t.fine_row; ++i) out[2 * i + 1] = 0.5F * (mean(i) + mean(i + 1));
}

inline void interpolate_plane(const RestTransfer& t, const float* coarse, float* d, float* z, int plane,
                              float* scratch) {
  const std::ptrdiff_t used = t.coarse_row * (t.coarse_cells[1] + 1);
  const float* below = coarse + t.coarse_plane * (plane / 2);
  const float* above = coarse + t.coarse_plane * ((plane + 1) / 2);
  for (std::ptrdiff_t i = 0; i < used; ++i) scratch[i] = 0.5F * (below[i] + above[i]);
  float* out = d + t.fine_plane * plane;
  const bool long_rows = t.fine_row >= 2 * width;  // so that what is overwritten ends in the next one
  for (int j = 0; j <= t.fine_cells[1]; ++j)
    interpolate_row(t, scratch + t.coarse_row * (j / 2), scratch + t.coarse_row * ((j + 1) / 2),
                    out + t.fine_row * j, long_rows && j < t.fine_cells[1]);
  float* sum = z + t.fine_plane * plane;
  for (std::ptrdiff_t i = 0; i < t.fine_row * (t.fine_cells[1] + 1); ++i) sum[i] += out[i];
}

inline void multiply(const float* a, std::ptrdiff_t n, const float* x, float* y, std::ptrdiff_t first,
                     std::ptrdiff_t last) {
  constexpr int together = int(64 / width);
  std::ptrdiff_t row = first;
  const auto rows = [&]<int count>() {
    Floats sum[count]{};
    for (std::ptrdiff_t column = 0; column < n; ++column)
      for (int c = 0; c < count; ++c) sum[c] += x[column] * load(a + n * column + row + width * c);
    for (int c = 0; c < count; ++c) store(y + row + width * c, sum[c]);
    row += width * count;
  };
  while (row + 64 <= last) rows.template operator()<together>();
  while (row < last) rows.template operator()<1>();
}

inline void turn_back(const float* const q[9], const double* const g[3], double scale, float* const r[3],
                      std::ptrdiff_t first, std::ptrdiff_t last) {
  for (int c = 0; c < 3; ++c)
    for (std::ptrdiff_t s = first; s < last; ++s) r[c][s] = float(scale * g[c][s]);
  for (std::ptrdiff_t s = first; s < last; s += width) {
    Floats given[3];
    for (int c = 0; c < 3; ++c) given[c] = load(r[c] + s);
    for (int c = 0; c < 3; ++c)
      store(r[c] + s,
            load(q[c] + s) * given[0] + (load(q[3 + c] + s) * given[1] + load(q[6 + c] + s) * given[2]));
  }
}

inline void turn(const float* const q[9], const float* const z[3], double scale, double* const out[3],
                 std::ptrdiff_t first, std::ptrdiff_t last) {
  constexpr std::ptrdiff_t some = 256;
  float turned[some];
  for (std::ptrdiff_t begin = first; begin < last; begin += some) {
    const std::ptrdiff_t count = last - begin < some ? last - begin : some;
    for (std::ptrdiff_t c = 0; c < 3; ++c) {
      for (std::ptrdiff_t s = 0; s < count; s += width) {
        const std::ptrdiff_t at = begin + s;
        store(turned + s,
              load(q[3 * c] + at) * load(z[0] + at) +
                  (load(q[3 * c + 1] + at) * load(z[1] + at) + load(q[3 * c + 2] + at) * load(z[2] + at)));
      }
      for (std::ptrdiff_t s = 0; s < count; ++s) out[c][begin + s] = scale * double(turned[s]);
    }
  }
}

inline void scale_positions(const double* const x[3], const double middle[3], double scale,
                            float* const out[3], std::ptrdiff_t first, std::ptrdiff_t last) {
  for (int c = 0; c < 3; ++c)
    for (std::ptrdiff_t s = first; s < last; ++s) out[c][s] = float(scale * (x[c][s] - middle[c]));
}

/// Higham's iteration, F <- (F + F^-T) / 2. SIAM J. Sci. Stat. Comput. 7 (1986) 1160.
MSS_INLINE void halve_stretch(Floats f[9]) {
  const Floats c0 = f[4] * f[8] - f[5] * f[7], c1 = f[5] * f[6] - f[3] * f[8], c2 = f[3] * f[7] - f[4] * f[6],
               c3 = f[2] * f[7] - f[1] * f[8], c4 = f[0] * f[8] - f[2] * f[6], c5 = f[1] * f[6] - f[0] * f[7],
               c6 = f[1] * f[5] - f[2] * f[4], c7 = f[2] * f[3] - f[0] * f[5], c8 = f[0] * f[4] - f[1] * f[3];
  const Floats half = 0.5F / (f[0] * c0 + f[1] * c1 + f[2] * c2);
  const Floats cofactor[9] = {c0, c1, c2, c3, c4, c5, c6, c7, c8};
  for (int i = 0; i < 9; ++i) f[i] = 0.5F * f[i] + half * cofactor[i];
}

inline void rotations(const RestStencil& a, const float* const x[3], const float* const shares[6],
                      const float* unit, float* const q[9], std::ptrdiff_t first, std::ptrdiff_t last) {
  constexpr int iterations = 4;
  constexpr float least = 0.05F;  // of the volume at rest: what is flatter does not turn
  const std::ptrdiff_t offset[3] = {1, a.row, a.plane};
  for (std::ptrdiff_t s = first; s < last; s += width) {
    Floats f[9];
    for (std::ptrdiff_t axis = 0; axis < 3; ++axis) {
      const Floats ahead = load(shares[2 * axis] + s), behind = load(shares[2 * axis + 1] + s);
      for (int i = 0; i < 3; ++i) {
        const float* at = x[i] + s;
        f[3 * i + axis] =
            ahead * (load(at + offset[axis]) - load(at)) + behind * (load(at) - load(at - offset[axis]));
      }
    }
    const Floats det = f[0] * (f[4] * f[8] - f[5] * f[7]) + f[1] * (f[5] * f[6] - f[3] * f[8]) +
                       f[2] * (f[3] * f[7] - f[4] * f[6]);
    const auto good = det > least;
    const Floats one = constant<Floats>(1), zero{}, keep = load(unit + s);
    for (int i = 0; i < 9; ++i) f[i] = good ? f[i] : (i % 4 == 0 ? one : zero);
    for (int i = 0; i < iterations; ++i) halve_stretch(f);
    for (int i = 0; i < 9; ++i) store(q[i] + s, good ? f[i] : (i % 4 == 0 ? keep : zero));
  }
}

inline RestKernels make_rest_kernels(const char* name) {
  return {.name = name,
          .pressure = pressure,
          .smooth = smooth,
          .start = start,
          .restrict_plane = restrict_plane,
          .interpolate_plane = interpolate_plane,
          .multiply = multiply,
          .turn_back = turn_back,
          .turn = turn,
          .scale_positions = scale_positions,
          .rotations = rotations};
}

}  // namespace mss::MSS_ISA

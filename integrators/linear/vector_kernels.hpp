#pragma once

#include <cstddef>

#include "core/kernels/dispatch.hpp"

namespace mss {

/// out[i n + l] = sum_k in[k stride + i] basis[k columns + l] for i in [0, count), k and l in [0, n): a small
/// matrix along the slowest axis of an array, which becomes the fastest. Three of these transform along all
/// axes and leave their order as it was.
struct AxisTransform {
  int n = 0;
  int columns = 0;                ///< of the basis, a multiple of transform_padding, zero from n on
  const double* basis = nullptr;  ///< n x columns
  const double* in = nullptr;
  std::ptrdiff_t stride = 0;
  std::ptrdiff_t count = 0;
  double* out = nullptr;          ///< up to transform_padding numbers behind the last are overwritten
  const double* scale = nullptr;  ///< multiplies out, number by number, and is as long; nullptr: does not
};
inline constexpr int transform_padding = 8;

/// Loops over arrays that the quasi-Newton methods spend their time in, compiled for one instruction set.
/// Contraction to fused multiply-adds is on, so results differ between instruction sets by rounding.
struct VectorKernels {
  const char* name;  ///< "x86-64-v3" and the like

  void (*transform)(const AxisTransform&);
  /// a.b of n numbers
  double (*dot)(const double* a, const double* b, std::ptrdiff_t n);
  /// y += a x
  void (*add)(double a, const double* x, double* y, std::ptrdiff_t n);
  /// v += a p, x = x_base + b v
  void (*move)(double a, const double* p, double b, const double* x_base, double* v, double* x,
               std::ptrdiff_t n);
  /// g = m (v - v_base) - b g where m is not 0, else 0
  void (*gradient)(const double* m, const double* v, const double* v_base, double b, double* g,
                   std::ptrdiff_t n);
};

MSS_KERNEL_COPIES(VectorKernels);

}  // namespace mss

#pragma once

#include <cstddef>

#include "core/kernels/dispatch.hpp"

namespace mss {

/// Rows of a panel, a multiple of every instruction set's vectors.
inline constexpr int panel_rows = 32;

/// A tall matrix in panels of rows, each column by column: entry (i, c) is
/// values[((i / panel_rows) columns + c) panel_rows + i % panel_rows].
template <class Real>
struct Panels {
  const Real* values = nullptr;
  std::ptrdiff_t panels = 0;
  int columns = 0;
};

/// Numbers of a row of CubicForce's coefficients are padded to a multiple of that.
inline constexpr int coordinate_padding = 8;

/// A force that is a cubic polynomial of r coordinates without a constant term:
///   f_i = sum_a q_a (linear_ai + sum_{b <= a} q_b (quadratic_abi + sum_{c <= b} q_c cubic_abci)),
/// rows of `padded` numbers in the order of these loops.
struct CubicForce {
  int coordinates = 0;
  int padded = 0;  ///< the next multiple of coordinate_padding
  const double* linear = nullptr;
  const double* quadratic = nullptr;
  const double* cubic = nullptr;
};
inline constexpr int most_coordinates = 96;

/// Loops of reduced bodies, compiled for one instruction set; results differ between these by rounding.
struct ReductionKernels {
  const char* name;
  /// out[i] = base[i] + sum_c a_ic q_c, for all rows of all panels.
  void (*expand)(const Panels<double>& a, const double* base, const double* q, double* out);
  /// The same in single precision, of half the memory, which is what it costs.
  void (*expand_single)(const Panels<float>& a, const float* base, const float* q, float* out);
  /// p[c] = sum_i a_ic f_i, for all rows of all panels.
  void (*project)(const Panels<double>& a, const double* f, double* p);
  /// f has `padded` numbers.
  void (*cubic_force)(const CubicForce& polynomial, const double* q, double* f);
};

MSS_KERNEL_COPIES(ReductionKernels);

}  // namespace mss

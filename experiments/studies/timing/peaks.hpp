#pragma once

#include <cstddef>

#include "core/kernels/dispatch.hpp"

namespace mss::studies::timing {

/// A loop of fused multiply-adds on registers.
struct MultiplyAdd {
  double (*run)(long rounds);  ///< returns a number that depends on all of them
  double flops;                ///< of a round
};

/// The loops that measure a processor's limits, compiled for one instruction set.
struct PeakLoops {
  const char* instruction_set;
  MultiplyAdd in_double, in_single;
  /// a = b + s c on `count` numbers; the arrays do not overlap.
  void (*triad)(double* a, const double* b, const double* c, double s, std::ptrdiff_t count);
};

}  // namespace mss::studies::timing

namespace mss {
MSS_KERNEL_COPIES(studies::timing::PeakLoops);
}  // namespace mss

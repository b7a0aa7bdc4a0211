#pragma once

#include <cstddef>

#include "core/kernels/dispatch.hpp"

namespace mss {

/// Maxwell branches (core/body/relaxation.hpp) of one slot (spring_slots.hpp) of a plane's sites, `count`
/// each. Pointers to positions are to the two ends of the first site's spring.
template <class Real>
struct BranchRow {
  std::ptrdiff_t count;
  const Real* stiffness;    ///< the branch's [N/m]; 0: there is none
  Real decay, gain;         ///< of the step
  const Real *a[3], *b[3];  ///< positions of the ends [m]
  Real *length, *tension;   ///< where the last step ended [m], [N]
};

/// Loops over a row.
template <class Real>
struct BranchKernel {
  const char* name;
  /// Force on the ends at a, 3 x `stride` numbers [N].
  void (*pull)(const BranchRow<Real>& row, Real* force, std::ptrdiff_t stride);
  /// Lengths and tensions become those of now; the tensions before, and the branch's stiffness times the
  /// changes of length [N].
  void (*advance)(const BranchRow<Real>& row, Real* before, Real* stretched);
  /// target += sign force, of one axis.
  void (*add)(std::ptrdiff_t count, Real sign, const Real* force, Real* target);
};

MSS_KERNEL_COPIES(BranchKernel<float>);
MSS_KERNEL_COPIES(BranchKernel<double>);

}  // namespace mss

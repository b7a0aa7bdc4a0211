#pragma once

#include <cstddef>

namespace mss {

/// One axis of a plane in a short step of LocalSteps, `count` numbers each:
///   d_{k+1} = of_now d_k - of_before d_{k-1} + of_acceleration a,   position += moves (d_{k+1} - d_k),
/// after the last step position -= moves d_k, so that positions are where they were before the first.
template <class Real>
struct ShortStepPlane {
  std::ptrdiff_t count;
  Real of_now, of_before, of_acceleration;
  const Real* acceleration;  ///< null: it is mobility (frozen + force)
  const Real *mobility, *frozen, *force;
  const Real* now;    ///< d_k; null: 0, as in the first step
  Real* next;         ///< in: d_{k-1}, not read if of_before is 0; out: d_{k+1}
  const Real* moves;  ///< null: 1
  Real* position;
  bool last;
};

}  // namespace mss

#pragma once

#include "core/base/field.hpp"

namespace mss {

/// Positions [m] and velocities [m/s] of every site at time t [s].
template <class Real>
struct State {
  double t = 0;
  Field<Real> x;
  Field<Real> v;
};

/// True if all positions and velocities of particles are finite numbers.
template <class Real>
bool is_finite(const State<Real>& state) {
  // Infinity and NaN survive multiplication by zero, everything else does not.
  const auto zero = [](const Field<Real>& f) { return (f.array() * Real(0)).sum() == Real(0); };
  return zero(state.x) && zero(state.v);
}

}  // namespace mss

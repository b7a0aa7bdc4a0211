#pragma once

#include <algorithm>
#include <cmath>
#include <memory>

#include "integrators/integrator.hpp"

namespace mss {

/// Many small additions leave t a little off the end.
inline void shed_rounding(double& t, double dt, double t_end) {
  if (std::abs(t - t_end) < 1e-6 * dt) t = t_end;
}

/// Runs take(n), which makes n steps of size dt, until state.t is as near to t_end as whole steps come. Looks
/// for infinities every few dozen steps: often enough to stop early, seldom enough to cost nothing.
template <class Real, class Take>
Status advance_fixed(State<Real>& state, double dt, double t_end, Work& work, Take&& take) {
  constexpr long between_checks = 32;
  for (long left = std::lround((t_end - state.t) / dt); left > 0;) {
    const long n = std::min(left, between_checks);
    take(n);
    work.steps += n;
    left -= n;
    if (!is_finite(state)) return Status::non_finite;
  }
  shed_rounding(state.t, dt, t_end);
  return Status::ok;
}

/// The same for methods whose steps can fail: take() makes one and says how it went.
template <class Real, class Take>
Status advance_step_by_step(State<Real>& state, double dt, double t_end, Work& work, Take&& take) {
  for (long left = std::lround((t_end - state.t) / dt); left > 0; --left) {
    if (const Status status = take(); status != Status::ok) return status;
    ++work.steps;
    if (!is_finite(state)) return Status::non_finite;
  }
  shed_rounding(state.t, dt, t_end);
  return Status::ok;
}

/// Completes a method's facts with what makes it.
template <template <class> class Method>
IntegratorInfo describe(IntegratorInfo info) {
  info.make_single = [](const IntegratorOptions& o) { return std::make_unique<Method<float>>(o); };
  info.make_double = [](const IntegratorOptions& o) { return std::make_unique<Method<double>>(o); };
  return info;
}

}  // namespace mss

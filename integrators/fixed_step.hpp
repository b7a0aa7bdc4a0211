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

/// Follows a method's steps where bodies collide at their end; where they do not, it does nothing.
template <class Real>
class Collisions {
 public:
  Collisions(Integrator<Real>& method, System<Real>& system, double dt)
      : method_(method), system_(system), dt_(dt), active_(system.collides()) {}

  /// Whether steps must be taken one at a time.
  bool active() const { return active_; }

  void step_begins(const State<Real>& state) {
    if (active_) before_ = state;
  }
  void step_ends(State<Real>& state) {
    if (active_ && system_.collide(before_, dt_, state)) method_.reset();
  }

 private:
  Integrator<Real>& method_;
  System<Real>& system_;
  double dt_;
  bool active_;
  State<Real> before_;
};

/// Runs take(n), which makes n steps of size dt, until state.t is as near to t_end as whole steps come. Looks
/// for infinities every few dozen steps: often enough to stop early, seldom enough to cost nothing. After
/// collisions the method is reset, so take() must begin anew by itself.
template <class Real, class Take>
Status advance_fixed(Integrator<Real>& method, System<Real>& system, State<Real>& state, double dt,
                     double t_end, Work& work, Take&& take) {
  constexpr long between_checks = 32;
  Collisions<Real> collisions(method, system, dt);
  for (long left = std::lround((t_end - state.t) / dt); left > 0;) {
    const long n = std::min(left, between_checks), at_once = collisions.active() ? 1 : n;
    for (long taken = 0; taken < n; taken += at_once) {
      collisions.step_begins(state);
      take(at_once);
      collisions.step_ends(state);
    }
    work.steps += n;
    left -= n;
    if (!is_finite(state)) return Status::non_finite;
  }
  shed_rounding(state.t, dt, t_end);
  return Status::ok;
}

/// The same for methods whose steps can fail: take() makes one and says how it went.
template <class Real, class Take>
Status advance_step_by_step(Integrator<Real>& method, System<Real>& system, State<Real>& state, double dt,
                            double t_end, Work& work, Take&& take) {
  Collisions<Real> collisions(method, system, dt);
  for (long left = std::lround((t_end - state.t) / dt); left > 0; --left) {
    collisions.step_begins(state);
    if (const Status status = take(); status != Status::ok) return status;
    collisions.step_ends(state);
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

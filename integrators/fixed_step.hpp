#pragma once

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/system/plane_impulses.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// Removes from t the rounding that many small additions have left.
inline void snap_to_end_time(double& t, double dt, double t_end) {
  if (std::abs(t - t_end) < 1e-6 * dt) t = t_end;
}

/// Applies a system's step events, collisions and sleep, around a method's steps, and tells its memory where
/// these end; does nothing where there are none.
template <class Real>
class BetweenSteps {
 public:
  BetweenSteps(Integrator<Real>& method, System<Real>& system, double dt, bool may_sleep)
      : method_(method),
        events_(system.events()),
        impulses_(system.plane_impulses()),
        memory_(system.memory()),
        dt_(dt),
        collides_(events_ && events_->collides() &&
                  !(method.collisions() == Collisions::inside_steps && system.bounds())),
        sleeps_(may_sleep && events_ && events_->sleeps()) {}

  /// Whether steps must be taken one at a time.
  bool active() const { return collides_ || sleeps_ || memory_; }
  /// Whether a step would change the time only.
  bool all_asleep() const { return sleeps_ && events_->all_asleep(); }

  /// A step in which that is so.
  void sleeps_on() {
    if (impulses_) impulses_->end_step(dt_);
  }

  /// To be called once, before the first step.
  void begin(const State<Real>& state) {
    if (memory_) memory_->come_to(state);
  }
  void step_begins(const State<Real>& state) {
    if (collides_) before_ = state;
  }
  void step_ends(State<Real>& state) {
    const bool collided = collides_ && events_->collide(before_, dt_, state);
    const bool settled = sleeps_ && events_->settle(state);
    if (memory_) memory_->come_to(state);
    if (collided || settled) method_.reset();
  }

 private:
  Integrator<Real>& method_;
  StepEvents<Real>* events_;  ///< nullptr: nothing happens between steps
  PlaneImpulses* impulses_;   ///< nullptr: no plane acts by impulses
  StepMemory<Real>* memory_;  ///< nullptr: nothing relaxes
  double dt_;
  bool collides_, sleeps_;
  State<Real> before_;
};

/// Steps between two checks for infinities: often enough to stop early, seldom enough to cost nothing.
inline constexpr long steps_between_checks = 32;

/// Runs take(n), which makes n steps of size dt, until state.t is as near to t_end as whole steps come. After
/// collisions, and when particles fall asleep or wake, the method is reset, so take() must be able to start
/// without history.
template <class Real, class Take>
Status advance_fixed(Integrator<Real>& method, System<Real>& system, State<Real>& state, double dt,
                     double t_end, Work& work, Take&& take) {
  BetweenSteps<Real> between(method, system, dt, true);
  between.begin(state);
  const auto step_alone = [&] {
    if (between.all_asleep()) {
      between.sleeps_on();
      state.t += dt;
      return;
    }
    between.step_begins(state);
    take(1);
    between.step_ends(state);
  };
  for (long left = std::lround((t_end - state.t) / dt); left > 0;) {
    const long n = std::min(left, steps_between_checks);
    if (!between.active()) take(n);
    for (long taken = 0; between.active() && taken < n; ++taken) step_alone();
    work.steps += n;
    left -= n;
    if (!system.ranks().all(is_finite(state))) return Status::non_finite;
  }
  snap_to_end_time(state.t, dt, t_end);
  return Status::ok;
}

/// The same for methods whose steps can fail: take() makes one and returns its status. They evaluate forces,
/// not accelerations, so nothing falls asleep.
template <class Real, class Take>
Status advance_step_by_step(Integrator<Real>& method, System<Real>& system, State<Real>& state, double dt,
                            double t_end, Work& work, Take&& take) {
  BetweenSteps<Real> between(method, system, dt, false);
  between.begin(state);
  for (long left = std::lround((t_end - state.t) / dt); left > 0; --left) {
    between.step_begins(state);
    if (const Status status = take(); status != Status::ok) return status;
    between.step_ends(state);
    ++work.steps;
    if (!system.ranks().all(is_finite(state))) return Status::non_finite;
  }
  snap_to_end_time(state.t, dt, t_end);
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

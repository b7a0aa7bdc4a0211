#pragma once

#include <vector>

#include "core/base/state.hpp"

namespace mss {

/// What happens to a system between the steps of a method: contact by impulses, and sleep.
///
/// All functions are pure virtual, so that a class that wraps another's events must define each of them.
template <class Real>
class StepEvents {
 public:
  StepEvents() = default;
  StepEvents(const StepEvents&) = delete;
  StepEvents& operator=(const StepEvents&) = delete;
  virtual ~StepEvents() = default;

  /// True if bodies collide at the end of steps: then collide() must be called after each.
  virtual bool collides() const = 0;

  /// True if planes push by forces, which belong to those of the system.
  virtual bool presses() const = 0;

  /// Longest step that resolves the body's fastest motion, 2 over its angular frequency [s].
  virtual double resolved_step() const = 0;

  /// Longest step in which gravity hardly moves a body: what knows no modulus must not fall further between
  /// collisions [s].
  virtual double fall_step() const = 0;

  /// Applies the collisions of a step of dt that led from `before` to `state`. False if nothing changed.
  virtual bool collide(const State<Real>& before, double dt, State<Real>& state) = 0;

  /// True if particles may fall asleep: then methods that step by accelerations call settle() after each
  /// step.
  virtual bool sleeps() const = 0;

  /// Puts to sleep what rests and wakes what is disturbed. True if either happened: some particles have lost
  /// their velocity, or got an acceleration.
  virtual bool settle(State<Real>& state) = 0;

  /// True if steps would change nothing but the time.
  virtual bool all_asleep() const = 0;

  /// Functions of time and positions that become negative where the force is not smooth [m]; none if it is
  /// smooth everywhere. Methods that choose their steps should end one at such a root.
  virtual std::vector<double> event_functions(double t, const Field<Real>& x) const = 0;
};

}  // namespace mss

#pragma once

#include "core/base/state.hpp"

namespace mss {

class Record;

/// A body whose particles follow a few coordinates q, their number far below that of particles: positions and
/// velocities are functions of q and its rate, and these are what is stepped. Double precision.
///
/// All functions are pure virtual, so that each model says what it does.
class ReducedMotion {
 public:
  ReducedMotion() = default;
  ReducedMotion(const ReducedMotion&) = delete;
  ReducedMotion& operator=(const ReducedMotion&) = delete;
  virtual ~ReducedMotion() = default;

  /// How many there are, those of a floating frame not counted.
  virtual int coordinates() const = 0;

  /// Longest step that is sure to be stable and resolves what acts on the body [s]; infinite where steps are
  /// exact whatever their length.
  virtual double longest_step() const = 0;

  /// Goes to the coordinates nearest to a state, in the sum of m |x - x(q)|^2, and to its time.
  virtual void take(const State<double>& state) = 0;

  /// Takes steps of dt [s]. False where a coordinate is no longer finite.
  virtual bool step(double dt, long steps) = 0;

  /// Writes positions and velocities of all particles, and the time.
  virtual void give(State<double>& state) const = 0;

  /// Writes positions alone, as exactly as a picture needs: displacements may be of single precision.
  virtual void draw(Field<double>& x) const = 0;

  /// Keeps coordinates, rates and time in a record, or takes them from one (core/base/record.hpp).
  virtual void remember(Record& record) = 0;
};

}  // namespace mss

#pragma once

#include "core/base/state.hpp"

namespace mss {

/// What a system remembers of its motion, where its forces depend on more than positions and velocities of
/// the moment: the material's relaxation, and where friction holds what touches.
///
/// Until the first step, and after forget(), all strains have been there for ever. From the end of the last
/// step on, forces at (t, x) are those after straight motion from there to x: so methods of first and second
/// order may ask for forces at any time within a step, as often as they like, as long as they tell where it
/// ended.
template <class Real>
class StepMemory {
 public:
  StepMemory() = default;
  StepMemory(const StepMemory&) = delete;
  StepMemory& operator=(const StepMemory&) = delete;
  virtual ~StepMemory() = default;

  /// The system has come to a state: at the end of every step, and where a method begins. What it has come to
  /// already changes nothing.
  virtual void come_to(const State<Real>& state) = 0;

  /// What strains there are have been there for ever; friction holds nothing.
  virtual void forget() = 0;

  /// Whether forces within a step follow the motion in it to second order only, as relaxation's do; else
  /// they depend on the moment and on where the last step ended.
  virtual bool limits_order() const { return true; }

  /// Whether forces depend on it; else it only watches where steps end.
  virtual bool matters() const { return true; }
};

}  // namespace mss

#pragma once

#include "core/base/state.hpp"
#include "integrators/integrator.hpp"

namespace mss {

template <class Real>
class DeviceSystem;

/// A method on a device, to those who would not have its state carried back and forth in every advance.
template <class Real>
class StateOnDevice {
 public:
  StateOnDevice() = default;
  StateOnDevice(const StateOnDevice&) = delete;
  StateOnDevice& operator=(const StateOnDevice&) = delete;
  virtual ~StateOnDevice() = default;

  /// From now on advances give back the time only, and positions and velocities stay there: what an advance
  /// is given is taken over in the first one and after each reset() alone.
  virtual void leave_there() = 0;
  /// Positions and velocities after the last advance; leaves a state alone that has them. On
  /// Status::device_lost the state is that of the last time they were fetched.
  virtual Status fetch(State<Real>& state) = 0;
  /// The body that is there; nullptr: what the next advance is given will be.
  virtual DeviceSystem<Real>* body() = 0;
};

}  // namespace mss

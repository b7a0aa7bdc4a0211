#pragma once

#include "core/body/body_config.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// Whose steps a device takes; several methods may have the same ones.
enum class DeviceSteps {
  explicit_euler,
  semi_implicit_euler,
  velocity_verlet,
  damped_verlet,
  rk4,
  xpbd,
  vbd
};

/// Throws InputError for bodies that a method does not step.
using CheckBody = void (*)(const BodyConfig& body, const std::string& method);

/// Completes a method's facts with what makes it on a device, see core/device/device_system.hpp. `check`:
/// nullptr: it steps all that a device does.
IntegratorInfo on_device(DeviceSteps steps, IntegratorInfo info, CheckBody check = nullptr);

}  // namespace mss

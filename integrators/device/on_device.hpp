#pragma once

#include "integrators/integrator.hpp"

namespace mss {

/// Whose steps a device takes; several methods may have the same ones.
enum class DeviceSteps { explicit_euler, semi_implicit_euler, velocity_verlet, damped_verlet, rk4 };

/// Completes a method's facts with what makes it on a device, see core/device/device_system.hpp.
IntegratorInfo on_device(DeviceSteps steps, IntegratorInfo info);

}  // namespace mss

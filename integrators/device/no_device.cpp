// In place of on_device.cpp in a program that is built without devices.
#include "core/device/device.hpp"
#include "integrators/device/on_device.hpp"

namespace mss {

IntegratorInfo on_device(DeviceSteps, IntegratorInfo info, CheckBody) {
  info.make_single_on_device = [](const IntegratorOptions&) -> std::unique_ptr<Integrator<float>> {
    list_devices();  // throws
    return nullptr;
  };
  info.make_double_on_device = [](const IntegratorOptions&) -> std::unique_ptr<Integrator<double>> {
    list_devices();
    return nullptr;
  };
  return info;
}

}  // namespace mss

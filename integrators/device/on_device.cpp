#include "integrators/device/on_device.hpp"

#include "integrators/device/explicit_steps.hpp"
#include "integrators/device/vbd_steps.hpp"
#include "integrators/device/xpbd_steps.hpp"

namespace mss {

namespace {

template <class Real>
std::unique_ptr<StepsOnDevice<Real>> make_steps(DeviceSteps steps, const IntegratorOptions& options) {
  const double dt = options.dt;
  switch (steps) {
    case DeviceSteps::explicit_euler:
      return std::make_unique<OneUpdate<Real>>(KickDrift{.kick_before = dt, .drift_old = dt});
    case DeviceSteps::semi_implicit_euler:
      return std::make_unique<OneUpdate<Real>>(KickDrift{.kick_before = dt, .drift_new = dt});
    case DeviceSteps::velocity_verlet:
      return std::make_unique<VelocityVerletSteps<Real>>();
    case DeviceSteps::damped_verlet:
      return std::make_unique<DampedVerletSteps<Real>>();
    case DeviceSteps::rk4:
      return std::make_unique<Rk4Steps<Real>>();
    case DeviceSteps::xpbd:
      return std::make_unique<XpbdSteps<Real>>(options);
    case DeviceSteps::vbd:
      return std::make_unique<VbdSteps<Real>>(options);
  }
  return nullptr;
}

template <class Real>
auto make(DeviceSteps steps, const std::string& method, CheckBody check) {
  return [=](const IntegratorOptions& options) -> std::unique_ptr<Integrator<Real>> {
    typename DeviceIntegrator<Real>::CheckBody check_body;
    if (check) check_body = [=](const BodyConfig& body) { check(body, method); };
    return std::make_unique<DeviceIntegrator<Real>>(options, make_steps<Real>(steps, options), check_body);
  };
}

}  // namespace

IntegratorInfo on_device(DeviceSteps steps, IntegratorInfo info, CheckBody check) {
  info.make_single_on_device = make<float>(steps, info.name, check);
  info.make_double_on_device = make<double>(steps, info.name, check);
  return info;
}

}  // namespace mss

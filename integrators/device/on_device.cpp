#include "integrators/device/on_device.hpp"

#include "integrators/device/explicit_steps.hpp"

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
  }
  return nullptr;
}

template <class Real>
std::unique_ptr<Integrator<Real>> make(DeviceSteps steps, const IntegratorOptions& options) {
  return std::make_unique<DeviceIntegrator<Real>>(options, make_steps<Real>(steps, options));
}

}  // namespace

IntegratorInfo on_device(DeviceSteps steps, IntegratorInfo info) {
  info.make_single_on_device = [steps](const IntegratorOptions& o) { return make<float>(steps, o); };
  info.make_double_on_device = [steps](const IntegratorOptions& o) { return make<double>(steps, o); };
  return info;
}

}  // namespace mss

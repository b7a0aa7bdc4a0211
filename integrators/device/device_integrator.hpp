#pragma once

#include <fmt/format.h>

#include <chrono>
#include <functional>
#include <memory>
#include <optional>

#include "core/base/error.hpp"
#include "core/device/device_system.hpp"
#include "integrators/device/state_on_device.hpp"
#include "integrators/fixed_step.hpp"

namespace mss {

/// The steps of a method on a device, whose functions are called within a DeviceUse.
template <class Real>
class StepsOnDevice {
 public:
  StepsOnDevice() = default;
  StepsOnDevice(const StepsOnDevice&) = delete;
  StepsOnDevice& operator=(const StepsOnDevice&) = delete;
  virtual ~StepsOnDevice() = default;

  /// Once, before the first step of a body. Throws InputError for one that it does not step.
  virtual void begin(DeviceSystem<Real>& system) { static_cast<void>(system); }
  /// Takes so many steps of dt from time t.
  virtual void take(DeviceSystem<Real>& system, double t, double dt, long steps) = 0;
  virtual int forces_in_step() const { return 1; }
  /// As Integrator's.
  virtual void reset() {}
  virtual void remember(DeviceSystem<Real>& system, Record& record) {
    static_cast<void>(system), static_cast<void>(record);
  }
};

/// A method of fixed step on a device: an advance carries the state there, takes its steps, and carries it
/// back, or leaves it there.
template <class Real>
class DeviceIntegrator final : public Integrator<Real>, public StateOnDevice<Real> {
 public:
  /// Throws InputError for bodies that the method does not step.
  using CheckBody = std::function<void(const BodyConfig&)>;

  /// Throws InputError if there is no such device.
  DeviceIntegrator(const IntegratorOptions& options, std::unique_ptr<StepsOnDevice<Real>> steps,
                   CheckBody check = {})
      : device_(Device::open(options.device)),
        steps_(std::move(steps)),
        check_(std::move(check)),
        dt_(options.dt) {}

  std::string device() const override { return device_->info().name + ", OpenGL " + device_->info().version; }
  double transfer_seconds() const override { return transfer_seconds_; }
  void reset() override {
    steps_->reset();
    is_there_ = false;
  }
  void remember(System<Real>& system, Record& record) override {
    const DeviceUse use(*device_);
    steps_->remember(on_device(system, 0), record);
    if (record.reads()) is_there_ = false;
  }
  void leave_there() override { stays_ = true; }
  Status fetch(State<Real>& state) override {
    if (!is_there_ || is_here_) return Status::ok;
    return unless_lost(state, [&] {
      const DeviceUse use(*device_);
      give_back(state, state.t);
      is_here_ = true;
      return Status::ok;
    });
  }
  DeviceSystem<Real>* body() override { return is_there_ ? &*body_ : nullptr; }

 private:
  Status do_advance(System<Real>& system, State<Real>& state, double t_end, Work& work) override {
    return unless_lost(state, [&] {
      const DeviceUse use(*device_);
      DeviceSystem<Real>& body = on_device(system, state.t);
      if (!is_there_) {
        transfer([&] { body.load(state); });
        time_here_ = state.t;
      }
      is_there_ = is_here_ = false;
      double t = state.t;
      const Status status = take_steps(body, t, t_end, work);
      if (!stays_) give_back(state, t);
      is_there_ = stays_;
      state.t = t;
      return status;
    });
  }

  /// What a lost device returns means nothing: then the state goes back to where it was last here.
  template <class Call>
  Status unless_lost(State<Real>& state, Call&& call) {
    try {
      return call();
    } catch (const DeviceLost&) {
      is_there_ = is_here_ = false;
      state.t = time_here_;
      return Status::device_lost;
    }
  }

  void give_back(State<Real>& state, double t) {
    transfer([&] {
      found_ = state;
      body_->store(found_);
    });
    found_.t = time_here_ = t;
    std::swap(state, found_);
  }

  Status take_steps(DeviceSystem<Real>& body, double& t, double t_end, Work& work) {
    double now = t;
    for (long left = std::lround((t_end - t) / dt_); left > 0;) {
      const long n = std::min(left, steps_between_checks);
      steps_->take(body, now, dt_, n);
      for (long step = 0; step < n; ++step) now += dt_;  // the same bits as on the processor
      left -= n;
      const bool finite = body.is_finite();
      if (device_->is_lost()) throw DeviceLost();
      work.steps += n;
      work.force_evaluations += n * steps_->forces_in_step();
      t = now;
      if (!finite) return Status::non_finite;
    }
    snap_to_end_time(t, dt_, t_end);
    return Status::ok;
  }

  /// Throws InputError if a driver, however well it passed its trial, computes other forces than the
  /// processor.
  void check_forces(System<Real>& system, double t) {
    const double error = body_->error_of_accelerations(system, t);
    if (device_->is_lost()) throw DeviceLost();
    if (!(error < (sizeof(Real) == sizeof(float) ? 1e-3 : 1e-9)))
      throw InputError(
          fmt::format("{} computes accelerations of this body that are off by {:.2g} of the largest; give "
                      "device = \"cpu\"",
                      device(), error));
  }

  DeviceSystem<Real>& on_device(System<Real>& system, double t) {
    if (system_ != &system) {
      system_ = nullptr;
      is_there_ = false;
      body_.emplace(device_, system);
      if (check_) check_(body_->springs().body().config());
      check_forces(system, t);
      reset();
      steps_->begin(*body_);
      system_ = &system;
    }
    return *body_;
  }

  template <class Carry>
  void transfer(Carry&& carry) {
    const auto begun = std::chrono::steady_clock::now();
    carry();
    device_->finish();
    transfer_seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  }

  std::shared_ptr<Device> device_;
  std::unique_ptr<StepsOnDevice<Real>> steps_;
  CheckBody check_;
  double dt_;
  double transfer_seconds_ = 0;
  bool stays_ = false;              ///< the state, on the device between advances
  bool is_there_ = false;           ///< the state that the next advance begins with,
  bool is_here_ = false;            ///< and was fetched
  double time_here_ = 0;            ///< of the positions and velocities that were last here
  State<Real> found_;               ///< what the device gives back; kept, because memory costs time
  System<Real>* system_ = nullptr;  ///< that body_ is of
  std::optional<DeviceSystem<Real>> body_;
};

}  // namespace mss

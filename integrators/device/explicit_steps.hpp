#pragma once

#include "core/base/record.hpp"
#include "integrators/device/device_integrator.hpp"

namespace mss {

/// Methods whose step is one update from the acceleration at its beginning.
template <class Real>
class OneUpdate final : public StepsOnDevice<Real> {
 public:
  explicit OneUpdate(const KickDrift& update) : update_(update) {}

  void take(DeviceSystem<Real>& system, double t, double dt, long steps) override {
    for (long n = 0; n < steps; ++n, t += dt) {
      system.step_begins();
      system.kick_drift(update_, t, t + dt);
      system.collide(dt);
    }
  }

 private:
  KickDrift update_;
};

/// Methods that go on from the acceleration at the end of the step before.
template <class Real>
class StepsWithAcceleration : public StepsOnDevice<Real> {
 public:
  void take(DeviceSystem<Real>& system, double t, double dt, long steps) final {
    find_acceleration(system, t);
    take_from(system, t, dt, steps);
  }
  void reset() final { is_known_ = false; }
  void remember(DeviceSystem<Real>& system, Record& record) final {
    Field<Real> kept;
    if (is_known_) {
      kept = Field<Real>(system.springs().size());
      system.read(acceleration_, kept);
    }
    record.keep_field(kept, system.springs().size());
    is_known_ = kept.size() > 0;
    if (is_known_ && acceleration_.bytes() == 0) acceleration_ = system.make_vectors();
    if (is_known_) system.write(kept, acceleration_);
    system.remember_sticking(record);
  }

 protected:
  using Vectors = typename DeviceSystem<Real>::Vectors;

  virtual void take_from(DeviceSystem<Real>& system, double t, double dt, long steps) = 0;
  Vectors& acceleration() { return acceleration_; }

 private:
  void find_acceleration(DeviceSystem<Real>& system, double t) {
    if (is_known_) return;
    acceleration_ = system.make_vectors();
    system.acceleration(t, system.x(), system.v(), acceleration_);
    is_known_ = true;
  }

  Vectors acceleration_;
  bool is_known_ = false;
};

/// Kick, drift, kick: see integrators/explicit/velocity_verlet.cpp. Between two steps without planes the
/// kicks use the same acceleration, so they fuse with the force.
template <class Real>
class VelocityVerletSteps final : public StepsWithAcceleration<Real> {
  void take_from(DeviceSystem<Real>& system, double t, double dt, long steps) override {
    const double half = dt / 2;
    const auto open = [&] {
      system.apply({.kick_after = half, .drift_new = dt}, this->acceleration(), t + dt);
      t += dt;
    };
    const auto close = [&] {
      system.acceleration(t, system.x(), system.v(), this->acceleration());
      system.apply({.kick_before = half}, this->acceleration(), t);
    };
    if (!system.has_planes()) {
      open();
      for (long n = 1; n < steps; ++n, t += dt)
        system.kick_drift({.kick_before = half, .kick_after = half, .drift_new = dt}, t, t + dt);
      return close();
    }
    for (long n = 0; n < steps; ++n) {
      system.step_begins();
      open();
      close();
      system.collide(dt);
      system.acceleration_if_collided(t, this->acceleration());
    }
  }
};

/// See integrators/explicit/damped_verlet.cpp.
template <class Real>
class DampedVerletSteps final : public StepsWithAcceleration<Real> {
  void take_from(DeviceSystem<Real>& system, double t, double dt, long steps) override {
    auto& a = this->acceleration();
    if (middle_.bytes() == 0) middle_ = system.make_vectors();
    for (long n = 0; n < steps; ++n) {
      system.step_begins();
      system.combine(system.v(), dt / 2, a, middle_);
      system.combine(system.x(), dt, middle_, system.x());
      system.combine(system.v(), dt, a, system.v());
      system.kicked_for(dt / 2);
      t += dt;
      system.constrain(t, system.x(), system.v());
      system.acceleration(t, system.x(), system.v(), a);
      system.kicked_for(dt / 2);
      system.combine(middle_, dt / 2, a, system.v());
      system.constrain(t, system.x(), system.v());
      system.collide(dt);
      if (system.has_planes()) system.acceleration_if_collided(t, a);
    }
  }

  typename DeviceSystem<Real>::Vectors middle_;
};

/// See integrators/explicit/rk4.cpp.
template <class Real>
class Rk4Steps final : public StepsOnDevice<Real> {
 public:
  int forces_in_step() const override { return 4; }
  void take(DeviceSystem<Real>& system, double t, double dt, long steps) override {
    for (auto* vectors : {&stage_x_, &stage_v_, &a_, &dx_, &dv_})
      if (vectors->bytes() == 0) *vectors = system.make_vectors();
    for (long n = 0; n < steps; ++n, t += dt) {
      system.step_begins();
      step(system, t, dt);
      system.collide(dt);
    }
  }

 private:
  void step(DeviceSystem<Real>& system, double t, double dt) {
    stage_x_.copy(system.x());
    stage_v_.copy(system.v());
    system.acceleration(t, stage_x_, stage_v_, a_);
    system.kicked_for(dt / 6);
    dx_.copy(stage_v_);
    dv_.copy(a_);
    for (const double part : {0.5, 0.5, 1.0}) {
      system.combine(system.x(), part * dt, stage_v_, stage_x_);
      system.combine(system.v(), part * dt, a_, stage_v_);
      system.constrain(t + part * dt, stage_x_, stage_v_);
      system.acceleration(t + part * dt, stage_x_, stage_v_, a_);
      const double weight = part == 0.5 ? 2 : 1;
      system.kicked_for(weight * dt / 6);
      system.combine(dx_, weight, stage_v_, dx_);
      system.combine(dv_, weight, a_, dv_);
    }
    system.combine(system.x(), dt / 6, dx_, system.x());
    system.combine(system.v(), dt / 6, dv_, system.v());
    system.constrain(t + dt, system.x(), system.v());
  }

  typename DeviceSystem<Real>::Vectors stage_x_, stage_v_, a_, dx_, dv_;
};

}  // namespace mss

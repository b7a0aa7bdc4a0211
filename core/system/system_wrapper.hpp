#pragma once

#include "core/system/system.hpp"

namespace mss {

/// Another system with forces added. The derived class defines force() and acceleration(); kick_drift() goes
/// through them, step by step, and everything else is the other system's.
template <class Real>
class SystemWrapper : public System<Real> {
 public:
  /// The other system must outlive this one.
  explicit SystemWrapper(System<Real>& other) : other_(other) {}

  std::ptrdiff_t size() const final { return other_.size(); }
  const std::vector<std::ptrdiff_t>& particles() const final { return other_.particles(); }
  double mass(std::ptrdiff_t site) const final { return other_.mass(site); }
  void force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f) override = 0;
  void acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) override = 0;
  void constrain(double t, Field<Real>& x, Field<Real>& v) const final { other_.constrain(t, x, v); }
  void clear_prescribed(Field<Real>& field) const override { other_.clear_prescribed(field); }
  Tangents<Real>* tangents() override { return other_.tangents(); }
  const BodySystem<Real>* cells() const final { return other_.cells(); }
  const SolidSystem<Real>* solid() const final { return other_.solid(); }
  const SpringSystem<Real>* springs() const final { return other_.springs(); }
  DiscreteGradient<Real>* discrete_gradient() override { return other_.discrete_gradient(); }
  StepEvents<Real>* events() override { return other_.events(); }
  ReducedMotion* reduced() final { return other_.reduced(); }
  StepMemory<Real>* memory() final { return other_.memory(); }
  const PlaneBounds* bounds() const final { return other_.bounds(); }
  PlaneImpulses* plane_impulses() const final { return other_.plane_impulses(); }
  const Communicator& ranks() const final { return other_.ranks(); }
  void parallel(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task) final {
    other_.parallel(count, task);
  }
  double threads_working() const override { return other_.threads_working(); }
  void apply(const KickDrift& update, const Field<Real>& a, double dt, State<Real>& state) const final {
    other_.apply(update, a, dt, state);
  }

 protected:
  System<Real>& other() { return other_; }
  const System<Real>& other() const { return other_; }

 private:
  System<Real>& other_;
};

}  // namespace mss

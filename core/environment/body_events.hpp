#pragma once

#include <memory>

#include "core/environment/plane_contact.hpp"
#include "core/environment/sleep_tracker.hpp"
#include "core/environment/surface_contact.hpp"
#include "core/system/plane_impulses.hpp"
#include "core/system/step_events.hpp"
#include "core/system/system.hpp"

namespace mss {

/// Planes, and what they act on and write down.
struct Colliding {
  const PlaneContact& contact;
  const HeldSites& held;
  PlaneImpulses* impulses;  ///< nullptr: no plane acts by impulses
};

/// Applies planes to a particle of a mass [kg] that touches one at the end of a step of dt that led from
/// `before` to `state`; held coordinates stay. False if nothing changed.
template <class Real>
bool collide_touching(const Colliding& colliding, std::ptrdiff_t site, double mass, const State<Real>& before,
                      double dt, State<Real>& state);
/// The same for any particle.
template <class Real>
bool collide_particle(const Colliding& colliding, std::ptrdiff_t site, double mass, const State<Real>& before,
                      double dt, State<Real>& state) {
  const auto began = [&] { return before.x.at(site); };
  return colliding.contact.touches(began, state.x.at(site), state.t, dt) &&
         collide_touching(colliding, site, mass, before, dt, state);
}

/// Takes the acceleration of a particle that is at rest where it sticks to a plane, or an obstacle at rest.
/// `at`: its index in the impulses.
template <class Real>
void stop_resting(const Colliding& colliding, std::ptrdiff_t at, double mass, double t, const Vec3& x,
                  std::ptrdiff_t site, Field<Real>& a);
/// The same for any particle.
template <class Real>
void stop_sticking(const Colliding& colliding, std::ptrdiff_t at, double mass, double t, std::ptrdiff_t site,
                   const Field<Real>& x, const Field<Real>& v, Field<Real>& a) {
  if (v.axis(0)[site] == 0 && v.axis(1)[site] == 0 && v.axis(2)[site] == 0)
    stop_resting(colliding, at, mass, t, x.at(site), site, a);
  else if (colliding.impulses)
    colliding.impulses->let_go(at);
}

/// What happens to a body between steps: it collides with planes, and parts of it fall asleep.
template <class Real>
class BodyEvents final : public StepEvents<Real> {
 public:
  /// All must outlive it; the system's threads do the work. `surface`: what planes touch, nullptr: particles.
  /// Nothing sleeps where the rule's bound is 0.
  BodyEvents(System<Real>& system, const Body& body, const Colliding& colliding,
             const SurfaceContact* surface, const SleepRule& sleep);

  bool collides() const override { return colliding_.contact.has_collisions(); }
  double fall_step() const override { return colliding_.contact.fall_step(); }
  bool presses() const override { return colliding_.contact.has_penalties(); }
  double resolved_step() const override { return colliding_.contact.resolved_step(); }
  bool collide(const State<Real>& before, double dt, State<Real>& state) override;
  bool sleeps() const override { return sleep_ != nullptr; }
  bool settle(State<Real>& state) override;
  bool all_asleep() const override { return sleep_ && sleep_->all_asleep(); }
  /// Of every penalty plane, the smallest gap of a particle, or of a vertex of the surface.
  std::vector<double> event_functions(double t, const Field<Real>& x) const override {
    if (surface_) return surface_->smallest_gaps(x, t);
    return colliding_.contact.smallest_gaps(body_.sites(), x, t);
  }

  /// Must be called after a change of velocities, and of positions or of what acts on the body.
  void wake_moving(const State<Real>& state);
  void wake_all();
  /// See core/base/record.hpp.
  void remember(Record& record);

  /// Which parts of the body sleep; nullptr where nothing does.
  const SleepTracker<Real>* sleep_tracker() const { return sleep_.get(); }

  /// Calls task(site) for every particle that is awake, on all threads.
  template <class Task>
  void for_each_awake(Task&& task) {
    const std::ptrdiff_t plane = body_.lattice().plane;
    for_each_particle(system_, [&](std::ptrdiff_t site) {
      if (!sleep_ || !sleep_->asleep(int(site / plane))) task(site);
    });
  }

 private:
  void let_go_awake();
  void hold_asleep(const State<Real>& state);

  System<Real>& system_;
  const Body& body_;
  Colliding colliding_;
  const SurfaceContact* surface_;
  std::unique_ptr<SleepTracker<Real>> sleep_;
};

}  // namespace mss

#pragma once

#include <memory>

#include "core/plane_contact.hpp"
#include "core/sleep_tracker.hpp"
#include "core/step_events.hpp"
#include "core/surface_contact.hpp"
#include "core/system.hpp"

namespace mss {

/// Applies planes to a particle at the end of a step of dt that led from `before` to `state`; held
/// coordinates stay. False if nothing changed.
template <class Real>
bool collide_particle(const PlaneContact& contact, const HeldSites& held, std::ptrdiff_t site,
                      const State<Real>& before, double dt, State<Real>& state);

/// What happens to a body between steps: it collides with planes, and parts of it fall asleep.
template <class Real>
class BodyEvents final : public StepEvents<Real> {
 public:
  /// All must outlive it; the system's threads do the work. `surface`: what planes touch, nullptr: particles.
  /// Nothing sleeps where the rule's bound is 0.
  BodyEvents(System<Real>& system, const Body& body, const HeldSites& held, const PlaneContact& contact,
             const SurfaceContact* surface, const SleepRule& sleep);

  bool collides() const override { return contact_.has_collisions(); }
  bool collide(const State<Real>& before, double dt, State<Real>& state) override;
  bool sleeps() const override { return sleep_ != nullptr; }
  bool settle(State<Real>& state) override;
  bool all_asleep() const override { return sleep_ && sleep_->all_asleep(); }
  /// Of every penalty plane, the smallest gap of a particle, or of a vertex of the surface.
  std::vector<double> event_functions(const Field<Real>& x) const override {
    if (surface_) return surface_->smallest_gaps(x);
    return contact_.smallest_gaps(body_.sites(), x);
  }

  /// Which parts of the body sleep; nullptr where nothing does.
  SleepTracker<Real>* sleep_tracker() { return sleep_.get(); }
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
  System<Real>& system_;
  const Body& body_;
  const HeldSites& held_;
  const PlaneContact& contact_;
  const SurfaceContact* surface_;
  std::unique_ptr<SleepTracker<Real>> sleep_;
};

}  // namespace mss

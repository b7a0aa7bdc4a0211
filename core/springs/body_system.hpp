#pragma once

#include "core/base/thread_team.hpp"
#include "core/body/body.hpp"
#include "core/environment/body_events.hpp"
#include "core/environment/environment.hpp"
#include "core/environment/plane_bounds.hpp"
#include "core/environment/plane_contact.hpp"
#include "core/environment/sleep_tracker.hpp"
#include "core/environment/surface_contact.hpp"
#include "core/springs/solid_system.hpp"
#include "core/system/plane_impulses.hpp"

namespace mss {

/// A body in its environment, whatever fills its cells: springs (SpringSystem), finite elements (FemSystem).
/// The derived class adds up forces and, if implicit methods are to work, contains a BodyTangents.
template <class Real>
class BodySystem : public SolidSystem<Real> {
 public:
  /// The body must outlive the system. `bound`: upper bounds on the frequency and damping of every mode about
  /// the rest state, of the body alone. `threads` compute forces. A `sleep` rule is for systems whose
  /// accelerations of planes asleep are zero, and for contact of particles.
  BodySystem(const Body& body, const Environment& environment, const SpectralBound& bound, int threads,
             const SleepRule& sleep = {});

  const Body& body() const { return body_; }
  const std::vector<Level>& levels() const override { return levels_; }
  const Environment& environment() const { return environment_; }
  Vec3 gravity() const override { return environment_.gravity; }
  const HeldSites& held() const { return held_; }
  const LoadedSites& loads() const { return loads_; }
  const PlaneContact& contact() const { return contact_; }
  /// What planes touch; nullptr: particles.
  const SurfaceContact* surface_contact() const { return surface_contact_.get(); }
  const PlaneBounds* bounds() const override { return bounds_of_planes_.get(); }
  PlaneImpulses* plane_impulses() const override { return impulses_.get(); }

  /// Bounds on the spectrum of the body alone, and of the body where it may touch planes.
  const SpectralBound& body_bound() const { return bound_; }
  SpectralBound spectral_bound() const override { return contact_.with_penalties(bound_); }

  double outer_potential(double t, const Field<Real>& x) const override;
  void add_penalty_forces(const State<Real>& state, std::vector<Wrench>& forces) const override;
  int threads() const override { return team_.size(); }

  std::ptrdiff_t size() const override { return body_.lattice().size; }
  const std::vector<std::ptrdiff_t>& particles() const override { return body_.sites(); }
  double mass(std::ptrdiff_t site) const override { return body_.mass(site); }
  void constrain(double t, Field<Real>& x, Field<Real>& v) const override;
  void clear_prescribed(Field<Real>& field) const override { held_.clear(field); }
  void acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) override;
  const BodySystem<Real>* cells() const override { return this; }
  BodyEvents<Real>* events() override { return &events_; }
  void parallel(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task) override {
    team_.for_each(count, task);
  }
  double threads_working() const override { return team_.threads_working(); }

  bool all_asleep() const override { return events_.all_asleep(); }
  double share_asleep() const override { return sleep_tracker() ? sleep_tracker()->share_asleep() : 0; }
  void wake_moving(const State<Real>& state) override;
  void wake_all() override;
  void remember(Record& record) override { events_.remember(record); }

 protected:
  /// nullptr where nothing sleeps.
  const SleepTracker<Real>* sleep_tracker() const { return events_.sleep_tracker(); }
  ThreadTeam& team() { return team_; }
  void add_gravity(Field<Real>& f) const;

  /// Both add nothing and cost nothing without penalty planes.
  void add_penalty_force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f);
  void add_penalty_acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a);
  /// Zeroes accelerations of what sticks to planes of the law `impulse`. Otherwise, in methods that evaluate
  /// forces within a step, the body would sink for half of it, and its neighbours would never come to rest.
  /// Where planes touch a surface it does nothing: no particle sticks.
  void stop_sticking(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a);

 private:
  const Body& body_;
  std::vector<Level> levels_;
  Environment environment_;
  SpectralBound bound_;
  HeldSites held_;
  LoadedSites loads_;
  PlaneContact contact_;
  std::unique_ptr<SurfaceContact> surface_contact_;
  std::unique_ptr<PlaneBounds> bounds_of_planes_;
  std::unique_ptr<PlaneImpulses> impulses_;  ///< nullptr: no plane acts by impulses
  ThreadTeam team_;
  BodyEvents<Real> events_;
};

}  // namespace mss

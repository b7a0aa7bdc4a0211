#include "core/body_events.hpp"

#include <atomic>

namespace mss {

template <class Real>
BodyEvents<Real>::BodyEvents(System<Real>& system, const Body& body, const HeldSites& held,
                             const PlaneContact& contact, const SurfaceContact* surface,
                             const SleepRule& sleep)
    : system_(system), body_(body), held_(held), contact_(contact), surface_(surface) {
  if (sleep.bound > 0) sleep_ = std::make_unique<SleepTracker<Real>>(body.lattice(), sleep);
}

template <class Real>
bool BodyEvents<Real>::collide(const State<Real>& before, double dt, State<Real>& state) {
  if (surface_) return surface_->collide(before, dt, state);
  std::atomic<bool> any{false};
  for_each_awake([&](std::ptrdiff_t site) {
    if (collide_particle(contact_, held_, site, before, dt, state))
      any.store(true, std::memory_order_relaxed);
  });
  return !system_.ranks().all(!any);
}

template <class Real>
bool collide_particle(const PlaneContact& contact, const HeldSites& held, std::ptrdiff_t site,
                      const State<Real>& before, double dt, State<Real>& state) {
  const Vec3 x = state.x.at(site);
  if (!contact.touches(x)) return false;
  Motion after{x, state.v.at(site)};
  if (!contact.collide({before.x.at(site), before.v.at(site)}, dt, after)) return false;
  for (int axis = 0; axis < 3; ++axis) {
    if (held.holds(site, axis)) continue;
    state.x.axis(axis)[site] = static_cast<Real>(after.x[axis]);
    state.v.axis(axis)[site] = static_cast<Real>(after.v[axis]);
  }
  return true;
}

template <class Real>
bool BodyEvents<Real>::settle(State<Real>& state) {
  const std::ptrdiff_t plane = body_.lattice().plane;
  return sleep_ &&
         sleep_->update(state, [&](int k) { return held_.move(state.t, plane * k, plane * (k + 1)); });
}

template bool collide_particle(const PlaneContact&, const HeldSites&, std::ptrdiff_t, const State<float>&,
                               double, State<float>&);
template bool collide_particle(const PlaneContact&, const HeldSites&, std::ptrdiff_t, const State<double>&,
                               double, State<double>&);
template class BodyEvents<float>;
template class BodyEvents<double>;

}  // namespace mss

#include "core/environment/body_events.hpp"

#include <atomic>

#include "core/base/record.hpp"

namespace mss {

namespace {

/// What of a force or an impulse does not act along held axes.
Vec3 free_part(const HeldSites& held, std::ptrdiff_t site, const Vec3& vector) {
  return held.empty() ? vector : Vec3(held.free_axes(site).cwiseProduct(vector));
}

}  // namespace

template <class Real>
BodyEvents<Real>::BodyEvents(System<Real>& system, const Body& body, const Colliding& colliding,
                             const SurfaceContact* surface, const SleepRule& sleep)
    : system_(system), body_(body), colliding_(colliding), surface_(surface) {
  if (sleep.bound > 0) sleep_ = std::make_unique<SleepTracker<Real>>(body.lattice(), sleep);
}

template <class Real>
bool BodyEvents<Real>::collide(const State<Real>& before, double dt, State<Real>& state) {
  if (colliding_.impulses) colliding_.impulses->end_step(dt);
  if (surface_) return surface_->collide(before, dt, state, colliding_.impulses);
  std::atomic<bool> any{false};
  for_each_awake([&](std::ptrdiff_t site) {
    if (collide_particle(colliding_, site, body_.mass(site), before, dt, state))
      any.store(true, std::memory_order_relaxed);
  });
  return !system_.ranks().all(!any);
}

template <class Real>
bool collide_touching(const Colliding& colliding, std::ptrdiff_t site, double mass, const State<Real>& before,
                      double dt, State<Real>& state) {
  Motion after{state.x.at(site), state.v.at(site)};
  const auto give = [&](std::size_t plane, const Vec3& dv) {
    if (colliding.impulses) colliding.impulses->add(plane, site, mass * free_part(colliding.held, site, dv));
  };
  if (!colliding.contact.collide({before.x.at(site), before.v.at(site)}, state.t, dt, after, give))
    return false;
  if (const Vec3 free = free_part(colliding.held, site, Vec3::Ones()); !free.isOnes(0)) {
    const Vec3 goal = after.x;
    for (int axis = 0; axis < 3; ++axis)
      if (free[axis] == 0) {
        after.x[axis] = double(state.x.axis(axis)[site]);
        after.v[axis] = double(state.v.axis(axis)[site]);
      }
    colliding.contact.collide_held(free, state.t, goal, after, give);
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (colliding.held.holds(site, axis)) continue;
    state.x.axis(axis)[site] = static_cast<Real>(after.x[axis]);
    state.v.axis(axis)[site] = static_cast<Real>(after.v[axis]);
  }
  return true;
}

template <class Real>
void stop_resting(const Colliding& colliding, std::ptrdiff_t at, double mass, double t, const Vec3& x,
                  std::ptrdiff_t site, Field<Real>& a) {
  const Vec3 acceleration = a.at(site);
  const std::optional<std::size_t> plane = colliding.contact.sticks_to(x, t, acceleration);
  if (plane) a.set(site, Vec3::Zero());
  if (!colliding.impulses) return;
  if (plane)
    colliding.impulses->hold(*plane, at, -mass * free_part(colliding.held, at, acceleration));
  else
    colliding.impulses->let_go(at);
}

template <class Real>
bool BodyEvents<Real>::settle(State<Real>& state) {
  const std::ptrdiff_t plane = body_.lattice().plane;
  const bool all = colliding_.contact.moves(state.t);  // an obstacle that moves, or will, keeps all awake
  const auto is_driven = [&](int k) {
    return all || colliding_.held.move(state.t, plane * k, plane * (k + 1));
  };
  if (!sleep_ || !sleep_->update(state, is_driven)) return false;
  if (!colliding_.impulses) return true;
  let_go_awake();
  hold_asleep(state);
  return true;
}

template <class Real>
void BodyEvents<Real>::wake_moving(const State<Real>& state) {
  if (!sleep_) return;
  sleep_->wake_moving(state);
  let_go_awake();
}

template <class Real>
void BodyEvents<Real>::wake_all() {
  if (!sleep_) return;
  sleep_->wake_all();
  let_go_awake();
}

template <class Real>
void BodyEvents<Real>::remember(Record& record) {
  if (sleep_) record.keep(*sleep_);
  if (colliding_.impulses) record.keep(*colliding_.impulses);
}

/// Methods must evaluate accelerations anew then.
template <class Real>
void BodyEvents<Real>::let_go_awake() {
  if (colliding_.impulses) for_each_awake([&](std::ptrdiff_t site) { colliding_.impulses->let_go(site); });
}

/// Planes carry what sleeps on them against the forces with which it fell asleep.
template <class Real>
void BodyEvents<Real>::hold_asleep(const State<Real>& state) {
  const std::ptrdiff_t plane = body_.lattice().plane;
  Field<Real> forces(body_.lattice().size);
  system_.force(state.t, state.x, state.v, forces);
  for (const std::ptrdiff_t site : body_.sites()) {
    if (!sleep_->asleep(int(site / plane))) continue;
    const Vec3 force = free_part(colliding_.held, site, forces.at(site));
    if (const auto p = colliding_.contact.carries(state.x.at(site), state.t, force))
      colliding_.impulses->hold(*p, site, -force);
  }
}

template bool collide_touching(const Colliding&, std::ptrdiff_t, double, const State<float>&, double,
                               State<float>&);
template bool collide_touching(const Colliding&, std::ptrdiff_t, double, const State<double>&, double,
                               State<double>&);
template void stop_resting(const Colliding&, std::ptrdiff_t, double, double, const Vec3&, std::ptrdiff_t,
                           Field<float>&);
template void stop_resting(const Colliding&, std::ptrdiff_t, double, double, const Vec3&, std::ptrdiff_t,
                           Field<double>&);
template class BodyEvents<float>;
template class BodyEvents<double>;

}  // namespace mss

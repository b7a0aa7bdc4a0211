#include "core/springs/body_system.hpp"

namespace mss {

namespace {

std::unique_ptr<SurfaceContact> surface_contact_of(const Environment& environment, const Body& body,
                                                   const HeldSites& held, const PlaneContact& planes) {
  if (!environment.contact_surface || (environment.planes.empty() && environment.obstacles.empty()))
    return nullptr;
  return std::make_unique<SurfaceContact>(*environment.contact_surface, body, held, planes);
}

}  // namespace

template <class Real>
BodySystem<Real>::BodySystem(const Body& body, const Environment& environment, const SpectralBound& bound,
                             int threads, const SleepRule& sleep)
    : body_(body),
      levels_{{body}},
      environment_(environment),
      bound_(bound),
      held_(body, environment.holds),
      loads_(body, environment.loads),
      contact_(environment, bound, body.config().cell_size),
      surface_contact_(surface_contact_of(environment, body, held_, contact_)),
      bounds_of_planes_(plane_bounds(environment, bound.omega, body.config().cell_size, held_)),
      impulses_(contact_.has_collisions()
                    ? std::make_unique<PlaneImpulses>(contact_.collisions(), body.lattice().size)
                    : nullptr),
      team_(threads),
      events_(*this, body, {contact_, held_, impulses_.get()}, surface_contact_.get(), sleep) {}

template <class Real>
void BodySystem<Real>::constrain(double t, Field<Real>& x, Field<Real>& v) const {
  held_.apply(t, 0, body_.lattice().sites, x, v);
}

template <class Real>
void BodySystem<Real>::add_gravity(Field<Real>& f) const {
  for (int a = 0; a < 3; ++a) {
    if (environment_.gravity[a] == 0) continue;
    for (const std::ptrdiff_t site : body_.sites())
      f.axis(a)[site] += static_cast<Real>(body_.mass(site) * environment_.gravity[a]);
  }
}

template <class Real>
void BodySystem<Real>::acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) {
  System<Real>::acceleration(t, x, v, a);
  stop_sticking(t, x, v, a);
  clear_prescribed(a);
}

template <class Real>
double BodySystem<Real>::outer_potential(double t, const Field<Real>& x) const {
  double sum = 0;
  body_.ranks().add_in_order(sum, [&] { loads_.add_potential(t, x, sum); });
  body_.ranks().add_in_order(sum, [&] {
    for (const std::ptrdiff_t site : body_.sites()) {
      const Vec3 at = x.at(site);
      double over_mass = -environment_.gravity.dot(at);
      if (!surface_contact_) contact_.add_potential(at, t, over_mass);
      sum += body_.mass(site) * over_mass;
    }
  });
  if (surface_contact_) sum += surface_contact_->potential(t, x);
  return sum;
}

template <class Real>
void BodySystem<Real>::add_penalty_forces(const State<Real>& state, std::vector<Wrench>& forces) const {
  if (!contact_.has_penalties()) return;
  if (surface_contact_)
    return surface_contact_->for_each_penalty_force(
        state,
        [&](std::size_t p, const Vec3& at, const Vec3& force) { mss::add_force(at, force, forces[p]); });
  for (std::size_t p = 0; p < contact_.penalties(); ++p)
    body_.ranks().add_in_order(forces[p], [&] {
      for (const std::ptrdiff_t site : body_.sites())
        mss::add_force(
            state.x.at(site),
            body_.mass(site) * contact_.acceleration(p, {state.x.at(site), state.v.at(site)}, state.t),
            forces[p]);
    });
}

template <class Real>
void BodySystem<Real>::wake_moving(const State<Real>& state) {
  events_.wake_moving(state);
}

template <class Real>
void BodySystem<Real>::wake_all() {
  events_.wake_all();
}

template <class Real>
void BodySystem<Real>::add_penalty_force(double t, const Field<Real>& x, const Field<Real>& v,
                                         Field<Real>& f) {
  if (!contact_.has_penalties()) return;
  if (surface_contact_) return surface_contact_->add_force(t, x, v, f);
  for_each_particle(*this, [&](std::ptrdiff_t site) {
    f.set(site, f.at(site) + body_.mass(site) * contact_.acceleration({x.at(site), v.at(site)}, t));
  });
}

template <class Real>
void BodySystem<Real>::add_penalty_acceleration(double t, const Field<Real>& x, const Field<Real>& v,
                                                Field<Real>& a) {
  if (!contact_.has_penalties()) return;
  if (surface_contact_) return surface_contact_->add_acceleration(t, x, v, a);
  events_.for_each_awake([&](std::ptrdiff_t site) {
    a.set(site, a.at(site) + contact_.acceleration({x.at(site), v.at(site)}, t));
  });
}

template <class Real>
void BodySystem<Real>::stop_sticking(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) {
  if (!contact_.has_collisions() || surface_contact_) return;
  events_.for_each_awake([&](std::ptrdiff_t site) {
    mss::stop_sticking({contact_, held_, impulses_.get()}, site, body_.mass(site), t, site, x, v, a);
  });
}

template class BodySystem<float>;
template class BodySystem<double>;

}  // namespace mss

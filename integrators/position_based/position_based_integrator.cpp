#include "integrators/position_based/position_based_integrator.hpp"

namespace mss {

template <class Real>
const SpringSystem<Real>& springs_for(System<Real>& system, const std::string& method) {
  const SpringSystem<Real>* springs = system.springs();
  if (!springs)
    throw InputError(fmt::format(
        "{} steps bodies of springs in a way of its own, which this model has not; choose the model "
        "\"springs\", or another method",
        method));
  return *springs;
}

void check_regions(const BodyConfig& body, const std::string& method) {
  if (!body.is_solid())
    throw InputError(fmt::format(
        "{} matches regions of cells of three dimensions, and this body is {}; choose another method", method,
        body.noun()));
}

void check_local_solutions(const BodyConfig& body, const std::string& method) {
  if (body.has_negative_volume_stiffness())
    throw InputError(fmt::format(
        "{} needs an energy that has a lower bound, and none has where the volume stiffness is negative, as "
        "Poisson's ratio below 1/4 makes it; choose another method",
        method));
  if (body.fold_guard > 0)
    throw InputError(fmt::format(
        "{} has no local solution for fold_guard; set it to 0, or choose another method", method));
}

template <class Real>
OuterAcceleration<Real>::OuterAcceleration(const SpringSystem<Real>& springs, System<Real>& system)
    : springs_(springs),
      system_(system),
      is_wrapped_(static_cast<const System<Real>*>(&springs) != &system),
      loads_vary_(std::any_of(springs.environment().loads.begin(), springs.environment().loads.end(),
                              [](const Load& load) { return !load.history.empty(); })),
      sum_(springs.size()) {}

template <class Real>
const Field<Real>& OuterAcceleration<Real>::at(const State<Real>& state) {
  sum_.array() = 0;
  springs_.loads().add(state.t, 0, springs_.body().lattice().sites,
                       std::array<Real*, 3>{sum_.axis(0), sum_.axis(1), sum_.axis(2)});
  const PlaneContact& contact = springs_.contact();
  const SurfaceContact* surface = springs_.surface_contact();
  for_each_particle(system_, [&](std::ptrdiff_t site) {
    Vec3 a = sum_.at(site) / springs_.mass(site) + springs_.environment().gravity;
    if (contact.has_penalties() && !surface)
      a += contact.acceleration({state.x.at(site), state.v.at(site)}, state.t);
    sum_.set(site, a);
  });
  if (surface) surface->add_acceleration(state.t, state.x, state.v, sum_);
  if (is_wrapped_) add_wrapper(state);
  return sum_;
}

template <class Real>
void OuterAcceleration<Real>::add_wrapper(const State<Real>& state) {
  if (!own_) {
    own_ = std::make_unique<SpringSystem<Real>>(springs_.body(), springs_.environment(), Execution{1});
    alone_ = whole_ = Field<Real>(springs_.size());
  }
  own_->force(state.t, state.x, state.v, alone_);
  system_.force(state.t, state.x, state.v, whole_);
  for (const std::ptrdiff_t site : springs_.particles())
    sum_.set(site, sum_.at(site) + (whole_.at(site) - alone_.at(site)) / springs_.mass(site));
}

template const SpringSystem<float>& springs_for(System<float>&, const std::string&);
template const SpringSystem<double>& springs_for(System<double>&, const std::string&);
template class OuterAcceleration<float>;
template class OuterAcceleration<double>;

}  // namespace mss

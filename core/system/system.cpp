#include "core/system/system.hpp"

#include "core/base/error.hpp"
#include "core/system/plane_impulses.hpp"

namespace mss {

template <class Real>
void System<Real>::acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a) {
  force(t, x, v, a);
  for (const std::ptrdiff_t site : particles())
    for (int axis = 0; axis < 3; ++axis) a.axis(axis)[site] /= static_cast<Real>(mass(site));
}

template <class Real>
void System<Real>::constrain(double, Field<Real>&, Field<Real>&) const {}

template <class Real>
void System<Real>::clear_prescribed(Field<Real>&) const {}

template <class Real>
void System<Real>::parallel(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task) {
  for (std::ptrdiff_t i = 0; i < count; ++i) task(i);
}

template <class Real>
void System<Real>::apply(const KickDrift& u, const Field<Real>& a, double dt, State<Real>& state) const {
  const auto before = static_cast<Real>(u.kick_before), after = static_cast<Real>(u.kick_after);
  const auto drift_old = static_cast<Real>(u.drift_old), drift_new = static_cast<Real>(u.drift_new);
  for (int axis = 0; axis < 3; ++axis) {
    Real* x = state.x.axis(axis);
    Real* v = state.v.axis(axis);
    for (const std::ptrdiff_t i : particles()) {
      const Real v_new = (v[i] + before * a.axis(axis)[i]) + after * a.axis(axis)[i];
      x[i] += drift_old * v[i] + drift_new * v_new;
      v[i] = v_new;
    }
  }
  kicked_for(*this, u.kick_before + u.kick_after);
  state.t += dt;
  constrain(state.t, state.x, state.v);
}

template <class Real>
void kicked_for(const System<Real>& system, double seconds) {
  if (PlaneImpulses* impulses = system.plane_impulses()) impulses->hold_for(seconds);
}

template <class Real>
void System<Real>::kick_drift(const KickDrift& update, double dt, long steps, State<Real>& state) {
  if (scratch_.size() != state.x.size()) scratch_ = Field<Real>(size());
  for (long step = 0; step < steps; ++step) {
    acceleration(state.t, state.x, state.v, scratch_);
    apply(update, scratch_, dt, state);
  }
}

template <class Real>
Tangents<Real>& tangents_of(System<Real>& system) {
  if (Tangents<Real>* tangents = system.tangents()) return *tangents;
  throw InputError(
      "this model has no tangents (derivatives of its forces), which implicit methods, equilibria and modes "
      "need; choose an explicit method");
}

template <class Real>
std::vector<FreeDof> unknowns_of(const System<Real>& system) {
  Field<Real> is_free(system.size());
  is_free.array() = Real(1);
  system.clear_prescribed(is_free);
  std::vector<FreeDof> unknowns;
  for (const std::ptrdiff_t site : system.particles())
    for (int axis = 0; axis < 3; ++axis)
      if (is_free.axis(axis)[site] != Real(0)) unknowns.push_back({site, axis});
  return unknowns;
}

template class System<float>;
template class System<double>;
template void kicked_for(const System<float>&, double);
template void kicked_for(const System<double>&, double);
template Tangents<float>& tangents_of(System<float>&);
template Tangents<double>& tangents_of(System<double>&);
template std::vector<FreeDof> unknowns_of(const System<float>&);
template std::vector<FreeDof> unknowns_of(const System<double>&);

}  // namespace mss

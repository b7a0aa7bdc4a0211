#include "integrators/sundials/first_order.hpp"

#include <sundials/sundials_version.h>

#include <cmath>

#include "integrators/sundials/shared_vector.hpp"
#include "integrators/sundials/version.hpp"

namespace mss::sundials {

bool advance_if_all_prescribed(System<double>& system, State<double>& state, double t_end) {
  if (!system.ranks().all(unknowns_of(system).empty())) return false;
  state.t = t_end;
  system.constrain(t_end, state.x, state.v);
  return true;
}

FirstOrder::FirstOrder(System<double>& system, SUNContext context)
    : system_(system),
      unknowns_(unknowns_of(system)),
      size_(Eigen::Index(unknowns_.size())),
      y_(shared_vector(2 * size_, system.ranks(), context)),
      x_(system.size()),
      v_(system.size()),
      a_(system.size()) {}

void FirstOrder::load_state(const State<double>& state) {
  double *x = N_VGetArrayPointer(y()), *v = x + size_;
  for (const auto [site, axis] : unknowns_) {
    *x++ = state.x.axis(axis)[site];
    *v++ = state.v.axis(axis)[site];
  }
}

void FirstOrder::store_state(State<double>& state) const {
  const double *x = N_VGetArrayPointer(y_.get()), *v = x + size_;
  for (const auto [site, axis] : unknowns_) {
    state.x.axis(axis)[site] = *x++;
    state.v.axis(axis)[site] = *v++;
  }
  system_.constrain(state.t, state.x, state.v);
}

void FirstOrder::fields(double t, N_Vector y) {
  const double *x = N_VGetArrayPointer(y), *v = x + size_;
  for (const auto [site, axis] : unknowns_) {
    x_.axis(axis)[site] = *x++;
    v_.axis(axis)[site] = *v++;
  }
  system_.constrain(t, x_, v_);
}

bool FirstOrder::rate(double t, N_Vector y, N_Vector ydot) {
  fields(t, y);
  system_.acceleration(t, x_, v_, a_);
  ++work->force_evaluations;
  double *xdot = N_VGetArrayPointer(ydot), *vdot = xdot + size_;
  double sum = 0;
  for (const auto [site, axis] : unknowns_) {
    *xdot++ = v_.axis(axis)[site];
    sum += * vdot++ = a_.axis(axis)[site];
  }
  return system_.ranks().all(std::isfinite(sum));
}

Vector FirstOrder::tolerances(const IntegratorOptions& options) const {
  Vector tolerances(N_VClone(y_.get()));
  double* out = N_VGetArrayPointer(tolerances.get());
  std::fill_n(out, size_, options.tolerance * options.length_scale);
  std::fill_n(out + size_, size_, options.tolerance * options.speed_scale);
  return tolerances;
}

std::string version() {
  char text[32];
  return SUNDIALSGetVersion(text, sizeof text) == 0 ? text : "unknown";
}

}  // namespace mss::sundials

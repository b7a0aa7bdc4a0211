#include "integrators/collisions.hpp"

#include <fmt/format.h>

#include "core/base/error.hpp"

namespace mss {

namespace {

/// Whether planes that act after steps of dt come too late for forces that are found where these end.
bool is_late(const IntegratorInfo& method, double dt, double resolved_step) {
  return method.stepping == Stepping::equilibrium || dt > resolved_step;
}

}  // namespace

template <class Real>
void check_collisions(const IntegratorInfo& method, System<Real>& system, double dt) {
  StepEvents<Real>* events = system.events();
  if (!events) return;
  const double longest = events->resolved_step();
  if (method.steps_after_outer_forces() && events->presses() && dt > longest)
    throw InputError(fmt::format(
        "{} takes the forces of planes of contact = \"penalty\" as they are where a step begins: in steps of "
        "{:.3g} s "
        "they would throw the body away; give solve.dt = {:.3g} s or less, {}or another solve.integrator",
        method.name, dt, longest, method.has_modulus ? "contact = \"impulse\" on particles, " : ""));
  if (!events->collides() || method.collisions == Collisions::after_steps) return;
  if (method.collisions == Collisions::never)
    throw InputError(
        fmt::format("planes of the laws \"impulse\" and \"thesis\" act in fixed steps, and {} has none; give "
                    "contact = \"penalty\", or another solve.integrator",
                    method.name));
  if (!method.has_modulus) {
    if (dt <= events->fall_step()) return;
    throw InputError(fmt::format(
        "{} returns regions to their shapes whatever planes do to them: falling for {:.3g} s at a time the "
        "body sags, slides and gains energy on these; give solve.dt = {:.3g} s or less, or another "
        "integrator",
        method.name, dt, events->fall_step()));
  }
  if (!is_late(method, dt, longest)) return;
  if (system.bounds()) return;
  constexpr const char* law = "contact = \"thesis\" and contact_on = \"surface\" act after steps";
  const char* penalty = method.steps_after_outer_forces() ? "" : ", or contact = \"penalty\"";
  if (method.stepping == Stepping::equilibrium)
    throw InputError(fmt::format("{}, and {} takes none; give contact = \"impulse\" on particles{}", law,
                                 method.name, penalty));
  throw InputError(
      fmt::format("{}, and {} finds forces where they end: in steps of {:.3g} s planes would press the body "
                  "before they act; give solve.dt = {:.3g} s or less, contact = \"impulse\" on particles{}",
                  law, method.name, dt, longest, penalty));
}

template void check_collisions<float>(const IntegratorInfo&, System<float>&, double);
template void check_collisions<double>(const IntegratorInfo&, System<double>&, double);

}  // namespace mss

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
  if (!events || !events->collides() || method.collisions == Collisions::after_steps) return;
  if (method.collisions == Collisions::never)
    throw InputError(
        fmt::format("planes of the laws \"impulse\" and \"thesis\" act in fixed steps, and {} has none; give "
                    "contact = \"penalty\", or another solve.integrator",
                    method.name));
  const double longest = events->resolved_step();
  if (!is_late(method, dt, longest)) return;
  if (!method.has_modulus)
    throw InputError(
        fmt::format("{} returns regions to their shapes whatever planes do to them: in steps of {:.3g} s it "
                    "gains energy on these; give solve.dt = {:.3g} s or less, contact = \"penalty\", or "
                    "another integrator",
                    method.name, dt, longest));
  if (system.bounds()) return;
  constexpr const char* law = "contact = \"thesis\" and contact_on = \"surface\" act after steps";
  if (method.stepping == Stepping::equilibrium)
    throw InputError(
        fmt::format("{}, and {} takes none; give contact = \"impulse\" on particles, or contact "
                    "= \"penalty\"",
                    law, method.name));
  throw InputError(
      fmt::format("{}, and {} finds forces where they end: in steps of {:.3g} s planes would press the body "
                  "before they act; give solve.dt = {:.3g} s or less, contact = \"impulse\" on particles, or "
                  "contact = \"penalty\"",
                  law, method.name, dt, longest));
}

template void check_collisions<float>(const IntegratorInfo&, System<float>&, double);
template void check_collisions<double>(const IntegratorInfo&, System<double>&, double);

}  // namespace mss

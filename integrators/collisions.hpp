#pragma once

#include "core/error.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// Whether a method takes planes of the laws `impulse` and `thesis`, which act within its fixed steps or at
/// their ends.
inline bool takes_collisions(const IntegratorInfo& method) { return method.stepping == Stepping::fixed; }

/// Called where a method without fixed steps meets a system. Throws InputError if bodies collide in it: they
/// would fall through planes.
inline void refuse_collisions(System<double>& system) {
  if (!system.events() || !system.events()->collides()) return;
  throw InputError(
      "planes of the laws \"impulse\" and \"thesis\" act in fixed steps, and this method has none; give "
      "contact "
      "= \"penalty\", or another solve.integrator");
}

/// Whether a method finds forces where steps end. Such steps keep contact inside (System::bounds); laws that
/// act after them come too late.
inline bool forces_at_end_of_steps(const IntegratorInfo& method) {
  return method.stepping == Stepping::fixed && !method.limit;
}

}  // namespace mss

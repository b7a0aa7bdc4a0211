#pragma once

#include "integrators/integrator.hpp"

namespace mss {

/// Throws InputError where planes of the laws `impulse` and `thesis` act on a system too late for a method
/// with steps of dt [s], or never. Integrator::advance() calls it.
template <class Real>
void check_collisions(const IntegratorInfo& method, System<Real>& system, double dt);

}  // namespace mss

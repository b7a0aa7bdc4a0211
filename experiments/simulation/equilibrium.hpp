#pragma once

#include <functional>

#include "core/springs/body_system.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// Where a body comes to rest at t = 1 s, when its holds have moved, sought from a guess: a map of its rest
/// positions. The state is valid only if the status is ok.
struct Equilibrium {
  Status status = Status::ok;
  State<double> state;
};
Equilibrium find_equilibrium(BodySystem<double>& system, const std::function<Vec3(const Vec3& rest)>& guess);

}  // namespace mss

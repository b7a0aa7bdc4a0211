#pragma once

#include "core/springs/spring_system.hpp"
#include "experiments/simulation/cubes.hpp"

namespace mss::testing {

inline constexpr double gravity = 9.81;  ///< [m/s^2]
inline constexpr double g = gravity;     ///< where formulas are long

inline Vec3 centre_of_mass(const Body& body, const State<double>& state) {
  Vec3 sum = Vec3::Zero();
  for (const std::ptrdiff_t site : body.sites())
    sum += body.mass(site) / body.total_mass() * state.x.at(site);
  return sum;
}

}  // namespace mss::testing

#pragma once

#include <cstdint>

#include "core/springs/body_system.hpp"

namespace mss {

/// Displacements from an equilibrium of which none is larger than `largest` [m]: random ones, replaced twice
/// by the accelerations they cause. Fast motions predominate in them, among which are those that grow where a
/// step is too long.
Field<double> fast_disturbance(BodySystem<double>& system, const State<double>& equilibrium, double largest,
                               std::uint64_t seed);

}  // namespace mss

#pragma once

#include <cstdint>

#include "core/body_system.hpp"

namespace mss {

/// Displacements of which none is larger than `largest` [m]: forces of forces of random places. Fast motions,
/// among which are those that a step too long makes grow, have most of it.
Field<double> fast_disturbance(BodySystem<double>& system, double largest, std::uint64_t seed);

}  // namespace mss

#pragma once

#include <string>
#include <vector>

#include "experiments/simulation/simulation.hpp"

namespace mss {

/// What the step has to do with a run that ended with numbers that are not finite, and what to do.
std::string diagnosis_of_divergence(const Scene& scene, double dt, const SureSteps& sure);

/// What a run calls attention to, a sentence each: why it may have failed and what to do, and what "ok" does
/// not exclude: a body that ends folded, energy from nowhere, particles behind planes, steps far from solved,
/// a restitution without effect.
std::vector<std::string> diagnostics_of(const Scene& scene, const SimulationResult& result);

}  // namespace mss

#pragma once

#include <string>
#include <vector>

#include "experiments/simulation/simulation.hpp"

namespace mss {

/// What the step has to do with a run that ended with numbers that are not finite, and what to do.
std::string diagnosis_of_divergence(const Scene& scene, double dt, const SureSteps& sure);

/// That a step [s] is far above what a method follows the body's vibrations with, or smells of other units.
std::vector<std::string> warnings_of_step(const Scene& scene, double dt);

/// What a run calls attention to, a sentence each: why it may have failed and what to do, and what "ok" does
/// not exclude: a body that ends folded, energy from nowhere, particles behind planes, steps far from solved
/// or far above a method's accuracy, a restitution without effect.
std::vector<std::string> diagnostics_of(const Scene& scene, const SimulationResult& result);

}  // namespace mss

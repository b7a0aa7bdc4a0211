#pragma once

#include <string>
#include <vector>

#include "experiments/simulation/simulation.hpp"

namespace mss {

/// What the step has to do with a run that ended with numbers that are not finite, and what to do.
std::string remark_on_divergence(const Scene& scene, double dt, const SureSteps& sure);

/// What the end of a run calls attention to, a sentence each: why it may have failed and what to do, and
/// whether the body ends folded, which "ok" does not exclude.
std::vector<std::string> remarks_on(const Scene& scene, const SimulationResult& result);

}  // namespace mss

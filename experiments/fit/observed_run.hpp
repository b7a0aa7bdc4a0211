#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "experiments/fit/observations.hpp"

namespace mss::fit {

/// What a run gives where something was measured.
struct ObservedValues {
  std::vector<std::vector<double>> values{};  ///< of each observation, as many as it has measured ones
  std::string problem{};  ///< why there are none: a status, or a sentence; empty: there are
};

/// Runs a scene for observations of it. `stop` ends it between rows. Throws InputError as simulate() does.
ObservedValues observe(const Scene& scene, const RunSpec& run,
                       const std::vector<const Observation*>& observations, const std::atomic<bool>& stop);

/// The point of a body that is nearest to a place at rest [m], and is observed: of its cells, which carry it;
/// of a body with cells of several sizes, of its particles.
Vec3 nearest_point(const Scene& scene, const Vec3& place);

}  // namespace mss::fit

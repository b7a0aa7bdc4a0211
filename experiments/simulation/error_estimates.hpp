#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/harness/progress.hpp"
#include "experiments/simulation/simulation.hpp"
#include "integrators/analysis/error_estimate.hpp"

namespace mss {

/// A quantity of a scene at rest: as computed, and what is estimated that smaller cells would change.
struct CorrectedValue {
  std::string quantity;  ///< as in "displacement 0 z", "reaction of hold 1 x", "stored energy"
  std::string unit;
  double value = 0;
  double estimate = 0;                 ///< what to add; valid if the status is ok
  std::optional<double> richardson{};  ///< from these cells and cells twice as large, by order 2
  std::vector<EstimateWarning> doubts{};
  Status status = Status::ok;  ///< of the dual solution

  double corrected() const { return value + estimate; }
};

/// Those of a scene: of each displacement in [expect], of each hold's reaction and of the stored energy.
/// Components of a vector that are negligible beside the others are left out.
struct SceneEstimates {
  std::vector<CorrectedValue> values{};
  std::string none{};           ///< why there are no estimates, as a sentence; empty: there are
  std::string no_richardson{};  ///< the same of Richardson's
};

/// For a scene that ended at rest, from its particles there. Solves the scene once more in cells twice as
/// large, if it can be made of them.
SceneEstimates estimate_errors(const Scene& scene, const std::vector<ParticleRecord>& at_rest,
                               Progress& progress);

}  // namespace mss

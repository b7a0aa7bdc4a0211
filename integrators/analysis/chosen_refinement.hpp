#pragma once

#include <optional>

#include "core/environment/environment.hpp"
#include "core/refinement/refined_body.hpp"

namespace mss {

/// What cells are chosen for.
struct RefinementGoal {
  int levels = 1;            ///< how often cells are halved at most
  std::optional<Box> box{};  ///< the mean displacement of its particles [m]; empty: the stored energy
  double time = 0;           ///< at which holds are where they move to [s]
  int threads = 0;           ///< as in Execution
};

/// Which cells of a body to split, for one map that stays: where the estimated error of a quantity comes
/// from, in the linear response at rest to gravity, loads and the motion of holds. So many times this is
/// solved in the cells chosen so far, and those that half of the error comes from are split (marking.hpp).
/// Strikes, velocities and planes have no part in it.
///
/// Throws InputError for a body that holds do not keep in place, one that nothing deforms, or whose goal does
/// not move, and as RefinedBody, RefinedSystem and DisplacementRecovery do.
RefinementMap choose_refinement(const BodyConfig& body, const Environment& environment,
                                const RefinementGoal& goal);

}  // namespace mss

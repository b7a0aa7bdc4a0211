#pragma once

#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/measures.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// What becomes of a body that is left to a method.
enum class Fate {
  holds,
  loses_energy,   ///< that is not damping's to take
  folds,          ///< a corner of a cell is inside out
  blows_up,       ///< has many times the energy it began with, or numbers that are not finite
  stalls,         ///< a solver finds no solution
  too_many_steps  ///< for one interval, of methods that choose their own
};
std::string_view to_string(Fate fate);
/// As legends name them, in the enumeration's order.
std::vector<std::string> fate_names();

/// The fate of what an advance ended with.
Fate fate_of(Status status);

/// What was seen of a run at its looks.
struct Watch {
  double energy_before = 0;                                          ///< [J]
  double most_energy = 0;                                            ///< [J]
  double least_jacobian = std::numeric_limits<double>::quiet_NaN();  ///< at the looks
  double last_jacobian = std::numeric_limits<double>::quiet_NaN();   ///< at the last look
};

/// Follows a run for so many looks: `advance` takes the state to a look, from 1 on, `look` gets what is
/// measured there. Ends early where the run fails or has ten times the energy it began with. Holds, else:
/// whether something folded or was lost is for the caller to judge.
Fate follow(BodySystem<double>& system, State<double>& state, long looks,
            const std::function<Status(long)>& advance, Watch& watch,
            const std::function<void(const Measures&)>& look = {});

}  // namespace mss

#pragma once

#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/measures.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// How the run of a method on a body ends.
enum class Outcome {
  stable,
  loses_energy,    ///< more than the body's damping dissipates
  folds,           ///< a corner of a cell is inverted
  blows_up,        ///< many times the initial energy, or numbers that are not finite
  stalls,          ///< a solver finds no solution
  too_many_steps,  ///< for one interval, of methods that choose their own
  refused          ///< the method has no step for such a body
};

/// As tables write it, for example "blows_up".
std::string_view to_string(Outcome outcome);

/// The outcome that a table writes so. Throws InputError for any other text.
Outcome read_outcome(std::string_view text);

/// As legends show them, in the enumeration's order.
std::vector<std::string> outcome_labels();

/// The outcome of a run whose last advance() returned this status.
Outcome outcome_of(Status status);

/// What was sampled of a run.
struct RunExtremes {
  double initial_energy = 0;                                         ///< mechanical [J]
  double max_energy = 0;                                             ///< mechanical [J]
  double min_jacobian = std::numeric_limits<double>::quiet_NaN();    ///< of all samples
  double final_jacobian = std::numeric_limits<double>::quiet_NaN();  ///< least one of the last sample
};

/// Advances a state through so many samples: `advance` takes it to
/// the sample of that number, 1 the first; `sample` receives the measures there. Ends early with the outcome
/// of an advance that fails, and as blows_up once the energy exceeds ten times the initial one. Stable
/// otherwise: the caller decides whether the body has folded or lost energy.
Outcome run_sampled(BodySystem<double>& system, State<double>& state, long samples,
                    const std::function<Status(long)>& advance, RunExtremes& extremes,
                    const std::function<void(const Measures&)>& sample = {});

}  // namespace mss

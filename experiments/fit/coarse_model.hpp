#pragma once

#include "experiments/fit/least_squares.hpp"

namespace mss::fit {

/// Solves a least-squares problem by a cheap, coarse model of the same targets in the same coordinates. The
/// coarse problem is solved first; from there on the coarse model, corrected so that it has the costly one's
/// values where that was evaluated last, is solved in its place, until the next step is too small to matter,
/// or has changed chi2 by no more than that (space mapping: Bandler et al., IEEE Trans. Microwave Theory
/// Tech. 52, 2004). Targets that are logarithmic are corrected by a factor, others by a difference. A trial
/// that fails, or is worse, halves the longest step.
///
/// The result's evaluations are the costly model's; its jacobian is the corrected coarse model's. Steps whose
/// kind begins with "coarse" are of the first solution.
LeastSquaresResult solve_by_coarse_model(const LeastSquaresProblem& problem,
                                         const LeastSquaresProblem& coarse);

}  // namespace mss::fit

#pragma once

#include "experiments/fit/least_squares.hpp"

namespace mss::fit {

/// Solves a least-squares problem by a cheap, coarse model of the same targets in the same coordinates. The
/// coarse problem is solved first; from there on the coarse model, corrected so that it has the costly one's
/// values where that was evaluated last, is solved in its place, until the next step is too small to matter,
/// or has changed chi2 by no more than that (space mapping: Bandler et al., IEEE Trans. Microwave Theory
/// Tech. 52, 2004). Targets that are logarithmic are corrected by a factor, others by a difference. A trial
/// that fails, or is worse, halves the longest step. Slopes are the coarse model's: where residuals stay
/// large, it ends near the least sum of squares, and not quite at it.
///
/// The result's evaluations are the costly model's; its jacobian is the coarse model's, as it was corrected
/// last. Steps whose kind begins with "coarse" are of the first solution. A failure at the start without an
/// evaluation is the coarse model's; with one, the costly model's where the coarse one fits best.
LeastSquaresResult solve_by_coarse_model(const LeastSquaresProblem& problem,
                                         const LeastSquaresProblem& coarse);

}  // namespace mss::fit

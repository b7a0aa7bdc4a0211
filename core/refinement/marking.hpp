#pragma once

#include <cstddef>
#include <vector>

#include "core/refinement/refined_body.hpp"

namespace mss {

/// The fewest cells whose indicators add up to at least a share of all, most first (Doerfler, SIAM J. Numer.
/// Anal. 33 (1996) 1106). Indicators must not be negative; of equal ones the lower id is first. With costs,
/// one a cell, those with most over their cost are first.
std::vector<std::size_t> doerfler_marking(const std::vector<double>& indicators, double share,
                                          const std::vector<double>& costs = {});

/// What smaller cells are to save. In explicit steps deep cells cost more, each depth twice the steps of the
/// one before.
enum class Saved {
  particles,  ///< cells are split by their indicators
  time        ///< by their indicators over 4^depth; `mss refine` compares both
};

/// The map of a body in which those cells are split too that half of the estimated error comes from: of the
/// displacement under the only load, u being the response to it, or of a quantity whose dual solution is z,
/// both small and in the body's fields. Every level's error is recovered in its own lattice, where hanging
/// particles are where their masters have them. Throws as DisplacementRecovery does.
RefinementMap split_by_estimate(const RefinedBody& body, const Field<double>& displacement,
                                const Field<double>* dual = nullptr, Saved saved = Saved::particles);

}  // namespace mss

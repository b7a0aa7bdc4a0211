#pragma once

#include "core/spectral_bound.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// Largest step [s] predicted to be stable for all modes up to `bound`; infinity where there is no limit.
/// Throws InputError if no step is.
double stable_step(const IntegratorInfo& method, const SpectralBound& bound);

/// What `dt = "safe"` stands for: a share of the predicted limit that leaves room for modes stiffened by
/// deformation.
inline constexpr double safe_share = 0.9;

}  // namespace mss

#pragma once

#include "core/spectral_bound.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// Largest stable step [s] predicted for a method on modes up to `bound`; infinity where there is no limit.
/// Throws InputError for a method that no step makes stable.
double stable_step(const IntegratorInfo& method, const SpectralBound& bound);

/// What `dt = "safe"` stands for: a share of the predicted limit that leaves room for modes stiffened by
/// deformation.
inline constexpr double safe_share = 0.9;

}  // namespace mss

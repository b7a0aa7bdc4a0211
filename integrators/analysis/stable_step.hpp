#pragma once

#include "core/body/spectral_bound.hpp"
#include "core/springs/solid_system.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// Largest step [s] that is stable for all modes up to `bound`; infinity where there is no limit, 0 if no
/// step is.
double guaranteed_step(const IntegratorInfo& method, const SpectralBound& bound);

/// The same, or InputError if no step is.
double stable_step(const IntegratorInfo& method, const SpectralBound& bound);

/// `dt = "safe"` is this share of the guaranteed limit; the rest is a margin for modes stiffened by
/// deformation.
inline constexpr double safe_share = 0.9;

/// The largest step for which small motions of a body about a state should stay bounded, and whether it could
/// be found.
struct PredictedStep {
  Status status = Status::ok;
  double dt = 0;  ///< [s]; 0: none is stable
};

/// stable_step() uses bounds of the spectrum only; this uses the body's own stiffness and damping, whether or
/// not they have modes in common. A motion q has the squared frequency q.K q and the damping q.C q (Rayleigh
/// quotients), and the result is the smallest limit of a motion: for one-step methods among those that a step
/// amplifies most, for the others (unstable where a sum of w^2 dt^2 and c dt reaches a number, at a motion
/// with amplification factor -1) among all. Of methods that split steps it is the smaller of the two: with
/// little damping some steps shorter than the limit of the fastest motion amplify slower ones.
PredictedStep predicted_step(const IntegratorInfo& method, SolidSystem<double>& system,
                             const State<double>& state, Work& work);

}  // namespace mss

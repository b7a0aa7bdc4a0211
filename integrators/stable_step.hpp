#pragma once

#include "core/body_system.hpp"
#include "core/spectral_bound.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// Largest step [s] that is stable for all modes up to `bound`; infinity where there is no limit, 0 if no
/// step is.
double sure_step(const IntegratorInfo& method, const SpectralBound& bound);

/// The same, or InputError if no step is.
double stable_step(const IntegratorInfo& method, const SpectralBound& bound);

/// What `dt = "safe"` stands for: a share of the predicted limit that leaves room for modes stiffened by
/// deformation.
inline constexpr double safe_share = 0.9;

/// The largest step for which small motions of a body about a state should stay bounded, and whether it could
/// be found.
struct PredictedStep {
  Status status = Status::ok;
  double dt = 0;  ///< [s]; 0: none is stable
};

/// Where stable_step() knows bounds of the spectrum only, this looks at the body's own stiffness and damping,
/// whether or not they have modes in common. A motion q has the frequency and damping of its shares q.K q and
/// q.C q, and the limit is that of a motion whose own is least: of one-step methods among those that a step
/// amplifies most, of the others (whose limit is where a sum of w^2 dt^2 and c dt reaches a number, at a
/// motion that only changes its sign) among all.
PredictedStep predicted_step(const IntegratorInfo& method, BodySystem<double>& system,
                             const State<double>& state, Work& work);

}  // namespace mss

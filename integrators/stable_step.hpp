#pragma once

#include "core/body_system.hpp"
#include "core/spectral_bound.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// Largest step [s] predicted to be stable for all modes up to `bound`; infinity where there is no limit.
/// Throws InputError if no step is.
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

/// Where stable_step() knows bounds of the spectrum only, this looks at the body's own stiffness and damping.
/// A motion q has the frequency and damping of its shares q.K q and q.C q; the limit is that of the motion
/// whose own is least. It is found as the fixed point of: which motion has most of K + s C, where s weighs
/// damping against stiffness as the method's limit does at the last one. Exact for methods whose limit is
/// where a sum of w^2 dt^2 and c dt reaches a number, whether or not K and C have modes in common.
PredictedStep predicted_step(const IntegratorInfo& method, BodySystem<double>& system,
                             const State<double>& state, Work& work);

}  // namespace mss

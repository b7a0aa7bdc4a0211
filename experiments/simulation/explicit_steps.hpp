#pragma once

#include <vector>

#include "core/springs/body_system.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// An explicit method with equal steps over some duration.
struct ExplicitSteps {
  const IntegratorInfo* info;
  long steps;
  double dt;  ///< [s]
};

/// The fewest steps over `duration` [s] that are at most `share` of the method's safe one.
ExplicitSteps explicit_steps(const IntegratorInfo& info, const SpectralBound& bound, double duration,
                             double share = 1);

/// The explicit methods of fixed step that need at most 1.2 times the fewest force evaluations over
/// `duration` [s] at safe steps.
std::vector<ExplicitSteps> cheapest_explicit_steps(BodySystem<double>& system, const State<double>& start,
                                                   double duration);

/// Wall time of one step of semi-implicit Euler near the undeformed body, at its safe step: a median [s].
double explicit_step_seconds(BodySystem<double>& system);

}  // namespace mss

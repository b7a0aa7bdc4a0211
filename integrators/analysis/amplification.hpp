#pragma once

#include <vector>

#include "integrators/analysis/modes.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// Stiffness and damping of several motions, and whether they could be computed.
struct AmplifiedMotions {
  Status status = Status::ok;
  std::vector<RayleighQuotients> motions = {};
};

/// The motions of a body about a state that a step of a one-step method amplifies most: eigenvectors (q, q')
/// of R(dt A), A the first-order form q'' = -K q - C q' of small motions and R the method's stability
/// polynomial; or of its drifts q += dt q' and kicks q' -= dt (K q + C q'). The method has one of the two.
/// Rigid motions are left out. By Arnoldi; all of them where that is cheaper.
AmplifiedMotions most_amplified(SolidSystem<double>& system, const State<double>& state,
                                const IntegratorInfo& method, double dt, Work& work);

}  // namespace mss

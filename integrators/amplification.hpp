#pragma once

#include <vector>

#include "integrators/modes.hpp"

namespace mss {

/// Stiffness and damping of several motions, and whether they could be computed.
struct AmplifiedMotions {
  Status status = Status::ok;
  std::vector<RayleighQuotients> motions = {};
};

/// The motions of a body about a state that a step of a one-step method amplifies most: eigenvectors (q, q')
/// of R(dt A), A the first-order form q'' = -K q - C q' of small motions and R the method's stability
/// polynomial, coefficients ascending. Rigid ones are left out. By Arnoldi; all of them where that is
/// cheaper.
AmplifiedMotions most_amplified(BodySystem<double>& system, const State<double>& state,
                                const std::vector<double>& polynomial, double dt, Work& work);

}  // namespace mss

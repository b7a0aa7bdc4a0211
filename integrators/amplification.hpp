#pragma once

#include <vector>

#include "integrators/modes.hpp"

namespace mss {

/// What motions have of stiffness and damping, and whether they could be found.
struct Shares {
  Status status = Status::ok;
  std::vector<Share> motions = {};
};

/// The motions of a body about a state that a step of a one-step method makes largest: eigenvectors (q, q')
/// of R(dt A), A the first-order form q'' = -K q - C q' of small motions and R the method's stability
/// polynomial, coefficients ascending. Rigid ones are left out. By Arnoldi; all of them where that is
/// cheaper.
Shares most_amplified(BodySystem<double>& system, const State<double>& state,
                      const std::vector<double>& polynomial, double dt, Work& work);

}  // namespace mss

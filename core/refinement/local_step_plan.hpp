#pragma once

#include <cstddef>
#include <vector>

#include "core/body/spectral_bound.hpp"

namespace mss {

/// What p short steps in a step of dt make of omega^2 dt^2: 2 (1 - T_p(delta - omega^2 dt^2 / w) /
/// T_p(delta)), with T_k Chebyshev's polynomials, delta > 1 and w = 2 T_p'(delta) / T_p(delta).
struct ChebyshevFilter {
  ChebyshevFilter(int p, double delta);
  /// Of omega^2 dt^2: beyond, what becomes of it is not bounded.
  double range() const { return w * (1 + delta); }
  /// What becomes of any number in the range is at most this, and less than 4.
  double largest() const { return 2 * (1 + 1 / value.back()); }

  double delta, w = 0;
  std::vector<double> value;  ///< T_0(delta) to T_p(delta)
};

/// Levels of a refined body, from one of them on, in shorter steps than the levels before.
struct LocalRate {
  std::size_t first_level;
  int substeps;  ///< p, in each step of the rate before
};

/// Which levels take how many short steps in each of the largest cells'.
struct LocalStepPlan {
  std::vector<LocalRate> rates{};  ///< after the slowest; none: all levels take the same steps
  double largest_step = 0;         ///< stable [s]
};

/// A level, the largest cells first.
struct LevelCost {
  int depth;
  std::size_t particles;
  std::size_t beside_next;  ///< those in cells that touch a master of the next level's particles
  SpectralBound bound;
};

/// The quickest plan of all that there are.
LocalStepPlan plan_local_steps(const std::vector<LevelCost>& levels);

/// By rate, in steps of dt [s] of a body with such a bound on its damping [1/s]. Each bounds what it makes of
/// the next by the range of the one before; none if that is impossible, in steps that no plan takes.
std::vector<ChebyshevFilter> filters_of(const std::vector<LocalRate>& rates, double damping, double dt);

}  // namespace mss

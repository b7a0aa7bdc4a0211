#include "integrators/stable_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace mss {

// The positive root of w^2 dt^2 + 2 c dt = 4.
double central_limit(double omega, double damping) { return 4 / (damping + std::hypot(damping, 2 * omega)); }

double stable_step(const IntegratorInfo& method, const SpectralBound& bound) {
  if (!method.limit) return std::numeric_limits<double>::infinity();
  constexpr int parts = 16;  // no limit is worst far from a corner of the range
  double limit = std::numeric_limits<double>::infinity();
  for (int i = 1; i <= parts; ++i)
    for (int j = 0; j <= parts; ++j)
      limit = std::min(limit, method.limit(bound.omega * i / parts, bound.damping * j / parts));
  if (limit <= 0)
    throw InputError(
        fmt::format("dt = \"safe\" cannot be given for {}: undamped modes are unstable at any "
                    "step; give dt in seconds, or another integrator",
                    method.name));
  return limit;
}

}  // namespace mss

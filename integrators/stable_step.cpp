#include "integrators/stable_step.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "core/error.hpp"

namespace mss {

double stable_step(const IntegratorInfo& method, const SpectralBound& bound) {
  switch (method.limit) {
    case StabilityLimit::none:
      return std::numeric_limits<double>::infinity();
    case StabilityLimit::central:  // the positive root of w^2 dt^2 + 2 c dt = 4
      return 4 / (bound.damping + std::hypot(bound.damping, 2 * bound.omega));
    case StabilityLimit::explicit_euler:  // w^2 dt < c fails for some mode at any step unless all are well
                                          // damped
      throw InputError(fmt::format(
          "dt = \"safe\" cannot be given for {}: undamped modes are unstable at any step; give dt in "
          "seconds, or another integrator",
          method.name));
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace mss

#include "integrators/stable_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "integrators/modes.hpp"

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

namespace {

/// How much one unit of damping shortens the step, over what one of stiffness does.
double weight_at(const IntegratorInfo& method, const Share& share) {
  const double omega = std::sqrt(share.stiffness), small = 1e-5;
  const auto limit = [&](double stiffness, double damping) {
    return method.limit(std::sqrt(stiffness), damping);
  };
  const double more = share.damping + small * omega, stiffer = (1 + small) * share.stiffness;
  const double by_damping = (limit(share.stiffness, more) - limit(share.stiffness, share.damping)) / omega;
  const double by_stiffness =
      (limit(stiffer, share.damping) - limit(share.stiffness, share.damping)) / share.stiffness;
  return by_damping / by_stiffness;
}

}  // namespace

PredictedStep predicted_step(const IntegratorInfo& method, BodySystem<double>& system,
                             const State<double>& state, Work& work) {
  constexpr int most_rounds = 30;
  constexpr double settled = 1e-7;
  constexpr double rigid = 1e-10;
  const double bound = system.spectral_bound().omega;
  PredictedStep found{.dt = std::numeric_limits<double>::infinity()};
  if (!method.limit) return found;
  double weight = 0;
  for (int round = 0; round < most_rounds; ++round) {
    const Share share = largest_share(system, state, weight, work);
    if (share.status != Status::ok) return {.status = share.status};
    if (share.stiffness < rigid * bound * bound) break;  // motions of the whole: no other has more
    const double before = found.dt, dt = method.limit(std::sqrt(share.stiffness), share.damping);
    found.dt = std::min(before, dt);
    if (dt == 0 || !(dt < before * (1 - settled))) break;
    weight = weight_at(method, share);
  }
  return found;
}

}  // namespace mss

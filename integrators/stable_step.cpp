#include "integrators/stable_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "integrators/amplification.hpp"

namespace mss {

// The positive root of w^2 dt^2 + 2 c dt = 4.
double central_limit(double omega, double damping) { return 4 / (damping + std::hypot(damping, 2 * omega)); }

double sure_step(const IntegratorInfo& method, const SpectralBound& bound) {
  if (!method.limit) return std::numeric_limits<double>::infinity();
  constexpr int parts = 16;  // no limit is worst far from a corner of the range
  double limit = std::numeric_limits<double>::infinity();
  for (int i = 1; i <= parts; ++i)
    for (int j = 0; j <= parts; ++j)
      limit = std::min(limit, method.limit(bound.omega * i / parts, bound.damping * j / parts));
  return limit;
}

double stable_step(const IntegratorInfo& method, const SpectralBound& bound) {
  const double limit = sure_step(method, bound);
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

constexpr double infinity = std::numeric_limits<double>::infinity();

double limit_of(const IntegratorInfo& method, const Share& share) {
  return method.limit(std::sqrt(share.stiffness), share.damping);
}

/// The fixed point of: which motion has most of K + s C, where s weighs damping against stiffness as the
/// limit does at the last one.
PredictedStep by_largest_share(const IntegratorInfo& method, BodySystem<double>& system,
                               const State<double>& state, Work& work) {
  constexpr int most_rounds = 30;
  constexpr double settled = 1e-7;
  PredictedStep found{.dt = infinity};
  double weight = 0;
  for (int round = 0; round < most_rounds; ++round) {
    const Share share = largest_share(system, state, weight, work);
    if (share.status != Status::ok) return {.status = share.status};
    if (is_rigid(share, system.spectral_bound().omega)) return found;  // no other motion has more
    const double before = found.dt, dt = limit_of(method, share);
    found.dt = std::min(before, dt);
    if (dt == 0 || !(dt < before * (1 - settled))) return found;
    weight = weight_at(method, share);
  }
  return {.status = Status::linear_stalled};
}

/// The least limit among the motions that a step a little too long amplifies most; again from there until
/// there is no lesser one.
PredictedStep by_amplification(const IntegratorInfo& method, BodySystem<double>& system,
                               const State<double>& state, Work& work) {
  constexpr int most_rounds = 60;
  constexpr double settled = 1e-4, too_long = 1.01, far_too_long = 4;
  const Share fastest = largest_share(system, state, 0, work);
  if (fastest.status != Status::ok) return {.status = fastest.status};
  if (is_rigid(fastest, system.spectral_bound().omega)) return {.dt = infinity};
  PredictedStep found{.dt = far_too_long / std::sqrt(fastest.stiffness)};
  for (int round = 0; round < most_rounds; ++round) {
    const Shares shares = most_amplified(system, state, method.polynomial, too_long * found.dt, work);
    if (shares.status != Status::ok) return {.status = shares.status};
    double least = infinity;
    for (const Share& share : shares.motions) least = std::min(least, limit_of(method, share));
    const bool done = least == 0 || least > found.dt * (1 - settled);
    found.dt = std::min(found.dt, least);
    if (done) return found;
  }
  return {.status = Status::linear_stalled};
}

}  // namespace

PredictedStep predicted_step(const IntegratorInfo& method, BodySystem<double>& system,
                             const State<double>& state, Work& work) {
  if (!method.limit) return {.dt = infinity};
  return method.polynomial.empty() ? by_largest_share(method, system, state, work)
                                   : by_amplification(method, system, state, work);
}

}  // namespace mss

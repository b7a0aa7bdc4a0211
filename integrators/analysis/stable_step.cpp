#include "integrators/analysis/stable_step.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "core/base/error.hpp"
#include "integrators/analysis/amplification.hpp"
#include "integrators/analysis/scaled_tangent.hpp"

namespace mss {

// The positive root of w^2 dt^2 + 2 c dt = 4.
double central_limit(double omega, double damping) { return 4 / (damping + std::hypot(damping, 2 * omega)); }

namespace {

/// |R| of the root lambda dt that grows more.
double largest_factor(const std::vector<double>& coefficients, double omega, double damping) {
  using Complex = std::complex<double>;
  const Complex root = std::sqrt(Complex(damping * damping / 4 - omega * omega));
  double largest = 0;
  for (const Complex z : {-damping / 2 + root, -damping / 2 - root}) {
    Complex sum = 0;
    for (auto c = coefficients.rbegin(); c != coefficients.rend(); ++c) sum = sum * z + *c;
    largest = std::max(largest, std::abs(sum));
  }
  return largest;
}

}  // namespace

// Looks for the first step that is too long, among steps that grow by a fiftieth from one that is short for
// any method: where a method is unstable there, it is at any step.
double polynomial_limit(const std::vector<double>& coefficients, double omega, double damping) {
  constexpr double shortest = 1.0 / 16, growth = 1.02, rounding = 1e-13;
  const double rate = std::max(omega, damping), degree = double(coefficients.size()) - 1;
  const double longest = 4 * degree * degree + 16;  // beyond the interval of any method of this degree
  const auto is_stable = [&](double step) {
    return largest_factor(coefficients, omega * step, damping * step) <= 1 + rounding;
  };
  if (rate == 0) return std::numeric_limits<double>::infinity();
  double low = 0, high = shortest / rate;
  while (is_stable(high)) {
    if (high * rate > longest) return std::numeric_limits<double>::infinity();
    low = high;
    high *= growth;
  }
  if (low == 0) return 0;
  while (high - low > 1e-12 * high) {
    const double middle = (low + high) / 2;
    (is_stable(middle) ? low : high) = middle;
  }
  return low;
}

double guaranteed_step(const IntegratorInfo& method, const SpectralBound& bound) {
  if (!method.limit) return std::numeric_limits<double>::infinity();
  constexpr int parts = 16;  // no limit is worst far from a corner of the range
  double limit = std::numeric_limits<double>::infinity();
  for (int i = 1; i <= parts; ++i)
    for (int j = 0; j <= parts; ++j)
      limit = std::min(limit, method.limit(bound.omega * i / parts, bound.damping * j / parts));
  return limit;
}

double stable_step(const IntegratorInfo& method, const SpectralBound& bound) {
  const double limit = guaranteed_step(method, bound);
  if (limit <= 0)
    throw InputError(
        fmt::format("dt = \"safe\" cannot be given for {}: undamped modes are unstable at any "
                    "step; give dt in seconds, or another integrator",
                    method.name));
  return limit;
}

namespace {

/// How much a unit of damping shortens the step, relative to a unit of stiffness.
double weight_at(const IntegratorInfo& method, const RayleighQuotients& motion) {
  const double omega = std::sqrt(motion.stiffness), small = 1e-5;
  const auto limit = [&](double stiffness, double damping) {
    return method.limit(std::sqrt(stiffness), damping);
  };
  const double more = motion.damping + small * omega, stiffer = (1 + small) * motion.stiffness;
  const double by_damping = (limit(motion.stiffness, more) - limit(motion.stiffness, motion.damping)) / omega;
  const double by_stiffness =
      (limit(stiffer, motion.damping) - limit(motion.stiffness, motion.damping)) / motion.stiffness;
  return by_damping / by_stiffness;
}

constexpr double infinity = std::numeric_limits<double>::infinity();

double limit_of(const IntegratorInfo& method, const RayleighQuotients& motion) {
  return method.limit(std::sqrt(motion.stiffness), motion.damping);
}

/// Fixed-point iteration: the motion with the largest Rayleigh quotient of K + s C, where s weighs damping
/// against stiffness as the limit does at the previous motion.
PredictedStep by_largest_quotient(const IntegratorInfo& method, SolidSystem<double>& system,
                                  const State<double>& state, Work& work) {
  constexpr int most_rounds = 30;
  constexpr double settled = 1e-7;
  PredictedStep found{.dt = infinity};
  ScaledTangent tangent(system, state);
  const SpectralBound bound = system.spectral_bound();
  double weight = 0;
  for (int round = 0; round < most_rounds; ++round) {
    const RayleighQuotients motion = largest_quotient(tangent, bound, weight, work);
    if (motion.status != Status::ok) return {.status = motion.status};
    if (is_rigid(motion, bound.omega)) return found;  // no other has a larger quotient
    const double before = found.dt, dt = limit_of(method, motion);
    found.dt = std::min(before, dt);
    if (dt == 0 || !(dt < before * (1 - settled))) return found;
    weight = weight_at(method, motion);
  }
  return {.status = Status::linear_stalled};
}

/// The least limit among the motions that a step a little too long amplifies most; again from there until
/// there is no lesser one.
PredictedStep by_amplification(const IntegratorInfo& method, SolidSystem<double>& system,
                               const State<double>& state, Work& work) {
  constexpr int most_rounds = 60;
  constexpr double settled = 1e-4, too_long = 1.01, far_too_long = 4;
  ScaledTangent tangent(system, state);
  const RayleighQuotients fastest = largest_quotient(tangent, system.spectral_bound(), 0, work);
  if (fastest.status != Status::ok) return {.status = fastest.status};
  if (is_rigid(fastest, system.spectral_bound().omega)) return {.dt = infinity};
  PredictedStep found{.dt = far_too_long / std::sqrt(fastest.stiffness)};
  for (int round = 0; round < most_rounds; ++round) {
    const AmplifiedMotions amplified = most_amplified(system, state, method, too_long * found.dt, work);
    if (amplified.status != Status::ok) return {.status = amplified.status};
    double least = infinity;
    for (const RayleighQuotients& motion : amplified.motions)
      least = std::min(least, limit_of(method, motion));
    const bool done = least == 0 || least > found.dt * (1 - settled);
    found.dt = std::min(found.dt, least);
    if (done) return found;
  }
  return {.status = Status::linear_stalled};
}

}  // namespace

PredictedStep predicted_step(const IntegratorInfo& method, SolidSystem<double>& system,
                             const State<double>& state, Work& work) {
  if (!method.limit) return {.dt = infinity};
  if (!method.polynomial.empty()) return by_amplification(method, system, state, work);
  const PredictedStep quotient = by_largest_quotient(method, system, state, work);
  if (method.splitting.empty() || quotient.status != Status::ok) return quotient;
  const PredictedStep amplified = by_amplification(method, system, state, work);
  return amplified.status != Status::ok || amplified.dt < quotient.dt ? amplified : quotient;
}

}  // namespace mss

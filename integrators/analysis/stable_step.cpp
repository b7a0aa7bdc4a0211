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
    for (std::size_t n = coefficients.size(); n-- > 0;) sum = sum * z + coefficients[n];
    largest = std::max(largest, std::abs(sum));
  }
  return largest;
}

}  // namespace

// Looks for the first step that is too long, among steps that grow by a fiftieth from one that is short for
// any method: where a method is unstable there, it is at any step.
double polynomial_limit(const std::vector<double>& coefficients, double omega, double damping) {
  constexpr double shortest = 1.0 / 16, growth = 1.02, rounding = 1e-13;
  constexpr double fastest = 1e290;  // steps are numbers that a fiftieth still changes
  const double rate = std::max(omega, damping), degree = double(coefficients.size()) - 1;
  const double longest = 4 * degree * degree + 16;  // beyond the interval of any method of this degree
  const auto is_stable = [&](double step) {
    return largest_factor(coefficients, omega * step, damping * step) <= 1 + rounding;
  };
  if (rate == 0) return std::numeric_limits<double>::infinity();
  if (!(rate < fastest)) return 0;
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

namespace {

/// How far both eigenvalues of a step's matrix are inside the unit circle, with w dt and c dt given: negative
/// if one is outside.
double margin_at(const std::vector<DriftKick>& parts, double omega, double damping) {
  double x[2] = {1, 0}, v[2] = {0, 1};  // of the two columns
  for (const auto [drift, kick] : parts)
    for (int i = 0; i < 2; ++i) {
      x[i] += drift * v[i];
      v[i] -= kick * (omega * omega * x[i] + damping * v[i]);
    }
  const double trace = x[0] + v[1], determinant = x[0] * v[1] - x[1] * v[0];
  constexpr double rounding = 1e-12;
  if (!(std::abs(determinant) <= 1 + rounding)) return -1;
  return 1 + determinant + rounding - std::abs(trace);
}

/// Between two points, of a function with one minimum there, by golden sections: where it is negative, or
/// lowest.
template <class Function>
double negative_or_lowest(double low, double high, Function&& value) {
  constexpr double golden = 0.381966011250105;
  while (high - low > 1e-9 * high) {
    const double a = low + golden * (high - low), b = high - golden * (high - low);
    const double at_a = value(a), at_b = value(b);
    if (at_a < 0) return a;
    if (at_b < 0) return b;
    (at_a < at_b ? high : low) = at_a < at_b ? b : a;
  }
  return low;
}

}  // namespace

// Looks for the first step that is not stable along a grid, and, since ranges of unstable steps can be far
// narrower than that, wherever the eigenvalues come nearest to where they leave the circle.
double splitting_limit(const std::vector<DriftKick>& parts, double omega, double damping) {
  constexpr double fine = 0.02;
  if (omega == 0 && damping == 0) return std::numeric_limits<double>::infinity();
  const double unit = fine / std::max(omega, damping);
  const auto margin = [&](double step) { return margin_at(parts, omega * step, damping * step); };
  double low = 0, high = unit, at_low = 0, at_high = margin(high);
  if (at_high < 0) return 0;
  while (at_high >= 0) {
    const double next = high + unit, at_next = margin(next);
    double dip = next;
    if (at_high <= at_low && at_high < at_next) dip = negative_or_lowest(low, next, margin);
    if (margin(dip) < 0) {
      low = dip > high ? high : low;
      high = dip;
      break;
    }
    low = high, at_low = at_high;
    high = next, at_high = at_next;
  }
  while (high - low > 1e-12 * high) {
    const double middle = (low + high) / 2;
    (margin(middle) >= 0 ? low : high) = middle;
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
/// there is no lesser one. Begins at a step that is not shorter than it.
PredictedStep by_amplification(const IntegratorInfo& method, SolidSystem<double>& system,
                               const State<double>& state, double longest, Work& work) {
  constexpr int most_rounds = 60;
  constexpr double settled = 1e-4, too_long = 1.01;
  PredictedStep found{.dt = longest};
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

/// A step that is not shorter than the limit: as long as the fastest motion may take, or longer.
PredictedStep long_step(const IntegratorInfo& method, SolidSystem<double>& system, const State<double>& state,
                        Work& work) {
  constexpr double far_too_long = 4;
  ScaledTangent tangent(system, state);
  const RayleighQuotients fastest = largest_quotient(tangent, system.spectral_bound(), 0, work);
  if (fastest.status != Status::ok) return {.status = fastest.status};
  if (is_rigid(fastest, system.spectral_bound().omega)) return {.dt = infinity};
  return {.dt = method.resonant_limit ? limit_of(method, fastest)
                                      : far_too_long / std::sqrt(fastest.stiffness)};
}

}  // namespace

PredictedStep predicted_step(const IntegratorInfo& method, SolidSystem<double>& system,
                             const State<double>& state, Work& work) {
  if (!method.limit) return {.dt = infinity};
  const auto amplified_at = [&](const PredictedStep& begin) {
    if (begin.status != Status::ok || begin.dt == infinity) return begin;
    return by_amplification(method, system, state, begin.dt, work);
  };
  // A resonant limit jumps where damping closes a range of unstable steps: no quotient follows it.
  if (!method.polynomial.empty() || method.resonant_limit)
    return amplified_at(long_step(method, system, state, work));
  const PredictedStep quotient = by_largest_quotient(method, system, state, work);
  if (method.splitting.empty() || quotient.status != Status::ok) return quotient;
  const PredictedStep amplified = amplified_at(long_step(method, system, state, work));
  return amplified.status != Status::ok || amplified.dt < quotient.dt ? amplified : quotient;
}

}  // namespace mss

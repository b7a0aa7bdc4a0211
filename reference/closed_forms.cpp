#include "reference/closed_forms.hpp"

#include <cmath>
#include <numbers>

namespace mss::reference {

namespace {
using std::numbers::pi;
}

double cantilever_deflection(const SquareBar& bar, double force) {
  const double area = bar.width * bar.width, moment = area * area / 12,
               shear = bar.young / (2 * (1 + bar.poisson));
  const double coefficient = 10 * (1 + bar.poisson) / (12 + 11 * bar.poisson);
  return force * bar.length * bar.length * bar.length / (3 * bar.young * moment) +
         force * bar.length / (coefficient * shear * area);
}

double torsion_stiffness(const SquareBar& bar) {
  double sum = 0;
  for (int k = 1; k < 200; k += 2) sum += std::tanh(k * pi / 2) / std::pow(k, 5);
  const double j = std::pow(bar.width, 4) / 3 * (1 - 192 / std::pow(pi, 5) * sum);
  return bar.young / (2 * (1 + bar.poisson)) * j / bar.length;
}

double hanging_sag(const SquareBar& bar, double density, double gravity) {
  return density * gravity * bar.length * bar.length / (2 * bar.young);
}

double bar_frequency(double stiffness, double density, double length, int mode) {
  return (2 * mode - 1) / (4 * length) * std::sqrt(stiffness / density);
}

double chain_frequency(double stiffness, double density, double length, int links, int mode) {
  return std::sin(pi * (2 * mode - 1) / (4 * links)) / pi * std::sqrt(stiffness / density) * links / length;
}

double transverse_speed(const Stretched& body) { return std::sqrt(body.tension / body.mass); }

double string_frequency(const Stretched& string, int mode) {
  return mode / (2 * string.length) * transverse_speed(string);
}

double beaded_string_frequency(const Stretched& string, int links, int mode) {
  return std::sin(pi * mode / (2 * links)) * links / (pi * string.length) * transverse_speed(string);
}

double membrane_frequency(const Stretched& membrane, int p, int q) {
  return std::hypot(p, q) / (2 * membrane.length) * transverse_speed(membrane);
}

double net_frequency(const Stretched& membrane, int squares, int p, int q) {
  const double a = pi * p / (2 * squares), b = pi * q / (2 * squares);
  const double sines = std::sin(a) * std::sin(a) + std::sin(b) * std::sin(b);
  return std::sqrt(2 * sines + 1 - std::cos(2 * a) * std::cos(2 * b)) * squares / (2 * pi * membrane.length) *
         transverse_speed(membrane);
}

/// The span grows with the pull: bisection.
Catenary catenary(double length, double span, double stretch) {
  const auto span_of = [&](double pull) { return length * pull * (stretch + 2 * std::asinh(0.5 / pull)); };
  double low = 0, high = 1;
  while (span_of(high) < span) high *= 2;
  for (int i = 0; i < 200; ++i) {
    const double pull = (low + high) / 2;
    (span_of(pull) < span ? low : high) = pull;
  }
  const double pull = (low + high) / 2;
  return {.sag = length * (stretch / 8 + std::hypot(pull, 0.5) - pull), .pull = pull, .rise = 0.5};
}

double logarithmic_decrement(double viscosity, double stiffness, double frequency) {
  const double zeta = viscosity * pi * frequency / stiffness;
  return 2 * pi * zeta / std::sqrt(1 - zeta * zeta);
}

double bounce_height(double drop, double restitution, int bounces) {
  return drop * std::pow(restitution, 2 * bounces);
}

double slope_distance(double gravity, double angle, double friction, double time) {
  const double acceleration = gravity * (std::sin(angle) - friction * std::cos(angle));
  return acceleration > 0 ? acceleration * time * time / 2 : 0;
}

double stopping_distance(double gravity, double speed, double friction) {
  return speed * speed / (2 * friction * gravity);
}

double capstan_ratio(double friction, double angle) { return std::exp(friction * angle); }

}  // namespace mss::reference

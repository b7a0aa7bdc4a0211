#include "reference/sphere_modes.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace mss::reference {

namespace {

constexpr unsigned degree = 2;
constexpr double product = 6;  // degree (degree + 1)

/// j2(q r), its first derivative by r, and its second, from the equation that j2 satisfies.
struct RadialFunction {
  RadialFunction(double q, double r)
      : value(std::sph_bessel(degree, q * r)),
        slope(degree / r * value - q * std::sph_bessel(degree + 1, q * r)),
        curvature((product / (r * r) - q * q) * value - 2 / r * slope) {}
  double value, slope, curvature;
};

struct WaveNumbers {
  WaveNumbers(const SolidSphere& sphere, double omega)
      : mu(sphere.material.young / (2 * (1 + sphere.material.poisson))),
        lambda(2 * mu * sphere.material.poisson / (1 - 2 * sphere.material.poisson)),
        pressure(omega / std::sqrt((lambda + 2 * mu) / sphere.density)),
        shear(omega / std::sqrt(mu / sphere.density)) {}
  double mu, lambda;       ///< Lame's constants [Pa]
  double pressure, shear;  ///< [1/m]
};

/// Tractions sigma_rr and sigma_rt / mu on a sphere of radius r, of the two parts of
///   u = grad(j2(h r) Y) + rot rot (r j2(k r) Y) = U Y e_r + V r grad Y,
///   sigma_rr = lambda div u + 2 mu U',  sigma_rt = mu (V' - V / r + U / r).
struct Tractions {
  Tractions(const WaveNumbers& q, double r) {
    const RadialFunction p(q.pressure, r), s(q.shear, r);
    radial_pressure = -q.lambda * q.pressure * q.pressure * p.value + 2 * q.mu * p.curvature;
    radial_shear = 2 * q.mu * product * (s.slope / r - s.value / (r * r));
    tangential_pressure = 2 * (p.slope / r - p.value / (r * r));
    // V = s / r + s', U = product s / r
    tangential_shear = s.curvature + (product - 2) * s.value / (r * r);
  }
  double determinant() const {
    return radial_pressure * tangential_shear - radial_shear * tangential_pressure;
  }
  double radial_pressure, radial_shear, tangential_pressure, tangential_shear;
};

/// The least root above `low` of a continuous function, found by steps of a hundredth and halving.
template <class Function>
double first_root(const Function& f, double low) {
  double high = low;
  do {
    low = high;
    high *= 1.01;
  } while (f(low) * f(high) > 0);
  while (high - low > 1e-15 * high) {
    const double middle = (low + high) / 2;
    if (middle == low || middle == high) break;
    (f(low) * f(middle) > 0 ? low : high) = middle;
  }
  return (low + high) / 2;
}

std::array<double, 5> harmonics(const Vec3& p) {
  return {p[0] * p[1], p[1] * p[2], p[2] * p[0], p[0] * p[0] - p[1] * p[1],
          2 * p[2] * p[2] - p[0] * p[0] - p[1] * p[1]};
}

std::array<Vec3, 5> gradients(const Vec3& p) {
  return {Vec3(p[1], p[0], 0), Vec3(0, p[2], p[1]), Vec3(p[2], 0, p[0]), Vec3(2 * p[0], -2 * p[1], 0),
          Vec3(-2 * p[0], -2 * p[1], 4 * p[2])};
}

double torsional_frequency(double unit) {
  return unit * first_root([](double x) { return std::sph_bessel(2, x) - x * std::sph_bessel(3, x); }, 1.0);
}

double spheroidal_frequency(const SolidSphere& sphere, double unit) {
  return first_root(
      [&](double omega) { return Tractions(WaveNumbers(sphere, omega), sphere.radius).determinant(); },
      0.5 * unit);
}

double frequency(const SolidSphere& sphere, SphereMode mode) {
  const double unit = std::sqrt(WaveNumbers(sphere, 0).mu / sphere.density) / sphere.radius;
  return mode == SphereMode::torsional ? torsional_frequency(unit) : spheroidal_frequency(sphere, unit);
}

}  // namespace

SphereVibration::SphereVibration(const SolidSphere& sphere, SphereMode mode)
    : sphere_(sphere), mode_(mode), omega_(frequency(sphere, mode)) {
  const Tractions surface(WaveNumbers(sphere, omega_), sphere.radius);
  shear_part_ = -surface.radial_pressure / surface.radial_shear;
}

std::array<Vec3, 5> SphereVibration::displacements(const Vec3& place) const {
  std::array<Vec3, 5> fields;
  fields.fill(Vec3::Zero());
  const double r = place.norm();
  if (r < 1e-9 * sphere_.radius) return fields;
  const auto harmonic = harmonics(place);
  const auto gradient = gradients(place);
  const WaveNumbers q(sphere_, omega_);
  const RadialFunction s(q.shear, r), p(q.pressure, r);
  const double u = p.slope + shear_part_ * product * s.value / r;
  const double v = p.value / r + shear_part_ * (s.value / r + s.slope);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (mode_ == SphereMode::torsional) {
      fields[i] = s.value / (r * r) * place.cross(gradient[i]);
      continue;
    }
    const double y = harmonic[i] / (r * r);
    const Vec3 outward = place / r, tangential = gradient[i] / r - 2 * y * outward;  // r grad Y
    fields[i] = u * y * outward + v * tangential;
  }
  return fields;
}

}  // namespace mss::reference

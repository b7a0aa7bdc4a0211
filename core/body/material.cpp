#include "core/body/material.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <map>
#include <mutex>

#include "core/base/error.hpp"
#include "core/body/phonons.hpp"

namespace mss {

namespace {

/// Compliances of a cubic crystal.
struct Compliance {
  double s11, s12, s44;
  /// s11 - s12 - s44/2: what makes the response depend on direction.
  double anisotropy() const { return s11 - s12 - s44 / 2; }
};

Compliance invert(const CubicStiffness& c) {
  const double det = (c.c11 - c.c12) * (c.c11 + 2 * c.c12);
  return {(c.c11 + c.c12) / det, -c.c12 / det, 1 / c.c44};
}

/// l^2 m^2 + m^2 n^2 + n^2 l^2 of the direction cosines: 0 along [100], 1/3 along [111].
double cubic_invariant(const Eigen::Vector3d& direction) {
  const Eigen::Array3d squares = direction.normalized().array().square();
  return squares[0] * squares[1] + squares[1] * squares[2] + squares[2] * squares[0];
}

/// Strains that soft bodies reach: a stretch by half, either way.
double within_reach(StrainPath::Kind kind) { return kind == StrainPath::Kind::compression ? 1.0 / 3 : 0.5; }

/// Where the lattice in cells of 1 m is unstable at strains within reach, in words; where its energy has no
/// lower bound, as a negative volume stiffness makes it, at any strain that was looked at. Empty: nowhere.
std::string instabilities_of(const SpringConstants& springs) {
  std::vector<std::string> all;
  for (const PhononLimit& limit : least_phonon_limits(springs, 1, [&](StrainPath::Kind kind) {
         return springs.volume < 0 ? farthest_strain : within_reach(kind);
       }))
    if (std::isfinite(limit.strain))
      all.push_back(fmt::format("{:.3g} percent of {}", 100 * limit.strain, limit.path.name()));
  return fmt::format("{}", fmt::join(all, ", "));
}

/// The same of cells of any size. Strains have no units: they are those of the ratios of the springs, which
/// the scenes of a program share, in cells of whatever size, and which take milliseconds once.
std::string instabilities(const SpringConstants& springs, double cell_size) {
  static std::mutex mutex;
  static std::map<std::array<float, 4>, std::string> known;
  const double unit = springs.edge + springs.face + springs.body;
  const std::array ratios{float(springs.edge / unit), float(springs.face / unit), float(springs.body / unit),
                          float(springs.volume * cell_size / unit)};
  const std::scoped_lock lock(mutex);
  const auto [at, is_new] = known.try_emplace(ratios);
  if (is_new)
    at->second =
        instabilities_of({.edge = ratios[0], .face = ratios[1], .body = ratios[2], .volume = ratios[3]});
  return at->second;
}

}  // namespace

// 1/E(n) = s11 - 2 (s11 - s12 - s44/2) J(n): Nye, Physical Properties of Crystals, ch. VIII.
double CubicStiffness::young(const Eigen::Vector3d& direction) const {
  const Compliance s = invert(*this);
  return 1 / (s.s11 - 2 * s.anisotropy() * cubic_invariant(direction));
}

// The mean transverse strain follows from the trace: the volume strain s11 + 2 s12 does not depend on
// direction.
double CubicStiffness::poisson(const Eigen::Vector3d& direction) const {
  const Compliance s = invert(*this);
  const double along = s.s11 - 2 * s.anisotropy() * cubic_invariant(direction);
  return (along - (s.s11 + 2 * s.s12)) / (2 * along);  // in this order 0 has no sign
}

double Damping::coefficient(double k, double m1, double m2, double rest_length, double shear_modulus) const {
  switch (law) {
    case Law::none:
      return 0;
    case Law::ratio:
      return 2 * zeta * std::sqrt(k * m1 * m2 / (m1 + m2));
    case Law::thesis:
      return 2 * std::sqrt(k * (m1 + m2)) / rest_length;
    case Law::viscosity:
      return k * viscosity / shear_modulus;
  }
  return 0;
}

SpringConstants calibrate(const ElasticConstants& material, double cell_size, double face_share) {
  const auto [young, poisson] = material;
  if (!(young > 0) || !std::isfinite(young))
    throw InputError(fmt::format("young = {} is not a stiffness; give a positive number of pascals", young));
  if (!(poisson > -1 && poisson < 0.5))
    throw InputError(
        fmt::format("poisson = {} has no finite stiffness; allowed is -1 < poisson < 0.5", poisson));
  if (!(face_share >= 0 && face_share <= 1))
    throw InputError(fmt::format("face_share = {} is not a share; allowed is 0 to 1", face_share));
  const double mu = young / (2 * (1 + poisson));
  const double lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  const double t = face_share;
  return {.edge = (2 - t) * mu * cell_size,
          .face = t * mu * cell_size,
          .body = 0.75 * (1 - t) * mu * cell_size,
          .volume = lambda - mu};
}

CubicStiffness cubic_stiffness(const SpringConstants& springs, double cell_size) {
  const double shear = (springs.face + 4.0 / 3.0 * springs.body) / cell_size;
  return {.c11 = (springs.edge + 2 * springs.face + 4.0 / 3.0 * springs.body) / cell_size + springs.volume,
          .c12 = shear + springs.volume,
          .c44 = shear};
}

std::vector<std::string> material_warnings(const SpringConstants& springs, double cell_size) {
  const CubicStiffness c = cubic_stiffness(springs, cell_size);
  std::vector<std::string> warnings;
  const double zener = c.zener_ratio();
  const bool is_solid = c.c11 > c.c12 && c.c11 + 2 * c.c12 > 0 && c.c44 > 0;
  if (!is_solid)
    warnings.push_back(
        fmt::format("these springs do not resist every deformation: C11 = {:.6g}, C12 = {:.6g}, "
                    "C44 = {:.6g} Pa",
                    c.c11, c.c12, c.c44));
  else if (std::abs(zener - 1) > 1e-6)
    warnings.push_back(fmt::format(
        "the material depends on direction: Zener ratio {:.4g}; it is 1 when edge = face + 8/3 body", zener));
  const std::string unstable = is_solid ? instabilities(springs, cell_size) : "";
  if (!unstable.empty())
    warnings.push_back(fmt::format(
        "{}the lattice is unstable beyond {}; its particles then leave uniform strain at any step",
        springs.volume < 0 ? fmt::format("the volume stiffness is negative ({:.6g} Pa), as Poisson's ratio "
                                         "below 1/4 needs: ",
                                         springs.volume)
                           : "",
        unstable));
  if (springs.face == 0)
    warnings.emplace_back("without face diagonals a cell has modes no spring resists; choose face_share > 0");
  return warnings;
}

}  // namespace mss

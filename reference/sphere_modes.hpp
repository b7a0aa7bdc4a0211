#pragma once

#include <array>

#include "core/base/field.hpp"
#include "core/body/material.hpp"

namespace mss::reference {

/// A solid elastic sphere with a free surface; SI units.
struct SolidSphere {
  ElasticConstants material;
  double density, radius;
};

/// The slowest vibrations of degree 2, five of one frequency each: torsional, which twists hemispheres
/// against each other and moves nothing along the radius, and spheroidal, which makes the sphere an ellipsoid
/// (0T2 and 0S2 of seismology).
enum class SphereMode { torsional, spheroidal };

/// The five vibrations of one frequency.
class SphereVibration {
 public:
  SphereVibration(const SolidSphere& sphere, SphereMode mode);

  /// Angular frequency [rad/s]. Torsional: 2.501133 sqrt(mu / rho) / a, the root of j2(x) = x j3(x), for any
  /// nu; spheroidal: the least root of the condition that a surface without traction sets (Lamb, Proc. London
  /// Math. Soc. 13 (1882) 189; Eringen and Suhubi, Elastodynamics II, 8.13).
  double omega() const { return omega_; }

  /// The displacements of the five at a place, relative to the centre [m]; of any size, linearly independent.
  std::array<Vec3, 5> displacements(const Vec3& place) const;

 private:
  SolidSphere sphere_;
  SphereMode mode_;
  double omega_;
  double shear_part_;  ///< of the displacement without divergence, over that without rotation
};

}  // namespace mss::reference

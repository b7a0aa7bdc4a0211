#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace mss {

/// Which springs a cell has.
enum class Topology {
  full,         ///< 12 edges, 12 face diagonals, 4 body diagonals (Fig. 2-3)
  edges_body,   ///< no face diagonals: fails to recover (Fig. 2-1)
  one_diagonal  ///< one diagonal per face: direction-dependent (Fig. 2-2, left)
};

/// How the stiffness of a spring shared by several cells is defined.
enum class Sharing {
  weighted,  ///< each cell contributes k_e/4, k_f/2, k_c: converges under refinement
  uniform    ///< every distinct spring has its class's k, as the thesis implies
};

/// Stiffness of an interior spring of each class [N/m], and of the volume force [Pa].
struct SpringConstants {
  double edge = 0;
  double face = 0;
  double body = 0;
  double volume = 0;
};

/// An isotropic elastic material.
struct ElasticConstants {
  double young = 0;    ///< Young's modulus E [Pa]
  double poisson = 0;  ///< Poisson's ratio nu, in (-1, 0.5)
};

/// Stiffness of a cubic crystal, Voigt notation [Pa].
struct CubicStiffness {
  double c11 = 0;
  double c12 = 0;
  double c44 = 0;

  /// 2 C44 / (C11 - C12): 1 means the same in every direction.
  double zener_ratio() const { return 2 * c44 / (c11 - c12); }

  /// Young's modulus [Pa] for a pull along `direction` (any length).
  double young(const Eigen::Vector3d& direction) const;

  /// Poisson's ratio for a pull along `direction`, averaged over all directions across it.
  double poisson(const Eigen::Vector3d& direction) const;
};

/// How internal damping is chosen for a spring of stiffness k between masses m1 and m2.
///
/// A ratio zeta belongs to springs: c ~ h^2 where moduli are kept, so the body's viscosity c / h vanishes as
/// its cells shrink. A viscosity belongs to the material (Kelvin-Voigt). cubic_stiffness() is linear in the
/// springs, and dampers beside them are to strain rates what they are to strains: c = tau k for every spring,
/// tau = eta / C44, makes the lattice's viscosities tau times the stiffness of its springs, without k_vol,
/// which has no damper. Calibrated springs have C44 = C12 = mu and C11 = 3 mu: the stress is
///   2 eta e' + lambda' tr(e') I  with  lambda' = eta  (Cauchy's relation of central forces),
/// so the bulk viscosity is 5/3 eta whatever nu is. Springs and dampers are shared alike: `weighted` keeps
/// eta, `uniform` makes surfaces more viscous by as much as it makes them stiffer, and what a topology or a
/// fill factor takes of the springs it takes of eta too.
struct Damping {
  enum class Law {
    none,
    ratio,     ///< c = 2 zeta sqrt(k m1 m2 / (m1 + m2)): zeta of critical for the two-mass spring
    thesis,    ///< eq. 2-4 as printed, d = 2 sqrt(k (m1 + m2)) / l0: its units are not kg/s
    viscosity  ///< c = k eta / mu
  };
  Law law = Law::none;
  double zeta = 0;
  double viscosity = 0;  ///< eta, of shear [Pa s]

  /// Damping coefficient c of f = c (v_j - v_i).u [kg/s]. `shear_modulus`: C44 of the interior springs [Pa],
  /// not 0 with a viscosity.
  double coefficient(double k, double m1, double m2, double rest_length, double shear_modulus) const;
};

/// Spring constants that make the `weighted` full lattice isotropic with the given E and nu.
/// With mu, lambda the Lame constants and t the share of shear stiffness carried by face diagonals:
///   k_f = t mu h,  k_c = 3/4 (1-t) mu h,  k_e = (2-t) mu h,  k_vol = lambda - mu.
/// `cell_size` in m, `face_share` in [0, 1]. Throws InputError outside the admissible range.
SpringConstants calibrate(const ElasticConstants& material, double cell_size, double face_share);

/// The continuum equivalent of the infinite `weighted` full lattice of these springs (inverse of
/// calibrate()).
CubicStiffness cubic_stiffness(const SpringConstants& springs, double cell_size);

/// Warnings about these springs, as sentences for the user: anisotropy, strains at which the lattice is
/// unstable (`phonons.hpp`), mechanisms.
std::vector<std::string> material_warnings(const SpringConstants& springs, double cell_size);

}  // namespace mss

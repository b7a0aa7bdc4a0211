#pragma once

#include <Eigen/Core>

#include "core/body/material.hpp"

// Laws of elasticity for homogeneous deformations of any size, by which large strains are judged: F is the
// deformation gradient, energies are per volume at rest [J/m^3], and stresses are nominal ones (the first of
// Piola and Kirchhoff), dW/dF [Pa].

namespace mss::reference {

/// A law of a hyperelastic solid.
class LargeStrainLaw {
 public:
  virtual ~LargeStrainLaw() = default;
  virtual double energy(const Eigen::Matrix3d& F) const = 0;
  virtual Eigen::Matrix3d stress(const Eigen::Matrix3d& F) const = 0;
};

/// The continuum limit of the infinite `weighted` full lattice by the rule of Cauchy and Born: every cell
/// deforms by F, so W is the energy of its 3 edges, 6 face and 4 body diagonals (its share of those that it
/// has in common with others) and of its volume, over h^3:
///   W = 1 / h^3 sum_s k_s (|F r_s| - |r_s|)^2 / 2 + k_vol (det F - 1)^2 / 2,
///   P = 1 / h^3 sum_s k_s (1 - |r_s| / |F r_s|) F r_s r_s^T + k_vol (det F - 1) cof F.
/// M. Born and K. Huang, Dynamical Theory of Crystal Lattices (1954), sections 11 and 26.
class CauchyBorn final : public LargeStrainLaw {
 public:
  CauchyBorn(const SpringConstants& springs, double cell_size);
  double energy(const Eigen::Matrix3d& F) const override;
  Eigen::Matrix3d stress(const Eigen::Matrix3d& F) const override;

 private:
  SpringConstants springs_;
  double cell_size_;
};

/// The compressible neo-Hookean solid, W = mu / 2 (|F|^2 - 3) - mu ln J + lambda / 2 (ln J)^2 with J = det F
/// (Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd edition, section 6.4.3).
class NeoHookean final : public LargeStrainLaw {
 public:
  explicit NeoHookean(const ElasticConstants& material);
  double energy(const Eigen::Matrix3d& F) const override;
  Eigen::Matrix3d stress(const Eigen::Matrix3d& F) const override;

 private:
  double mu_, lambda_;
};

/// The law of St. Venant and Kirchhoff, linear in Green's strain E = (F^T F - 1) / 2:
/// W = mu |E|^2 + lambda / 2 (tr E)^2.
class StVenantKirchhoff final : public LargeStrainLaw {
 public:
  explicit StVenantKirchhoff(const ElasticConstants& material);
  double energy(const Eigen::Matrix3d& F) const override;
  Eigen::Matrix3d stress(const Eigen::Matrix3d& F) const override;

 private:
  double mu_, lambda_;
};

/// A bar stretched along x by a factor whose sides are free: F = diag(stretch, lateral, lateral) with no
/// stress across. For laws that treat y and z alike.
struct UniaxialState {
  double lateral;  ///< stretch of the sides; NaN if there is none in (1/3, 3)
  double stress;   ///< along the bar, nominal [Pa]
};
UniaxialState uniaxial_state(const LargeStrainLaw& law, double stretch);

}  // namespace mss::reference

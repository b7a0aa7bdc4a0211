#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "core/body/material.hpp"

namespace mss {

using Matrix9 = Eigen::Matrix<double, 9, 9>;

/// Lame constants [Pa].
struct Lame {
  double mu = 0;
  double lambda = 0;
  double bulk_modulus() const { return lambda + 2 * mu / 3; }
};
Lame lame_constants(const ElasticConstants& material);

/// At the eight Gauss points of a cell.
using PointMatrices = std::array<Eigen::Matrix3d, 8>;

/// How the stresses at a cell's points change with the deformation gradients F there: at each point by
/// `own` of its own change, and by shared R mean(R' : dF') of all, the mean over points F' with axes R'.
struct CellStiffness {
  std::array<Matrix9, 8> own;
  double shared = 0;  ///< [Pa]
  PointMatrices axes;
};

/// A material of finite elements: energy by the deformation gradient F (3 x 3, rest to deformed).
struct SolidLaw {
  std::string name;
  std::string summary;
  /// True if rotations count as strain, so that the law is for small ones only.
  bool small_rotations = false;
  /// Energy by rest volume [J/m^3].
  double (*energy)(const Lame&, const Eigen::Matrix3d& f) = nullptr;
  /// First Piola-Kirchhoff stress P = d energy / dF [Pa].
  Eigen::Matrix3d (*stress)(const Lame&, const Eigen::Matrix3d& f) = nullptr;
  /// The energies' sum and the stresses at a cell's Gauss points, where they are found faster together, or
  /// depend on each other; nullptr: one by one.
  double (*energies)(const Lame&, const PointMatrices& f) = nullptr;
  void (*stresses)(const Lame&, const PointMatrices& f, PointMatrices& stress) = nullptr;
  /// dP/dF [Pa], rows and columns the columns of F one below the other; `projected`: made positive
  /// semidefinite.
  Matrix9 (*stiffness)(const Lame&, const Eigen::Matrix3d& f, bool projected) = nullptr;
  /// Of laws whose points depend on each other, with `energies` and `stresses`; those of single points are
  /// then of a cell that deforms alike everywhere. `projected`: `own` is positive semidefinite, as `shared`
  /// is.
  void (*stiffnesses)(const Lame&, const PointMatrices& f, bool projected,
                      CellStiffness& stiffness) = nullptr;
};

/// All laws, in the order of reference/CMakeLists.txt.
const std::vector<SolidLaw>& solid_laws();

// Those that are what others are in a cell that deforms alike everywhere.
SolidLaw linear();
SolidLaw corotational();

}  // namespace mss

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
};
Lame lame_constants(const ElasticConstants& material);

/// At the eight Gauss points of a cell.
using PointMatrices = std::array<Eigen::Matrix3d, 8>;

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
  /// The energies' sum and the stresses at a cell's Gauss points, where they are found faster together;
  /// nullptr: one by one.
  double (*energies)(const Lame&, const PointMatrices& f) = nullptr;
  void (*stresses)(const Lame&, const PointMatrices& f, PointMatrices& stress) = nullptr;
  /// dP/dF [Pa], rows and columns the columns of F one below the other; `projected`: made positive
  /// semidefinite.
  Matrix9 (*stiffness)(const Lame&, const Eigen::Matrix3d& f, bool projected) = nullptr;
};

/// All laws, in the order of reference/CMakeLists.txt.
const std::vector<SolidLaw>& solid_laws();

}  // namespace mss

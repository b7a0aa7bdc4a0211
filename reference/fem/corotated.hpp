#pragma once

#include "reference/fem/solid_law.hpp"

namespace mss {

/// The rotation R of F = R S, S symmetric; of an inverted F that of principal_frame().
Eigen::Matrix3d rotation_of(const Eigen::Matrix3d& f);

/// The same at all points of a cell, side by side.
PointMatrices rotations_of(const PointMatrices& f);

/// theta = tr(R^T F) - 3, the sum of principal stretches less 3; its derivative is R.
inline double dilatation(const Eigen::Matrix3d& f, const Eigen::Matrix3d& rotation) {
  return rotation.cwiseProduct(f).sum() - 3;
}

/// P = 2 mu (F - R) + (constant + slope theta) R, as corotated elasticity has it.
struct CorotatedStress {
  double mu = 0;
  double constant = 0;  ///< [Pa]
  double slope = 0;     ///< [Pa]

  Eigen::Matrix3d at(const Eigen::Matrix3d& f, const Eigen::Matrix3d& rotation) const {
    return 2 * mu * (f - rotation) + (constant + slope * dilatation(f, rotation)) * rotation;
  }
  /// dP/dF; `projected`: made positive semidefinite, for slopes of -2/3 mu or more.
  Matrix9 stiffness(const Eigen::Matrix3d& f, bool projected) const;
};

}  // namespace mss

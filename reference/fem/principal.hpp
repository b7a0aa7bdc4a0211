#pragma once

#include "core/base/field.hpp"
#include "reference/fem/solid_law.hpp"

namespace mss {

/// F = U diag(stretches) V^T with rotations U and V; the last stretch is negative where F is inverted.
struct PrincipalFrame {
  Eigen::Matrix3d u, v;
  Vec3 stretches;
};
PrincipalFrame principal_frame(const Eigen::Matrix3d& f);

/// Derivatives of an energy that depends on the principal stretches s alone. Pair k is the two other axes i
/// and j; with g the gradient, differences are (g_i - g_j) / (s_i - s_j), sums (g_i + g_j) / (s_i + s_j),
/// written so that they stay finite where their denominators vanish.
struct PrincipalStiffness {
  Eigen::Matrix3d hessian;
  Vec3 differences;
  Vec3 sums;
};

/// dP/dF from these: U e_i e_i^T V^T span three of its eigenvectors, U (e_i e_j^T +- e_j e_i^T) V^T are the
/// other six (Smith, de Goes and Kim, 2019). Projected: each eigenvalue at least 0.
Matrix9 stiffness_matrix(const PrincipalFrame& frame, const PrincipalStiffness& principal, bool projected);

}  // namespace mss

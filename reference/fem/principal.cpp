#include "reference/fem/principal.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace mss {

using Eigen::Matrix3d;

PrincipalFrame principal_frame(const Matrix3d& f) {
  if (!f.allFinite())
    return {f, Matrix3d::Identity(), Vec3::Ones()};  // whatever follows is not finite either
  const Eigen::JacobiSVD<Matrix3d> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
  PrincipalFrame frame{svd.matrixU(), svd.matrixV(), svd.singularValues()};
  for (Matrix3d* rotation : {&frame.u, &frame.v})
    if (rotation->determinant() < 0) {
      rotation->col(2) *= -1;
      frame.stretches[2] *= -1;
    }
  return frame;
}

Matrix9 stiffness_matrix(const PrincipalFrame& frame, const PrincipalStiffness& principal, bool projected) {
  const auto as_vector = [](const Matrix3d& m) {
    return Eigen::Matrix<double, 9, 1>(Eigen::Map<const Eigen::Matrix<double, 9, 1>>(m.data()));
  };
  const auto value = [&](double eigenvalue) { return projected ? std::max(0.0, eigenvalue) : eigenvalue; };
  Matrix3d hessian = principal.hessian;
  if (projected) {
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(hessian);
    hessian = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() *
              eigen.eigenvectors().transpose();
  }
  Eigen::Matrix<double, 9, 3> scalings;
  for (int i = 0; i < 3; ++i) scalings.col(i) = as_vector(frame.u.col(i) * frame.v.col(i).transpose());
  Matrix9 d = scalings * hessian * scalings.transpose();
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const Matrix3d ij = frame.u.col(i) * frame.v.col(j).transpose(),
                   ji = frame.u.col(j) * frame.v.col(i).transpose();
    const auto flip = as_vector((ij + ji) / std::sqrt(2)), twist = as_vector((ij - ji) / std::sqrt(2));
    d += value(principal.differences[k]) * flip * flip.transpose() +
         value(principal.sums[k]) * twist * twist.transpose();
  }
  return d;
}

}  // namespace mss

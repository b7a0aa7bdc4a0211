// Corotated linear elasticity (Sifakis and Barbic, 2012, 3.4): energy mu |F - R|^2 + lambda/2 tr(R^T F - I)^2
// with R the rotation of F. In principal stretches s: mu sum (s - 1)^2 + lambda/2 (sum s - 3)^2.
#include <cmath>

#include "reference/fem/principal.hpp"

namespace mss {

namespace {

using Eigen::Matrix3d;

Vec3 gradient(const Lame& m, const Vec3& s) {
  return 2 * m.mu * (s - Vec3::Ones()) + m.lambda * (s.sum() - 3) * Vec3::Ones();
}

double energy(const Lame& m, const Matrix3d& f) {
  const Vec3 s = principal_frame(f).stretches;
  return m.mu * (s - Vec3::Ones()).squaredNorm() + m.lambda / 2 * (s.sum() - 3) * (s.sum() - 3);
}

Matrix3d stress(const Lame& m, const Matrix3d& f) {
  const PrincipalFrame frame = principal_frame(f);
  return frame.u * gradient(m, frame.stretches).asDiagonal() * frame.v.transpose();
}

/// Where two stretches sum to zero the rotation is undefined, and so is its derivative.
Matrix9 stiffness(const Lame& m, const Matrix3d& f, bool projected) {
  const PrincipalFrame frame = principal_frame(f);
  const Vec3& s = frame.stretches;
  PrincipalStiffness p{
      2 * m.mu * Matrix3d::Identity() + m.lambda * Matrix3d::Ones(), Vec3::Constant(2 * m.mu), {}};
  for (int k = 0; k < 3; ++k) {
    const double sum = s[(k + 1) % 3] + s[(k + 2) % 3];
    const double divisor = std::abs(sum) > 1e-9 ? sum : std::copysign(1e-9, sum);
    p.sums[k] = 2 * m.mu + (2 * m.lambda * (s.sum() - 3) - 4 * m.mu) / divisor;
  }
  return stiffness_matrix(frame, p, projected);
}

}  // namespace

SolidLaw corotational() {
  return {.name = "corotational",
          .summary = "finite elements, linear elasticity in a frame that turns with each point",
          .energy = energy,
          .stress = stress,
          .stiffness = stiffness};
}

}  // namespace mss

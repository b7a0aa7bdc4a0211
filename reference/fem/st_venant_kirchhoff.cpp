// St. Venant-Kirchhoff (Sifakis and Barbic, 2012, 3.3): energy mu E:E + lambda/2 tr(E)^2 of Green's strain
// E = (F^T F - I) / 2. In principal stretches s: mu/4 sum (s^2 - 1)^2 + lambda/8 (sum s^2 - 3)^2.
#include "reference/fem/principal.hpp"

namespace mss {

namespace {

using Eigen::Matrix3d;

Matrix3d strain(const Matrix3d& f) { return (f.transpose() * f - Matrix3d::Identity()) / 2; }

double energy(const Lame& m, const Matrix3d& f) {
  const Matrix3d e = strain(f);
  return m.mu * e.squaredNorm() + m.lambda / 2 * e.trace() * e.trace();
}

Matrix3d stress(const Lame& m, const Matrix3d& f) {
  const Matrix3d e = strain(f);
  return f * (2 * m.mu * e + m.lambda * e.trace() * Matrix3d::Identity());
}

/// g_i = s_i (mu (s_i^2 - 1) + lambda/2 (sum s^2 - 3)).
Matrix9 stiffness(const Lame& m, const Matrix3d& f, bool projected) {
  const PrincipalFrame frame = principal_frame(f);
  const Vec3& s = frame.stretches;
  const double pressure = m.lambda / 2 * (s.squaredNorm() - 3);
  PrincipalStiffness p{m.lambda * s * s.transpose(), {}, {}};
  for (int k = 0; k < 3; ++k) {
    const double a = s[(k + 1) % 3], b = s[(k + 2) % 3];
    p.hessian(k, k) += m.mu * (3 * s[k] * s[k] - 1) + pressure;
    p.differences[k] = m.mu * (a * a + a * b + b * b - 1) + pressure;
    p.sums[k] = m.mu * (a * a - a * b + b * b - 1) + pressure;
  }
  return stiffness_matrix(frame, p, projected);
}

}  // namespace

SolidLaw st_venant_kirchhoff() {
  return {.name = "st_venant_kirchhoff",
          .summary = "finite elements, linear in Green's strain: exact in rotations, soft in compression",
          .energy = energy,
          .stress = stress,
          .stiffness = stiffness};
}

}  // namespace mss

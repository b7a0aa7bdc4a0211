// Linear elasticity: energy mu e:e + lambda/2 tr(e)^2 of the small strain e = sym(F) - I.
#include "reference/fem/solid_law.hpp"

namespace mss {

namespace {

using Eigen::Matrix3d;

Matrix3d strain(const Matrix3d& f) { return (f + f.transpose()) / 2 - Matrix3d::Identity(); }

double energy(const Lame& m, const Matrix3d& f) {
  const Matrix3d e = strain(f);
  return m.mu * e.squaredNorm() + m.lambda / 2 * e.trace() * e.trace();
}

Matrix3d stress(const Lame& m, const Matrix3d& f) {
  const Matrix3d e = strain(f);
  return 2 * m.mu * e + m.lambda * e.trace() * Matrix3d::Identity();
}

/// Constant, and never indefinite.
Matrix9 stiffness(const Lame& m, const Matrix3d&, bool) {
  Matrix9 d = Matrix9::Zero();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      d(i + 3 * j, i + 3 * j) += m.mu;
      d(i + 3 * j, j + 3 * i) += m.mu;
      d(i + 3 * i, j + 3 * j) += m.lambda;
    }
  return d;
}

}  // namespace

SolidLaw linear() {
  return {.name = "linear",
          .summary = "finite elements, linear elasticity: for small rotations only",
          .small_rotations = true,
          .energy = energy,
          .stress = stress,
          .stiffness = stiffness};
}

}  // namespace mss

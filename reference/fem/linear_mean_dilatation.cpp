// Linear elasticity whose change of volume tr(e) is averaged over each cell: the sum over its points of
// mu (e:e - tr(e)^2 / 3) + kappa/2 mean(tr(e))^2 with kappa = lambda + 2/3 mu. The B-bar method: T. J. R.
// Hughes, Int. J. Numer. Meth. Eng. 15 (1980) 1413; see corotational_mean_dilatation.cpp.
#include "reference/fem/solid_law.hpp"

namespace mss {

namespace {

using Eigen::Matrix3d;

double bulk_modulus(const Lame& m) { return m.lambda + 2 * m.mu / 3; }

Matrix3d strain(const Matrix3d& f) { return (f + f.transpose()) / 2 - Matrix3d::Identity(); }

double mean_dilatation(const PointMatrices& f) {
  double sum = 0;
  for (const Matrix3d& at_point : f) sum += at_point.trace() - 3;
  return sum / double(f.size());
}

double energies(const Lame& m, const PointMatrices& f) {
  const double mean = mean_dilatation(f);
  double sum = 0;
  for (const Matrix3d& at_point : f) {
    const Matrix3d e = strain(at_point);
    sum += m.mu * (e.squaredNorm() - e.trace() * e.trace() / 3) + bulk_modulus(m) / 2 * mean * mean;
  }
  return sum;
}

void stresses(const Lame& m, const PointMatrices& f, PointMatrices& stress) {
  const double pressure = bulk_modulus(m) * mean_dilatation(f);
  for (std::size_t p = 0; p < f.size(); ++p) {
    const Matrix3d e = strain(f[p]);
    stress[p] = 2 * m.mu * e + (pressure - 2 * m.mu / 3 * e.trace()) * Matrix3d::Identity();
  }
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

void stiffnesses(const Lame& m, const PointMatrices& f, bool projected, CellStiffness& of_cell) {
  of_cell.shared = bulk_modulus(m);
  of_cell.axes.fill(Matrix3d::Identity());
  of_cell.own.fill(stiffness({m.mu, -2 * m.mu / 3}, f[0], projected));
}

// Of a cell that deforms alike everywhere.

double energy(const Lame& m, const Matrix3d& f) {
  const Matrix3d e = strain(f);
  return m.mu * e.squaredNorm() + m.lambda / 2 * e.trace() * e.trace();
}

Matrix3d stress(const Lame& m, const Matrix3d& f) {
  const Matrix3d e = strain(f);
  return 2 * m.mu * e + m.lambda * e.trace() * Matrix3d::Identity();
}

}  // namespace

SolidLaw linear_mean_dilatation() {
  return {.name = "linear_mean_dilatation",
          .summary = "as linear, the change of volume averaged over each cell: does not lock",
          .small_rotations = true,
          .energy = energy,
          .stress = stress,
          .energies = energies,
          .stresses = stresses,
          .stiffness = stiffness,
          .stiffnesses = stiffnesses};
}

}  // namespace mss

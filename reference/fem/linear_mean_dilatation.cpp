// Linear elasticity whose change of volume tr(e) is averaged over each cell: the sum over its points of
// mu (e:e - tr(e)^2 / 3) + kappa/2 mean(tr(e))^2 with kappa = lambda + 2/3 mu. The B-bar method: T. J. R.
// Hughes, Int. J. Numer. Meth. Eng. 15 (1980) 1413; see corotational_mean_dilatation.cpp.
#include "reference/fem/solid_law.hpp"

namespace mss {

namespace {

using Eigen::Matrix3d;

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
    sum += m.mu * (e.squaredNorm() - e.trace() * e.trace() / 3) + m.bulk_modulus() / 2 * mean * mean;
  }
  return sum;
}

void stresses(const Lame& m, const PointMatrices& f, PointMatrices& stress) {
  const double pressure = m.bulk_modulus() * mean_dilatation(f);
  for (std::size_t p = 0; p < f.size(); ++p) {
    const Matrix3d e = strain(f[p]);
    stress[p] = 2 * m.mu * e + (pressure - 2 * m.mu / 3 * e.trace()) * Matrix3d::Identity();
  }
}

void stiffnesses(const Lame& m, const PointMatrices& f, bool projected, CellStiffness& of_cell) {
  static const auto stiffness = linear().stiffness;
  of_cell.shared = m.bulk_modulus();
  of_cell.axes.fill(Matrix3d::Identity());
  of_cell.own.fill(stiffness({m.mu, -2 * m.mu / 3}, f[0], projected));
}

}  // namespace

SolidLaw linear_mean_dilatation() {
  SolidLaw law = linear();
  law.name = "linear_mean_dilatation";
  law.summary = "as linear, the change of volume averaged over each cell: does not lock";
  law.energies = energies;
  law.stresses = stresses;
  law.stiffnesses = stiffnesses;
  return law;
}

}  // namespace mss

// Corotated linear elasticity (Sifakis and Barbic, 2012, 3.4): energy mu |F - R|^2 + lambda/2 tr(R^T F - I)^2
// with R the rotation of F. In principal stretches s: mu sum (s - 1)^2 + lambda/2 (sum s - 3)^2.
#include "reference/fem/corotated.hpp"

namespace mss {

namespace {

using Eigen::Matrix3d;

CorotatedStress corotated(const Lame& m) { return {.mu = m.mu, .slope = m.lambda}; }

double energy(const Lame& m, const Matrix3d& f, const Matrix3d& r) {
  const double theta = dilatation(f, r);
  return m.mu * (f - r).squaredNorm() + m.lambda / 2 * theta * theta;
}
double energy(const Lame& m, const Matrix3d& f) { return energy(m, f, rotation_of(f)); }

Matrix3d stress(const Lame& m, const Matrix3d& f) { return corotated(m).at(f, rotation_of(f)); }

double energies(const Lame& m, const PointMatrices& f) {
  const PointMatrices rotations = rotations_of(f);
  double sum = 0;
  for (std::size_t p = 0; p < f.size(); ++p) sum += energy(m, f[p], rotations[p]);
  return sum;
}

void stresses(const Lame& m, const PointMatrices& f, PointMatrices& stress) {
  const PointMatrices rotations = rotations_of(f);
  for (std::size_t p = 0; p < f.size(); ++p) stress[p] = corotated(m).at(f[p], rotations[p]);
}

Matrix9 stiffness(const Lame& m, const Matrix3d& f, bool projected) {
  return corotated(m).stiffness(f, projected);
}

}  // namespace

SolidLaw corotational() {
  return {.name = "corotational",
          .summary = "finite elements, linear elasticity in a frame that turns with each point",
          .energy = energy,
          .stress = stress,
          .energies = energies,
          .stresses = stresses,
          .stiffness = stiffness};
}

}  // namespace mss

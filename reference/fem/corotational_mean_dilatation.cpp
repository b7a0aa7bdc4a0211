// Corotated linear elasticity whose change of volume is averaged over each cell, in place of
// theta = tr(R^T F) - 3 at its points: the sum over points of mu (|F - R|^2 - theta^2 / 3) + kappa/2
// mean(theta)^2 with kappa = lambda + 2/3 mu. Eight points demand eight changes of volume of a trilinear
// cell, more than it can meet where kappa is large, and so it locks; one it meets. The mean dilatation of
// Nagtegaal, Parks and Rice (1974), for small strains the B-bar method of Hughes, Int. J. Numer. Meth. Eng.
// 15 (1980) 1413.
#include "reference/fem/corotated.hpp"

namespace mss {

namespace {

using Eigen::Matrix3d;

double bulk_modulus(const Lame& m) { return m.lambda + 2 * m.mu / 3; }

double mean_dilatation(const PointMatrices& f, const PointMatrices& rotations) {
  double sum = 0;
  for (std::size_t p = 0; p < f.size(); ++p) sum += dilatation(f[p], rotations[p]);
  return sum / double(f.size());
}

/// Of a point where the cell's mean dilatation is given.
CorotatedStress corotated(const Lame& m, double mean) {
  return {.mu = m.mu, .constant = bulk_modulus(m) * mean, .slope = -2 * m.mu / 3};
}

double energies(const Lame& m, const PointMatrices& f) {
  const PointMatrices rotations = rotations_of(f);
  const double mean = mean_dilatation(f, rotations);
  double sum = 0;
  for (std::size_t p = 0; p < f.size(); ++p) {
    const double theta = dilatation(f[p], rotations[p]);
    sum +=
        m.mu * ((f[p] - rotations[p]).squaredNorm() - theta * theta / 3) + bulk_modulus(m) / 2 * mean * mean;
  }
  return sum;
}

void stresses(const Lame& m, const PointMatrices& f, PointMatrices& stress) {
  const PointMatrices rotations = rotations_of(f);
  const CorotatedStress law = corotated(m, mean_dilatation(f, rotations));
  for (std::size_t p = 0; p < f.size(); ++p) stress[p] = law.at(f[p], rotations[p]);
}

void stiffnesses(const Lame& m, const PointMatrices& f, bool projected, CellStiffness& stiffness) {
  stiffness.axes = rotations_of(f);
  stiffness.shared = bulk_modulus(m);
  const CorotatedStress law = corotated(m, mean_dilatation(f, stiffness.axes));
  for (std::size_t p = 0; p < f.size(); ++p) stiffness.own[p] = law.stiffness(f[p], projected);
}

// Of a cell that deforms alike everywhere: then all is as if each point had a dilatation of its own.

double energy(const Lame& m, const Matrix3d& f) {
  const Matrix3d r = rotation_of(f);
  const double theta = dilatation(f, r);
  return m.mu * (f - r).squaredNorm() + m.lambda / 2 * theta * theta;
}

CorotatedStress corotated(const Lame& m) { return {.mu = m.mu, .slope = m.lambda}; }

Matrix3d stress(const Lame& m, const Matrix3d& f) { return corotated(m).at(f, rotation_of(f)); }

Matrix9 stiffness(const Lame& m, const Matrix3d& f, bool projected) {
  return corotated(m).stiffness(f, projected);
}

}  // namespace

SolidLaw corotational_mean_dilatation() {
  return {.name = "corotational_mean_dilatation",
          .summary = "as corotational, the change of volume averaged over each cell: does not lock",
          .energy = energy,
          .stress = stress,
          .energies = energies,
          .stresses = stresses,
          .stiffness = stiffness,
          .stiffnesses = stiffnesses};
}

}  // namespace mss

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

double mean_dilatation(const PointMatrices& f, const PointMatrices& rotations) {
  double sum = 0;
  for (std::size_t p = 0; p < f.size(); ++p) sum += dilatation(f[p], rotations[p]);
  return sum / double(f.size());
}

/// Of a point where the cell's mean dilatation is given.
CorotatedStress corotated(const Lame& m, double mean) {
  return {.mu = m.mu, .constant = m.bulk_modulus() * mean, .slope = -2 * m.mu / 3};
}

double energies(const Lame& m, const PointMatrices& f) {
  const PointMatrices rotations = rotations_of(f);
  const double mean = mean_dilatation(f, rotations);
  double sum = 0;
  for (std::size_t p = 0; p < f.size(); ++p) {
    const double theta = dilatation(f[p], rotations[p]);
    sum +=
        m.mu * ((f[p] - rotations[p]).squaredNorm() - theta * theta / 3) + m.bulk_modulus() / 2 * mean * mean;
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
  stiffness.shared = m.bulk_modulus();
  const CorotatedStress law = corotated(m, mean_dilatation(f, stiffness.axes));
  for (std::size_t p = 0; p < f.size(); ++p) stiffness.own[p] = law.stiffness(f[p], projected);
}

}  // namespace

SolidLaw corotational_mean_dilatation() {
  SolidLaw law = corotational();
  law.name = "corotational_mean_dilatation";
  law.summary = "as corotational, the change of volume averaged over each cell: does not lock";
  law.energies = energies;
  law.stresses = stresses;
  law.stiffnesses = stiffnesses;
  return law;
}

}  // namespace mss

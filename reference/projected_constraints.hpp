#pragma once

#include <vector>

#include "core/body/body.hpp"

namespace mss::reference {

/// Compliant constraints as the paper on XPBD has them, one after the other, in plain loops: the oracle of
/// core/constraint_projection. Cells in the order of colours (parity of i + 2 parity of j + 4 parity of k)
/// and then of sites; of each its volume, then its springs in an order of its own.
class ProjectedConstraints {
 public:
  /// `inverse_mass` by site [1/kg], 0 where a particle is held. The body must outlive it.
  ProjectedConstraints(const Body& body, std::vector<double> inverse_mass, double dt);

  /// One pass over all constraints: x_n and the displacements u of the step, which it changes. Multipliers
  /// are kept from one pass to the next until forget().
  void project(const Field<double>& x, Field<double>& u);
  void forget();

 private:
  struct Spring {
    std::ptrdiff_t a, b;
    double stiffness, damping, rest_length, multiplier;
  };
  struct Cell {
    std::ptrdiff_t site;
    double volume_stiffness, multiplier;
    std::vector<Spring> springs;
  };
  void project_volume(Cell& cell, const Field<double>& x, Field<double>& u) const;
  void project_spring(Spring& spring, const Field<double>& x, Field<double>& u) const;

  const Body& body_;
  std::vector<double> inverse_mass_;
  double dt_;
  std::vector<Cell> cells_;
};

}  // namespace mss::reference

// The law of Cauchy and Born, by which a lattice at large strain is a continuum, against a lattice that knows
// nothing of it.
#include <array>
#include <cmath>
#include <utility>

#include "experiments/studies/lattice/lattice.hpp"
#include "reference/large_strain.hpp"
#include "reference/relaxed_lattice.hpp"

namespace mss::studies::lattice {

namespace {

constexpr double law_cell = 1;       ///< edge of a cell [m]
constexpr double displaced = 0.05;   ///< of a cell: how far from F x inner particles begin, at most
constexpr double uniform_to = 1e-6;  ///< cells: beyond, the lattice has not deformed alike everywhere

std::vector<std::pair<std::string, Eigen::Matrix3d>> law_gradients(const SpringConstants& springs) {
  using Kind = StrainPath::Kind;
  Eigen::Matrix3d general;
  general << 1.3, 0.2, -0.1, -0.3, 0.8, 0.15, 0.1, 0.05, 1.1;
  const auto path = [&](Kind kind, double strain) {
    return strained_gradient(springs, law_cell, {kind}, strain);
  };
  return {{"tension 0.15", path(Kind::tension, 0.15)},
          {"compression 0.25", path(Kind::compression, 0.25)},
          {"shear 0.3", path(Kind::shear, 0.3)},
          {"stretched, sheared and turned", general}};
}

}  // namespace

Table empty_law() {
  return Table({{"poisson"},
                {"face_share"},
                {"deformation"},
                {"cells"},
                {"energy_off"},
                {"stress_off"},
                {"moved"},
                {"status"}});
}

void add_law(const LatticeMaterial& material, int cells, Table& rows) {
  const SpringConstants springs = material.springs();
  const reference::CauchyBorn law(springs, law_cell);
  for (const auto& [name, F] : law_gradients(springs)) {
    const auto [energy, moved, at_rest] = reference::relax_lattice(springs, law_cell, cells, F, displaced);
    const Eigen::Matrix3d stress = reference::relaxed_stress(springs, law_cell, cells, F, displaced);
    rows.add({material.poisson, material.face_share, name, cells, energy / law.energy(F) - 1,
              (stress - law.stress(F)).norm() / law.stress(F).norm(), moved,
              std::string(!at_rest             ? "not at rest"
                          : moved > uniform_to ? "left uniform strain"
                                               : "ok")});
  }
}

}  // namespace mss::studies::lattice

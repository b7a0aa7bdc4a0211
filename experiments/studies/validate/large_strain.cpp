// A bar of springs stretched and compressed far, its sides free, beside the laws of large strains: that of
// Cauchy and Born, which it has to meet because its cells deform alike, and those that it does not stand for.
#include "reference/large_strain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/springs/spring_system.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/simulation/equilibrium.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/studies/validate/validate.hpp"

namespace mss::studies::validate {

namespace {

constexpr int cells = 2;         ///< per edge of the cube; any number does
constexpr double poisson = 0.3;  ///< of the material

/// Between two plates without friction; two planes of symmetry hold the rigid motions.
Environment between_plates(double strain) {
  const Vec3 one = Vec3::Ones();
  Environment e;
  for (int axis = 0; axis < 3; ++axis) {
    Hold hold{.box = {Vec3::Zero(), one}, .axes = {axis == 0, axis == 1, axis == 2}};
    hold.box.upper[axis] = 0;
    e.holds.push_back(hold);
  }
  e.holds.push_back(
      {.box = {Vec3::UnitX(), one}, .axes = {true, false, false}, .displacement = {strain, 0, 0}});
  return e;
}

struct LatticeResult {
  Status status;
  double lateral, stress;
};

/// Equilibrium of a cube of 1 m, sought from its shape without any lateral strain.
LatticeResult lattice_result(const ValidationConfig& config, const SpringConstants& springs, double strain) {
  const Body body({.voxels = VoxelGrid::box(cells, cells, cells),
                   .cell_size = 1.0 / cells,
                   .density = config.density,
                   .springs = springs});
  SpringSystem<double> system(body, between_plates(strain), {.threads = config.threads});
  const auto [status, state] = find_equilibrium(system, [&](const Vec3& rest) -> Vec3 {
    return {(1 + strain) * rest[0], rest[1], rest[2]};
  });
  if (status != Status::ok) return {status, no_value, no_value};
  Field<double> force(system.size());
  system.force(1, state.x, state.v, force);
  double stress = 0;
  for (const std::ptrdiff_t site : body.select(Vec3::UnitX(), Vec3::Ones())) stress -= force.at(site)[0];
  const std::ptrdiff_t corner = body.select(Vec3::Ones(), Vec3::Ones()).front();
  return {status, state.x.at(corner)[1], stress};
}

}  // namespace

Table empty_strains() {
  return Table({{"springs"},
                {"strain"},
                {"cells"},
                {"lateral_stretch"},
                {"stress", "Pa"},
                {"cauchy_born_lateral_stretch"},
                {"cauchy_born_stress", "Pa"},
                {"difference"},
                {"neo_hookean_stress", "Pa"},
                {"st_venant_kirchhoff_stress", "Pa"},
                {"over_neo_hookean"},
                {"status"}});
}

bool measure_large_strain(const ValidationConfig& config, const Progress& progress, Table& table) {
  const ElasticConstants material{config.young, poisson};
  const reference::NeoHookean neo_hookean(material);
  const reference::StVenantKirchhoff st_venant_kirchhoff(material);
  for (const ValidationModel& model : config.models)
    for (const double strain : config.strains) {
      if (model.model != spring_model) continue;
      if (progress.stopped()) return false;
      const SpringConstants springs = model.springs(material, 1.0 / cells);
      const auto [status, lateral, stress] = lattice_result(config, springs, strain);
      const auto expected = uniaxial_state(reference::CauchyBorn(springs, 1.0 / cells), 1 + strain);
      const double by_neo_hookean = uniaxial_state(neo_hookean, 1 + strain).stress;
      table.add(
          {model.name, strain, cells, lateral, stress, expected.lateral, expected.stress,
           stress / expected.stress - 1, by_neo_hookean,
           uniaxial_state(st_venant_kirchhoff, 1 + strain).stress, expected.stress / by_neo_hookean,
           std::string(std::isfinite(expected.stress) ? to_string(status) : "no state of uniform strain")});
    }
  return true;
}

std::string large_strain_text(const Table& strains) {
  double difference = 0, least = 1, most = 1;
  for (std::size_t r = 0; r < strains.size(); ++r) {
    if (strains.text(r, "status") != "ok") continue;
    difference = std::max(difference, std::abs(strains.number(r, "difference")));
    if (strains.text(r, "springs") == "thesis's springs") continue;
    least = std::min(least, strains.number(r, "over_neo_hookean"));
    most = std::max(most, strains.number(r, "over_neo_hookean"));
  }
  return strains.size() == 0 ? ""
                             : fmt::format(
                                   "large strain: the lattice is its Cauchy-Born limit to {:.0e}; calibrated "
                                   "springs carry {:.2f} "
                                   "to {:.2f} of a neo-Hookean solid's stress\n",
                                   difference, least, most);
}

}  // namespace mss::studies::validate

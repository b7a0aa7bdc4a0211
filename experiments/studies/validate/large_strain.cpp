// A bar of springs stretched and compressed far, its sides free, beside the laws of large strains: that of
// Cauchy and Born, which it has to meet because its cells deform alike, and those that it does not stand for.
#include "reference/large_strain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/body/phonons.hpp"
#include "core/springs/spring_system.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/simulation/equilibrium.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/studies/validate/validate.hpp"

namespace mss::studies::validate {

namespace {

constexpr int cells = 2;  ///< per edge of the cube; any number does

/// Springs of a material whose bar is stretched.
struct StrainedSprings {
  std::string name;
  double poisson;
  std::function<SpringConstants(const ElasticConstants&, double cell_size)> springs;
};

/// All models of springs with nu = 0.3, and what gives way in tension: nu below 1/4.
std::vector<StrainedSprings> strained_springs(const ValidationConfig& config) {
  std::vector<StrainedSprings> all;
  for (const ValidationModel& model : config.models)
    if (model.model == spring_model) all.push_back({model.name, 0.3, model.springs});
  for (const double poisson : {-0.2, 0.0})
    all.push_back({fmt::format("springs, t = 0.5, nu = {:g}", poisson), poisson,
                   [](const ElasticConstants& m, double h) { return calibrate(m, h, 0.5); }});
  return all;
}

/// What the lattice's waves say about a bar of uniform strain with these stretches.
bool is_stable(const SpringConstants& springs, double stretch, double lateral) {
  const Eigen::Matrix3d F = Vec3(stretch, lateral, lateral).asDiagonal();
  return softest_wave(springs, 1.0 / cells, F).stiffness > 0;
}

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
                {"poisson"},
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
  for (const auto& [name, poisson, make_springs] : strained_springs(config))
    for (const double strain : config.strains) {
      if (progress.stopped()) return false;
      const ElasticConstants material{config.young, poisson};
      const SpringConstants springs = make_springs(material, 1.0 / cells);
      const auto expected = uniaxial_state(reference::CauchyBorn(springs, 1.0 / cells), 1 + strain);
      const bool exists = std::isfinite(expected.stress);
      const auto [status, lateral, stress] =
          exists ? lattice_result(config, springs, strain) : LatticeResult{Status::ok, no_value, no_value};
      const double by_neo_hookean = uniaxial_state(reference::NeoHookean(material), 1 + strain).stress;
      table.add({name, poisson, strain, cells, lateral, stress, expected.lateral, expected.stress,
                 stress / expected.stress - 1, by_neo_hookean,
                 uniaxial_state(reference::StVenantKirchhoff(material), 1 + strain).stress,
                 expected.stress / by_neo_hookean,
                 std::string(!exists                ? "no state of uniform strain"
                             : status != Status::ok ? to_string(status)
                             : !is_stable(springs, 1 + strain, expected.lateral) ? "lattice unstable"
                                                                                 : "ok")});
    }
  return true;
}

std::string large_strain_text(const Table& strains) {
  double difference = 0, least = 1, most = 1;
  for (std::size_t r = 0; r < strains.size(); ++r) {
    if (strains.text(r, "status") != "ok") continue;
    difference = std::max(difference, std::abs(strains.number(r, "difference")));
    if (strains.text(r, "springs") == "thesis's springs" || strains.number(r, "poisson") != 0.3) continue;
    least = std::min(least, strains.number(r, "over_neo_hookean"));
    most = std::max(most, strains.number(r, "over_neo_hookean"));
  }
  return strains.size() == 0
             ? ""
             : fmt::format(
                   "large strain: bodies of springs have the stress of their cells' law to {:.0e}; "
                   "calibrated springs, nu = 0.3, carry {:.2f} "
                   "to {:.2f} of a neo-Hookean solid's stress\n",
                   difference, least, most);
}

}  // namespace mss::studies::validate

// What the infinite lattice of calibrated springs is beyond its moduli: how fast waves of few cells travel,
// and at which strains it loses its stability; both from its dynamical matrix (core/body/phonons.hpp), and
// bodies stepped beside what that says. Waves are in waves.cpp, limits in limits.cpp, charts in chart.cpp.
#include "experiments/studies/lattice/lattice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace mss::studies::lattice {

namespace {

Json materials_of(const std::vector<LatticeMaterial>& materials) {
  Json all = Json::array();
  for (const LatticeMaterial& m : materials)
    all.push_back({{"poisson", m.poisson}, {"face_share", m.face_share}});
  return all;
}

Json configuration(const LatticeConfig& c) {
  return {{"dispersive", materials_of(c.dispersive)},
          {"wavelengths", c.wavelengths},
          {"directions", c.directions},
          {"standing_cells", c.standing_cells},
          {"strained", materials_of(c.strained)},
          {"stretched", materials_of(c.stretched)},
          {"stretched_cells", c.stretched_cells},
          {"relaxed", materials_of(c.relaxed)},
          {"relaxed_cells", c.relaxed_cells},
          {"sharing", "weighted"}};
}

constexpr const char* caption =
    "Plane waves in the infinite lattice of calibrated springs, from its dynamical matrix. Speeds: phase "
    "speeds over those of the continuum, sqrt((lambda + 2 mu) / rho) and sqrt(mu / rho), along edges, face "
    "and body diagonals, and the slowest and fastest over all directions. Of the two shear waves the slower "
    "and the faster have rows of their own. Standing waves of a cube between rollers, stepped by velocity "
    "Verlet, have the frequency of the lattice's to the error of the step. Limits: the smallest strain at "
    "which some wave of the lattice is not resisted, sought over the Brillouin zone, or free sides find no "
    "rest: tension and compression with free sides, and simple shear. Growth: a cube is strained less and "
    "more than its limit, disturbed by a millionth of a cell and stepped by velocity Verlet for the time "
    "that "
    "a shear wave takes to cross it a hundred times. Between rollers at all faces, which are mirrors, its "
    "motions are those waves of the lattice that fit; with free sides, beyond a limit at which sides give "
    "way, it begins where they were last at rest. Free surfaces are weaker than the lattice and give way "
    "before it. Outcome: stays, leaves (a thousand times the disturbance), explodes (numbers are not "
    "finite). Law: a cube's surface is moved with a gradient, its inner particles begin up to 5 percent of a "
    "cell beside, and relax by FIRE, as particles and springs of the thesis's Algorithm 1; energy, and "
    "stress "
    "as its slope by differences, beside those of the rule of Cauchy and Born.";

std::string summary(const LatticeTables& tables) {
  std::string lines;
  const Table& rows = tables.dispersion;
  for (const double cells : {8.0, 5.0})
    for (const WaveKind kind : wave_kinds) {
      const Table of_kind = rows.where("wave", to_string(kind))
                                .where("cells_per_wavelength", cells)
                                .where("poisson", 0.3)
                                .where("face_share", 0.5);
      double least = 2, most = 0;
      for (std::size_t r = 0; r < of_kind.size(); ++r) {
        least = std::min(least, of_kind.number(r, "speed_over_continuum"));
        most = std::max(most, of_kind.number(r, "speed_over_continuum"));
      }
      if (most > 0)
        lines += fmt::format(
            "nu = 0.3, t = 0.5, {:<13} {:g} cells a wavelength: speed {:.3f} to {:.3f} of the continuum's\n",
            to_string(kind), cells, least, most);
    }
  for (std::size_t r = 0; r < tables.limits.size(); ++r)
    if (std::isfinite(tables.limits.number(r, "strain")) &&
        tables.limits.text(r, "path") == StrainPath{}.name())
      lines += fmt::format("nu = {:g}, t = {:g}: unstable beyond a strain of {:.3f} in {}\n",
                           tables.limits.number(r, "poisson"), tables.limits.number(r, "face_share"),
                           tables.limits.number(r, "strain"), tables.limits.text(r, "path"));
  double energy = 0, stress = 0;
  for (std::size_t r = 0; r < tables.law.size(); ++r) {
    energy = std::max(energy, std::abs(tables.law.number(r, "energy_off")));
    stress = std::max(stress, tables.law.number(r, "stress_off"));
  }
  if (tables.law.size() > 0)
    lines += fmt::format("relaxed lattices: energy is Cauchy's and Born's to {:.0e}, stress to {:.0e}\n",
                         energy, stress);
  return lines;
}

ExperimentResult run_lattice(const ExperimentOptions& options, Progress& progress) {
  const LatticeConfig config = lattice_config(options);
  LatticeTables tables = measure_lattice(config, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  result.summary = summary(tables);
  result.tables = lattice_files(std::move(tables));
  return result;
}

/// Speeds, standing waves and limits; what grows is no baseline.
Table baseline_table(const BaselineOptions& options, Progress& progress) {
  LatticeConfig config = lattice_config({.quick = true});
  if (!options.quick) config.strained = lattice_config({}).strained;
  config.stretched.clear();
  config.relaxed.clear();
  const LatticeTables tables = measure_lattice(config, progress);
  Table rows({{"part"}, {"material"}, {"case"}, {"cells"}, {"value"}, {"status"}});
  const auto add = [&](const char* part, const Table& t, const std::vector<std::string>& named,
                       const char* cells, const char* value) {
    for (std::size_t r = 0; r < t.size(); ++r) {
      std::string name;
      for (const std::string& column : named) name += (name.empty() ? "" : " ") + t.text(r, column);
      rows.add({std::string(part), LatticeMaterial{t.number(r, "poisson"), t.number(r, "face_share")}.name(),
                name, *cells ? t.number(r, cells) : 0.0, t.number(r, value), t.text(r, "status")});
    }
  };
  add("speed", tables.dispersion, {"wave", "direction"}, "cells_per_wavelength", "speed_over_continuum");
  add("standing", tables.standing, {"wave", "direction"}, "cells", "frequency_over_predicted");
  add("limit", tables.limits, {"path"}, "", "strain");
  return rows;
}

}  // namespace

LatticeConfig lattice_config(const ExperimentOptions& options) {
  LatticeConfig config;
  config.wavelengths = options.quick ? std::vector<double>{4, 5, 8, 16}
                                     : std::vector<double>{3, 4, 5, 6, 8, 10, 12, 16, 24, 32};
  const std::vector<double> shares =
      options.quick ? std::vector<double>{0.5} : std::vector<double>{0, 0.25, 0.5, 0.75, 1};
  for (const double poisson : {0.3, 0.45})
    for (const double share : shares) config.dispersive.push_back({poisson, share});
  config.standing_cells = options.quick ? std::vector<int>{4} : std::vector<int>{4, 8};
  const std::vector<double> ratios =
      options.quick
          ? std::vector<double>{0, 0.3}
          : std::vector<double>{-0.3, -0.2, -0.1, 0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.49};
  for (const double poisson : ratios)
    for (const double share : options.quick ? std::vector<double>{0.5} : std::vector<double>{0.25, 0.5, 1})
      config.strained.push_back({poisson, share});
  config.stretched = {{0, 0.5}};
  if (!options.quick) config.stretched = {{-0.2, 0.5}, {0, 0.5}, {0.1, 0.5}, {0.3, 0.25}, {0.3, 0.5}};
  if (options.quick) config.stretched_cells = 8;
  config.relaxed = {{0.3, 0.5}};
  if (!options.quick) config.relaxed = {{0, 0.5}, {0.3, 0.25}, {0.3, 0.5}, {0.3, 1}, {0.45, 0.5}};
  if (options.quick) config.relaxed_cells = 3;
  return config;
}

LatticeTables measure_lattice(const LatticeConfig& config, Progress& progress) {
  LatticeTables tables{empty_dispersion(), empty_standing(), empty_limits(), empty_growth(), empty_law()};
  std::vector<std::function<void()>> parts;
  for (const LatticeMaterial& m : config.dispersive)
    parts.emplace_back([&] { add_dispersion(config, m, tables.dispersion); });
  for (const LatticeMaterial& m : config.dispersive)
    for (const int n : config.standing_cells)
      parts.emplace_back([&, n] { add_standing_waves(m, n, tables.standing); });
  for (const LatticeMaterial& m : config.strained) parts.emplace_back([&] { add_limits(m, tables.limits); });
  for (const LatticeMaterial& m : config.stretched)
    parts.emplace_back([&] { add_growth(m, config.stretched_cells, tables.growth); });
  for (const LatticeMaterial& m : config.relaxed)
    parts.emplace_back([&] { add_law(m, config.relaxed_cells, tables.law); });
  for (std::size_t i = 0; i < parts.size(); ++i) {
    progress.report(double(i) / double(parts.size()), "waves of a lattice");
    if (progress.stopped()) {
      tables.status = Status::interrupted;
      break;
    }
    parts[i]();
  }
  return tables;
}

std::vector<NamedTable> lattice_files(LatticeTables tables) {
  return {{"lattice", std::move(tables.dispersion)},
          {"lattice_standing", std::move(tables.standing)},
          {"lattice_limits", std::move(tables.limits)},
          {"lattice_growth", std::move(tables.growth)},
          {"lattice_law", std::move(tables.law)}};
}

ExperimentInfo experiment() {
  return {.name = "lattice",
          .under = "validate",
          .summary =
              "waves of the lattice of springs: their speed by direction, and the strains at which some grow",
          .run = run_lattice,
          .draw = draw_lattice,
          .baseline = {.keys = {"part", "material", "case", "cells"},
                       .rules = {{"value", 1e-6, 2e-4}},
                       .table = baseline_table}};
}

}  // namespace mss::studies::lattice

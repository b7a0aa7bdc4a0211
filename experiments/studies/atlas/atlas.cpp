// Stability maps: the outcome of a stretched cube that is released, over step and damping, Poisson's ratio,
// initial strain, resolution; finer where the outcome changes.
#include "experiments/studies/atlas/atlas.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace mss::studies::atlas {

namespace {

constexpr const char* caption =
    "A cube of 1 m is stretched along x, with superposed fast motions a hundredth as large, and released; "
    "calibrated springs, face share t = 0.5. Unless varied it has 3 cells per edge, nu = 0.3, an initial "
    "strain of 0.01, and a damping ratio of 0.05 in every spring. Each run lasts two periods of the slowest "
    "vibration and at least 512 steps; with methods that have no limit 1.125 periods and at least 48 steps, "
    "with "
    "methods that choose their own steps two periods and at least 4 intervals of length dt. Loses energy: "
    "after one period less than half of the energy that a reference with small steps has then, and lower by "
    "at least a twentieth of the initial energy. Folds: a corner of a cell is inverted in one of 128 "
    "samples. "
    "Blows up: ten times the initial energy. Solver stalls: no solution is found. Too many steps: more than "
    "500 between two samples, one or a few dt apart. Refused: the method has no step for such a body, as "
    "xpbd and vbd for a negative volume stiffness (nu below 1/4). White: not tried. omega_max and the "
    "predicted limit are "
    "those of the body at rest: stretching stiffens springs. Instabilities that grow more slowly are "
    "measured "
    "by `mss stability`.";

Json configuration(const AtlasConfig& c) {
  Json parameters = Json::array();
  for (const AtlasParameter& parameter : c.parameters)
    parameters.push_back(
        {{"name", parameter.name}, {"values", parameter.values}, {"halvings", parameter.halvings}});
  return {
      {"parameters", parameters}, {"integrators", c.integrators}, {"finest", c.finest}, {"quick", c.quick}};
}

/// What the rows of limits say about one method.
struct StableRange {
  double least = std::numeric_limits<double>::infinity(), most = 0;  ///< dt omega_max
  std::set<std::string> next{};                                      ///< outcomes beyond, by name
  bool somewhere_none = false;                                       ///< a row without a stable step
};
StableRange stable_range(const Table& limits) {
  StableRange range;
  for (std::size_t r = 0; r < limits.size(); ++r) {
    range.next.insert(limits.text(r, "next_outcome"));
    const double to = limits.number(r, "stable_to");
    if (std::isnan(to)) {
      range.somewhere_none = true;
      continue;
    }
    range.least = std::min(range.least, to);
    range.most = std::max(range.most, to);
  }
  return range;
}

/// A line per method: up to which steps it is stable, and the outcomes beyond.
std::string summary(const Table& limits) {
  std::string lines;
  for (const std::string& integrator : limits.distinct("integrator")) {
    StableRange range = stable_range(limits.where("integrator", integrator));
    const bool to_the_end = range.next.erase(std::string(to_string(Outcome::stable))) > 0;
    lines += range.most == 0
                 ? fmt::format("{:<22} stable at no step tried", integrator)
                 : fmt::format("{:<22} stable to dt omega_max = {:.3g} to {:.3g}{}{}", integrator,
                               range.least, range.most, to_the_end ? ", in some rows the largest tried" : "",
                               range.somewhere_none ? ", in some rows at no step" : "");
    if (!range.next.empty()) lines += fmt::format("; then: {}", fmt::join(range.next, ", "));
    lines += "\n";
  }
  return lines;
}

ExperimentResult run_atlas(const ExperimentOptions& options, Progress& progress) {
  const AtlasConfig config = atlas_config(options);
  Journal journal = open_journal(options, configuration(config));
  AtlasTables tables = measure_atlas(config, options.processes, journal, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  result.summary = summary(tables.limits);
  result.tables = atlas_files(std::move(tables));
  return result;
}

/// A few rows at steps that are far from any change of outcome.
Table baseline_table(const BaselineOptions&, Progress& progress) {
  AtlasConfig config =
      atlas_config({.quick = true, .integrators = {"semi_implicit_euler", "rk4", "backward_euler"}});
  std::erase_if(config.parameters, [](const AtlasParameter& parameter) { return parameter.name != "ratio"; });
  config.finest = 2 * octave_parts;
  Journal journal;
  return measure_atlas(config, 1, journal, progress)
      .points.select({"integrator", "ratio", "dt_omega", "status"});
}

}  // namespace

AtlasConfig atlas_config(const ExperimentOptions& options) {
  AtlasConfig config{.parameters = {{"ratio",
                                     "damping ratio of every spring",
                                     {0, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2},
                                     1,
                                     [](AtlasBody& body, double value) { body.ratio = value; }},
                                    {"poisson",
                                     "Poisson's ratio",
                                     {0, 0.1, 0.2, 0.3, 0.4, 0.45, 0.49, 0.499},
                                     1,
                                     [](AtlasBody& body, double value) { body.poisson = value; }},
                                    {"strain",
                                     "initial strain",
                                     {-0.95, -0.8, -0.5, -0.2, 0.01, 0.2, 0.5, 1, 2, 3},
                                     1,
                                     [](AtlasBody& body, double value) { body.strain = value; }},
                                    {"cells",
                                     "cells per edge",
                                     {2, 3, 4, 5, 6},
                                     0,
                                     [](AtlasBody& body, double value) { body.cells = int(value); }}},
                     .integrators = moving_families(options.integrators),
                     .quick = options.quick};
  if (options.quick) {
    config.finest = octave_parts;
    config.parameters[0].values = {0, 0.05, 0.5, 2};
    config.parameters[1].values = {0, 0.25, 0.45};
    config.parameters[2].values = {-0.95, -0.5, 0.01, 1, 3};
    config.parameters[3].values = {2, 3};
    for (AtlasParameter& parameter : config.parameters) parameter.halvings = 0;
  }
  return config;
}

ExperimentInfo experiment() {
  return {.name = "atlas",
          .under = "stability",
          .summary = "maps of the outcome per integrator: step against damping, nu, strain, resolution",
          .accepts = {.integrators = moving_families, .processes = true},
          .run = run_atlas,
          .draw = draw_atlas,
          .baseline = {.keys = {"integrator", "ratio", "dt_omega"}, .rules = {}, .table = baseline_table}};
}

}  // namespace mss::studies::atlas

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

/// Held where the resolution varies, so that the material stays the same [Pa s]: of springs of 3 cells per
/// edge the damping ratio is then 0.03 to 0.07.
constexpr double material_viscosity = 50;

constexpr const char* caption =
    "A cube of 1 m is stretched along x, with superposed fast motions a hundredth as large, and released; "
    "calibrated springs, face share t = 0.5. Unless varied it has 3 cells per edge, nu = 0.3, an initial "
    "strain of 0.01, and a damping ratio of 0.05 in every spring; where the resolution varies a viscosity of "
    "50 Pa s. Each run lasts two periods of the slowest "
    "vibration and at least 512 steps, with methods that have a limit also 64 / (dt omega)^2 steps, at "
    "least 4096 and at most 4,194,304, or until energy has died away, omega the highest frequency, of "
    "explicit Euler the lowest; with methods for any step 1.125 periods and at least 48 steps, with methods "
    "that choose their own steps, which run only if named, two periods and at least 4 intervals of length "
    "dt. Nothing "
    "supplies energy. Gains energy: at some sample it is more than 5 percent above the initial one. Blows "
    "up: it is ten times the initial one, or its mean still grows by more than 5 percent from one window of "
    "the run to the next, each as long as all before. Velocities that lag by half a step are advanced by it "
    "before energies are taken. Loses energy: after one period less than half of the energy that a reference "
    "with small steps has then. Folds: a corner of a cell is inverted in one of the samples, at least 128. "
    "Solver stalls: no solution is found. Too many steps: more than 500 between two samples, one or a few dt "
    "apart. Refused: the method has no step for such a body, as xpbd and vbd for a negative volume stiffness "
    "(nu below 1/4). White: not tried. Steps of different outcome are at most 1/32 octave apart for methods "
    "with a limit, 1/4 for others. omega_max and the predicted limit are those of the body at rest, for "
    "small "
    "motions: `mss stability` measures it about deformed states.";

Json configuration(const AtlasConfig& c) {
  Json parameters = Json::array();
  for (const AtlasParameter& parameter : c.parameters)
    parameters.push_back(
        {{"name", parameter.name}, {"values", parameter.values}, {"halvings", parameter.halvings}});
  return {{"parameters", parameters},
          {"integrators", c.integrators},
          {"finest", c.finest},
          {"finest_without_limit", c.finest_without_limit},
          {"quick", c.quick}};
}

/// What the rows of limits say about one method.
struct StableRange {
  double least = std::numeric_limits<double>::infinity(), most = 0;  ///< dt omega_max
  std::set<std::string> next{};                                      ///< outcomes beyond, by name
  bool somewhere_none = false;                                       ///< a row without a stable step
  /// Where energy grows without bound, over predicted; of small strains.
  double least_ratio = std::numeric_limits<double>::infinity(), most_ratio = 0;
};
StableRange stable_range(const Table& limits) {
  StableRange range;
  for (std::size_t r = 0; r < limits.size(); ++r) {
    range.next.insert(limits.text(r, "next_outcome"));
    if (limits.text(r, "status") == "ok" && limits.text(r, "parameter") != "strain") {
      range.least_ratio = std::min(range.least_ratio, limits.number(r, "limit_over_predicted"));
      range.most_ratio = std::max(range.most_ratio, limits.number(r, "limit_over_predicted"));
    }
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
    if (range.most_ratio > 0)
      lines += fmt::format("; limit / predicted {:.3f} to {:.3f} where strains are small", range.least_ratio,
                           range.most_ratio);
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
  config.finest = config.finest_without_limit = 2 * octave_parts;
  Journal journal;
  return measure_atlas(config, 1, journal, progress)
      .points.select({"integrator", "ratio", "dt_omega", "status"});
}

}  // namespace

bool chooses_its_steps(const std::string& family) {
  return find_integrator(family).stepping == Stepping::adaptive;
}

AtlasConfig atlas_config(const ExperimentOptions& options) {
  AtlasConfig config{.parameters = {{"ratio",
                                     "damping ratio of every spring",
                                     {0, 0.02, 0.05, 0.2, 0.5, 1, 2},
                                     0,
                                     [](AtlasBody& body, double value) { body.ratio = value; }},
                                    {"poisson",
                                     "Poisson's ratio",
                                     {0, 0.2, 0.3, 0.4, 0.45, 0.49, 0.499},
                                     0,
                                     [](AtlasBody& body, double value) { body.poisson = value; }},
                                    {"strain",
                                     "initial strain",
                                     {-0.95, -0.8, -0.5, -0.2, 0.01, 0.2, 0.5, 1, 2, 3},
                                     1,
                                     [](AtlasBody& body, double value) { body.strain = value; }},
                                    {"cells",
                                     "cells per edge",
                                     {2, 3, 4, 5},
                                     0,
                                     [](AtlasBody& body, double value) {
                                       body.cells = int(value);
                                       body.ratio = 0;
                                       body.viscosity = material_viscosity;
                                     }}},
                     .integrators = moving_families(options.integrators),
                     .quick = options.quick};
  if (options.integrators.empty())  // those that choose their own steps have no limit
    std::erase_if(config.integrators, chooses_its_steps);
  if (options.quick) {
    config.finest = octave_parts / 8;
    config.finest_without_limit = octave_parts;
    config.parameters[0].values = {0, 0.05, 0.5, 2};
    config.parameters[1].values = {0, 0.45};
    config.parameters[2].values = {-0.5, 0.01, 1};
    if (options.integrators.empty())
      config.integrators = {"explicit_euler",  "semi_implicit_euler",
                            "velocity_verlet", "rk4",
                            "backward_euler",  "tr_bdf2",
                            "xpbd:5",          "vbd:5"};
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

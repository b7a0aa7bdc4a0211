// What cells of one size leave unresolved: estimates of it beside the error. Problems are in problems.cpp,
// estimates and their charts in estimates.cpp and estimates_chart.cpp.
#include "experiments/studies/refine/refine.hpp"

#include <fmt/format.h>

#include <cmath>

#include "experiments/studies/refine/maps.hpp"

namespace mss::studies::refine {

namespace {

constexpr const char* caption =
    "Static displacements in cubic cells of one size, small deformations, E = 100 kPa, nu = 0.3, springs of "
    "two face shares t. Corrected: the value and the estimate of its error together, which is what "
    "the lattice's energy has more than a continuum's of a recovered smooth displacement. Richardson: "
    "from this size and cells twice as large, the error assumed to go with h^2. The "
    "reference is the same lattice, extrapolated from the three finest sizes by the order these show; its "
    "uncertainty is the difference between the two face shares, which have the same limit, that of "
    "elasticity. Effectivity is the estimate over the error. The bracket has a re-entrant edge, where stress "
    "has no bound. The far goal is where hardly anything of the load arrives: there the estimate is no "
    "better "
    "than none, and says so in the column doubts. Maps: which cells are smaller, chosen around what "
    "concentrates stress, by the estimate (for few particles, or for little time: deep cells last), or two "
    "layers at the surface, against cells of one size. Displacements are those under the only load, spread "
    "evenly over a part of the surface, or of the far goal; frequencies the lowest; a landing is run by "
    "Verlet's method in safe steps. Gains are taken where errors stay below a bound. Particles are those "
    "that move. Static solutions are by the fastest linear solver that takes the body: multigrid takes cells "
    "of "
    "one size alone. Left out: large deformations, other nu, meshes.";

Json configuration(const RefineConfig& config) {
  Json problems = Json::object();
  for (const Problem& problem : config.problems) problems[problem.name] = problem.description;
  return {{"problems", problems},
          {"cells", config.cells},
          {"reference_cells", config.reference_cells},
          {"face_shares", config.face_shares},
          {"young", config.material.young},
          {"poisson", config.material.poisson},
          {"threads", config.threads}};
}

Json configuration(const MapConfig& config) {
  Json problems = Json::object();
  for (const MapProblem& problem : config.problems) problems[problem.name] = problem.description;
  return {{"problems", problems},
          {"uniform_cells", config.uniform_cells},
          {"reference_coarsening", config.reference_coarsening},
          {"most_particles", config.most_particles},
          {"face_share", config.face_share},
          {"sample_seconds", config.sample_seconds}};
}

std::string lines_of_gains(const Table& gains) {
  std::string lines;
  for (std::size_t r = 0; r < gains.size(); ++r)
    if (std::isfinite(gains.number(r, "gain")))
      lines += fmt::format("{:<18} {:<14} at {:>2.0f} %: {} of one cell size over its own {:.2f}\n",
                           gains.text(r, "problem"), gains.text(r, "map"), 100 * gains.number(r, "error"),
                           gains.text(r, "quantity"), gains.number(r, "gain"));
  return lines;
}

std::string lines_of(const Table& rows) {
  std::string lines;
  for (std::size_t r = 0; r < rows.size(); ++r)
    lines += fmt::format(
        "{:<9} t = {:<4g} {:>3} cells: error {:>8.3f} %, corrected {:>8.3f} %, Richardson {:>8.3f} %, "
        "effectivity "
        "{:.2f}; doubts: {}\n",
        rows.text(r, "problem"), rows.number(r, "face_share"), rows.number(r, "cells"),
        100 * rows.number(r, "raw_error"), 100 * rows.number(r, "corrected_error"),
        100 * rows.number(r, "richardson_error"), rows.number(r, "effectivity"), rows.text(r, "doubts"));
  return lines;
}

ExperimentResult run_refine(const ExperimentOptions& options, Progress& progress) {
  const RefineConfig config = refine_config(options);
  EstimateTables estimates = measure_estimates(config, progress);
  ExperimentResult result{.status = estimates.status,
                          .caption = caption,
                          .summary = lines_of(estimates.rows),
                          .configuration = configuration(config)};
  result.tables = {{"refine", std::move(estimates.rows)},
                   {"refine_reference", std::move(estimates.reference)}};
  if (result.status != Status::ok) return result;
  const MapConfig of_maps = map_config(options);
  MapTables maps = measure_maps(of_maps, progress);
  result.status = maps.status;
  result.summary += lines_of_gains(maps.gains);
  result.configuration["maps"] = configuration(of_maps);
  result.tables.push_back({"refine_maps", std::move(maps.rows)});
  result.tables.push_back({"refine_gains", std::move(maps.gains)});
  return result;
}

Drawings draw_refine(const std::vector<NamedTable>& tables) {
  Drawings drawings{
      .charts = estimate_charts(find_table(tables, "refine"), find_table(tables, "refine_reference"))};
  for (NamedChart& chart : map_charts(find_table(tables, "refine_maps")))
    drawings.charts.push_back(std::move(chart));
  return drawings;
}

Table baseline_table(const BaselineOptions& options, Progress& progress) {
  RefineConfig config = refine_config({.quick = options.quick});
  config.threads = options.threads;
  return measure_estimates(config, progress).rows;
}

}  // namespace

RefineConfig refine_config(const ExperimentOptions& options) {
  RefineConfig config{.problems = problems()};
  config.cells = options.quick ? std::vector{2, 4} : std::vector{2, 4, 8, 16};
  config.reference_cells = options.quick ? std::vector{2, 4, 8} : std::vector{8, 16, 32};
  return config;
}

ExperimentInfo experiment() {
  return {.name = "refine",
          .summary =
              "what cells of one size leave unresolved, corrected values, and smaller cells where they pay",
          .run = run_refine,
          .draw = draw_refine,
          .baseline = {.keys = {"problem", "face_share", "cells"},
                       .rules = {{"value", 1e-8},
                                 {"estimate", 1e-6, 1e-12},
                                 {"reference", 1e-6},
                                 {"raw_error", 1e-6, 1e-6},
                                 {"corrected_error", 1e-6, 1e-6},
                                 {"richardson_error", 1e-6, 1e-6},
                                 {"effectivity", 1e-4}},
                       .table = baseline_table}};
}

}  // namespace mss::studies::refine

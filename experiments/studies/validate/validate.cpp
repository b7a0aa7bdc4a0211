// Springs as a material: lattices of springs and finite elements against closed forms and converged finite
// elements, with their cost. Every model stands for the same E and nu, and the mesh is refined. Cases and
// models are in cases.cpp, runs in runs.cpp, charts in chart.cpp.
#include "experiments/studies/validate/validate.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace mss::studies::validate {

namespace {

Json configuration(const ValidationConfig& config) {
  Json all = Json::object(), models = Json::array();
  for (const ValidationCase& c : config.cases)
    all[c.name] = {{"description", c.description}, {"quantity", c.quantity}, {"poisson", c.poisson},
                   {"viscosity", c.viscosity},     {"source", c.source},     {"most_cells", c.most_cells},
                   {"uncertainty", c.uncertainty}};
  for (const ValidationModel& m : config.models) models.push_back(m.name);
  return {{"young", config.young},
          {"density", config.density},
          {"cases", all},
          {"models", models},
          {"cells", config.cells},
          {"refinement", config.refinement},
          {"strains", config.strains},
          {"repetitions", config.repetitions},
          {"linear_solver", "automatic"},
          {"sharing", "weighted"},
          {"threads", config.threads}};
}

constexpr const char* caption =
    "Error of a body's response: of all cases at one resolution, of a cantilever against cells across the "
    "width and against the wall time of setup and solution, one thread; tables have the others. Every model "
    "stands for E = 100 kPa and the given nu; t is the share of the shear stiffness that face diagonals "
    "carry; elements are trilinear hexahedra on the same cells, fully integrated, or with the mean "
    "dilatation of each cell, which does not lock near nu = 1/2. The thesis's springs keep their "
    "proportions and are scaled to the right E along their edges; refinement does not make them converge to "
    "the reference, because their Poisson's ratio and their stiffness in other directions differ. Uniform "
    "stress is in the table only: elements and springs with t = 1 are exact, and in tension along the edges "
    "all are; body diagonals at a free surface do not carry shear as a continuum does. So is the decay of "
    "two vibrations of a viscous cube. Where deformations are large, only the elements of St. Venant and "
    "Kirchhoff have the reference's law (linear in Green's strain, which softens in compression); "
    "differences of the other models do not vanish and are no errors. What the springs converge to is their "
    "Cauchy-Born limit: the energy of a cell under the same deformation as all others (`mss validate "
    "lattice` measures it where cells are free not to deform alike); a chart shows it, as far as the "
    "lattice is stable, beside a compressible neo-Hookean solid and that of St. Venant and Kirchhoff with "
    "the same E and nu. Estimates of the error, by recovered smooth displacements, are of calibrated "
    "springs at rest under small deformations; effectivity is the estimate over the error. References from "
    "finite elements are extrapolated; errors below their uncertainty, the effect of that extrapolation, "
    "are not significant. The elements are plain code, not tuned as the springs are. Left out: other "
    "shapes, loads and solvers, single precision.";

std::string summary_lines(const Table& summary) {
  std::string lines;
  for (std::size_t r = 0; r < summary.size(); ++r)
    lines += fmt::format("{:<19} {:<27} error {:>9.2e} at {:>2} cells across; {}\n", summary.text(r, "case"),
                         summary.text(r, "model"), summary.number(r, "error"), summary.number(r, "cells"),
                         summary.text(r, "status") == "ok"
                             ? fmt::format("order {:.2f}", summary.number(r, "order"))
                             : summary.text(r, "status"));
  return lines;
}

ExperimentResult run_validate(const ExperimentOptions& options, Progress& progress) {
  const ValidationConfig config = validation_config(options);
  ValidationTables tables = measure_validation(config, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  result.summary = summary_lines(validation_summary(tables.rows, config)) + large_strain_text(tables.strains);
  result.tables = validation_files(config, std::move(tables));
  return result;
}

/// A description of each case, for readers of the tables and charts.
Table case_table(const std::vector<ValidationCase>& cases) {
  Table table({{"case"},
               {"description"},
               {"quantity"},
               {"unit"},
               {"poisson"},
               {"deformations"},
               {"source"},
               {"uncertainty"},
               {"charted"}});
  for (const ValidationCase& c : cases)
    table.add({c.name, c.description, c.quantity, c.unit, c.poisson,
               std::string(c.deformations == Deformations::large ? "large" : "small"), c.source,
               c.uncertainty, std::string(c.charted ? "yes" : "no")});
  return table;
}

}  // namespace

std::vector<NamedTable> validation_files(const ValidationConfig& config, ValidationTables tables) {
  Table summary = validation_summary(tables.rows, config);
  return {{"validate", std::move(tables.rows)},
          {"validate_summary", std::move(summary)},
          {"validate_cases", case_table(config.cases)},
          {"validate_refinement", std::move(tables.refinement)},
          {"validate_large_strain", std::move(tables.strains)},
          {"validate_estimates", std::move(tables.estimates)}};
}

ValidationConfig validation_config(const ExperimentOptions& options) {
  ValidationConfig config;
  config.cells = options.cells;
  if (config.cells.empty())
    config.cells = options.quick ? std::vector<int>{1, 2, 4} : std::vector<int>{1, 2, 4, 8, 16};
  config.refinement = options.quick ? std::vector<int>{1, 2, 5} : std::vector<int>{1, 2, 3, 4, 5, 7, 10, 14};
  config.strains = options.quick ? std::vector<double>{-0.4, -0.2, -0.1, 0.1, 0.2, 0.4}
                                 : std::vector<double>{-0.4, -0.35, -0.3, -0.25, -0.2, -0.15, -0.1, -0.05,
                                                       0.05, 0.1,   0.15, 0.2,   0.25, 0.3,   0.35, 0.4};
  config.cases = validation_cases(config.young, config.density);
  config.models = validation_models();
  return config;
}

namespace {

/// The large strains as rows of the baseline: the Cauchy-Born limit is their reference.
void add_large_strains(Table& rows, const Table& strains) {
  for (std::size_t r = 0; r < strains.size(); ++r) {
    const double difference = std::abs(strains.number(r, "difference"));
    rows.add({fmt::format("uniaxial {:+g}", strains.number(r, "strain")), strains.text(r, "springs"),
              std::int64_t(strains.number(r, "cells")), std::int64_t{0}, strains.number(r, "stress"),
              strains.number(r, "cauchy_born_stress"), difference, strains.text(r, "status")});
  }
}

Table baseline_table(const BaselineOptions& options, Progress& progress) {
  ValidationConfig config =
      validation_config({.cells = options.quick ? std::vector<int>{1, 2} : std::vector<int>{1, 2, 4, 8}});
  config.repetitions = 1;
  config.refinement.clear();
  config.threads = options.threads;
  config.strains = {-0.4, -0.2, -0.1, 0.1, 0.2, 0.4};
  const ValidationTables tables = measure_validation(config, progress);
  Table rows =
      tables.rows.select({"case", "model", "cells", "unknowns", "value", "reference", "error", "status"});
  add_large_strains(rows, tables.strains);
  return rows;
}

}  // namespace

ExperimentInfo experiment() {
  return {.name = "validate",
          .summary = "error of springs and of finite elements against closed forms, and its cost",
          .accepts = {.cells = true, .largest_cells = 16},
          .run = run_validate,
          .draw = draw_validation,
          .baseline = {.keys = {"case", "model", "cells"},
                       .rules = {{"value", 1e-7}, {"reference", 1e-12}, {"error", 0, 1e-6}},
                       .table = baseline_table}};
}

}  // namespace mss::studies::validate

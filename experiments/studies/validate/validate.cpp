// What springs mean: answers of lattices and of finite elements against closed forms and converged elements,
// and what they cost. Every model stands for the same E and nu, and the mesh is refined. Cases and models are
// in validate_cases.cpp, runs in validate_runs.cpp, what is drawn in validate_chart.cpp.
#include "experiments/studies/validate/validate.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace mss::studies::validate {

namespace {

Json configuration(const ValidationConfig& config) {
  Json all = Json::object(), models = Json::array();
  for (const ValidationCase& c : config.cases)
    all[c.name] = {{"description", c.description}, {"quantity", c.quantity},     {"poisson", c.poisson},
                   {"source", c.source},           {"most_cells", c.most_cells}, {"doubt", c.doubt}};
  for (const ValidationModel& m : config.models) models.push_back(m.name);
  return {{"young", config.young},
          {"density", config.density},
          {"cases", all},
          {"models", models},
          {"cells", config.cells},
          {"refinement", config.refinement},
          {"repetitions", config.repetitions},
          {"linear_solver", "cholmod"},
          {"sharing", "weighted"},
          {"threads", config.threads}};
}

constexpr const char* caption =
    "Error of what a body answers against cells across the width, and against wall time from nothing to the "
    "answer, one thread. Every model stands for E = 100 kPa and the nu given; t is the share of the shear "
    "stiffness that face diagonals carry; elements are trilinear hexahedra on the same cells, integrated in "
    "full. The thesis's springs keep their proportions and are scaled to the right E along their edges; "
    "refining them does not make them right, because their Poisson's ratio and their stiffness in other "
    "directions are not. Uniform stress is in the table only: elements and springs with t = 1 answer it "
    "exactly, a pull along the edges all do; body diagonals at a free surface do not bear shear as a "
    "continuum does. Where deformations are large, only the elements of St. Venant and Kirchhoff have the "
    "reference's law (linear in Green's strain, which gives way when crushed); those of springs and other "
    "elements are others, whose differences do not vanish and are no errors. References from finite elements "
    "are extrapolated; below what that changed nothing can be told. The elements are plain "
    "code, "
    "not tuned as the springs are. Left out: other shapes, loads and solvers, single precision.";

ExperimentResult run_validate(const ExperimentOptions& options, Progress& progress) {
  const ValidationConfig config = validation_config(options);
  ValidationTables tables = measure_validation(config, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  Table summary = validation_summary(tables.rows, config);
  const auto measured = tables.rows.distinct("case");
  for (const ValidationCase& c : config.cases) {
    if (!c.charted || std::find(measured.begin(), measured.end(), c.name) == measured.end()) continue;
    const bool first = result.charts.empty();
    result.charts.push_back({first ? "validate" : "validate_" + c.name + "_seconds",
                             validation_chart(tables.rows, config, c, "seconds")});
    result.charts.push_back(
        {"validate_" + c.name + "_cells", validation_chart(tables.rows, config, c, "cells")});
  }
  if (tables.refinement.size() > 0)
    result.charts.push_back({"validate_refinement", refinement_chart(tables.refinement)});
  for (std::size_t r = 0; r < summary.size(); ++r)
    result.summary += fmt::format(
        "{:<19} {:<27} error {:>9.2e} at {:>2} cells across; {}\n", summary.text(r, "case"),
        summary.text(r, "model"), summary.number(r, "error"), summary.number(r, "cells"),
        summary.text(r, "status") == "ok" ? fmt::format("order {:.2f}", summary.number(r, "order"))
                                          : summary.text(r, "status"));
  result.tables = {{"validate", std::move(tables.rows)},
                   {"validate_summary", std::move(summary)},
                   {"validate_refinement", std::move(tables.refinement)}};
  return result;
}

}  // namespace

ValidationConfig validation_config(const ExperimentOptions& options) {
  ValidationConfig config;
  config.cells = options.cells;
  if (config.cells.empty())
    config.cells = options.quick ? std::vector<int>{1, 2, 4} : std::vector<int>{1, 2, 4, 8, 16};
  config.refinement = options.quick ? std::vector<int>{1, 2, 5} : std::vector<int>{1, 2, 3, 4, 5, 7, 10, 14};
  config.cases = validation_cases(config.young, config.density);
  config.models = validation_models();
  return config;
}

namespace {

Table baseline_table(const BaselineOptions& options, Progress& progress) {
  ValidationConfig config =
      validation_config({.cells = options.quick ? std::vector<int>{1, 2} : std::vector<int>{1, 2, 4, 8}});
  config.repetitions = 1;
  config.refinement.clear();
  config.threads = options.threads;
  return measure_validation(config, progress)
      .rows.select({"case", "model", "cells", "unknowns", "value", "reference", "error", "status"});
}

}  // namespace

ExperimentInfo experiment() {
  return {.name = "validate",
          .summary = "error of springs and of finite elements against closed forms, and its cost",
          .accepts = {.cells = true, .largest_cells = 16},
          .run = run_validate,
          .baseline = {.keys = {"case", "model", "cells"},
                       .rules = {{"value", 1e-7}, {"reference", 1e-12}, {"error", 0, 1e-6}},
                       .table = baseline_table}};
}

}  // namespace mss::studies::validate

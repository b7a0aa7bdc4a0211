// What springs mean: static deflections of lattices against closed forms and finite elements, and what they
// cost. Every model stands for the same E and nu, and the mesh is refined.
#include "experiments/validate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "experiments/statistics.hpp"
#include "integrators/linear/linear_solver.hpp"
#include "reference/closed_forms.hpp"

namespace mss {

namespace {

using Clock = std::chrono::steady_clock;
constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// Errors below are rounding: no order can be read from them, and no chart is drawn.
constexpr double rounding = 1e-9;

/// Any does, because the response is linear; one that dwarfs the rounding of springs at rest is best [N].
constexpr double total_load = 1e5;

/// Springs in the thesis's proportions (k_e : k_f : k_c = 1 : 1 : 3, no volume force), scaled to have the
/// Young's modulus asked for along their edges; Poisson's ratio and anisotropy are what they are.
SpringConstants thesis_springs(const ElasticConstants& material, double cell_size) {
  const SpringConstants unit{.edge = 1, .face = 1, .body = 3, .volume = 0};
  const double scale = material.young / cubic_stiffness(unit, cell_size).young({1, 0, 0});
  return {.edge = scale, .face = scale, .body = 3 * scale, .volume = 0};
}

LatticeModel calibrated(double face_share) {
  return {fmt::format("calibrated, t = {:g}", face_share),
          [face_share](const ElasticConstants& m, double h) { return calibrate(m, h, face_share); }};
}

std::vector<ValidationCase> cases(const ElasticConstants& m) {
  constexpr double density = 1000, length = 4;
  const reference::SquareBar bar{m.young, m.poisson, 1, length};
  const Box whole_end{{length, 0, 0}, {length, 1, 1}}, clamp{{0, 0, 0}, {0, 1, 1}};
  // Symmetry planes that let the bar narrow.
  const std::vector<Hold> sliding{{.box = clamp, .axes = {true, false, false}},
                                  {.box = {{0, 0, 0}, {length, 0, 1}}, .axes = {false, true, false}},
                                  {.box = {{0, 0, 0}, {length, 1, 0}}, .axes = {false, false, true}}};

  return {{.name = "stretch",
           .description = "bar 4 x 1 x 1 m, pulled along its length",
           .proportions = {4, 1, 1},
           .density = density,
           .environment = {.holds = sliding, .loads = {{.box = whole_end, .force = {total_load, 0, 0}}}},
           .measured = whole_end,
           .axis = 0,
           .reference = reference::pulled_extension(bar, 1),
           .source = "F L / (E A)"},
          {.name = "cantilever",
           .description = "cantilever 4 x 1 x 1 m, its end clamped, sheared at its tip",
           .proportions = {4, 1, 1},
           .density = density,
           .environment = {.holds = {{.box = clamp}},
                           .loads = {{.box = whole_end, .force = {0, 0, -total_load}}}},
           .measured = whole_end,
           .axis = 2,
           .reference = -reference::clamped_cantilever_deflection,
           .source = "CalculiX C3D20, converged"}};
}

/// What came of one model of a case.
struct Result {
  Status status = Status::ok;
  double compliance = none;
  std::int64_t unknowns = 0;
  std::vector<double> seconds{};
};

/// Builds a body and solves K u = f at rest, all of it timed: that is what an answer costs.
void solve(const ValidationConfig& config, const ValidationCase& c, const LatticeModel& model, int m,
           Result& result) {
  const auto begin = Clock::now();
  const double h = 1.0 / m;
  const Body body({.voxels = VoxelGrid::box(m * c.proportions[0], m * c.proportions[1], m * c.proportions[2]),
                   .cell_size = h,
                   .density = c.density,
                   .springs = model.springs(config.material, h)});
  SpringSystem<double> system(body, c.environment, {.threads = 1});
  const State<double> rest = system.rest_state();
  Field<double> load(system.size()), displacement(system.size());
  system.force(0, rest.x, rest.v, load);
  Work work;
  const auto linear = find_linear_solver("cholmod").make(0);
  result.status =
      linear->prepare(system, 0, rest.x, rest.v, {.stiffness = 1, .kind = Tangent::elastic}, work);
  if (result.status == Status::ok) result.status = linear->solve(load, displacement, work);
  result.seconds.push_back(std::chrono::duration<double>(Clock::now() - begin).count());
  result.unknowns = std::int64_t(system.unknowns().size());
  const auto sites = body.select(c.measured.lower, c.measured.upper);
  double sum = 0;
  for (const std::ptrdiff_t site : sites) sum += displacement.at(site)[c.axis];
  result.compliance = sum / double(sites.size()) / total_load;
}

/// All models of a case in turn, again and again; false if stopped.
bool measure_case(const ValidationConfig& config, const ValidationCase& c, int m, Table& rows,
                  const Progress& progress) {
  std::vector<Result> results(config.models.size());
  if (!take_turns(config.repetitions, results.size(), progress,
                  [&](std::size_t i) { solve(config, c, config.models[i], m, results[i]); }))
    return false;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const Result& r = results[i];
    const bool ok = r.status == Status::ok;
    rows.add({c.name, config.models[i].name, m, r.unknowns, ok ? r.compliance : none, c.reference,
              ok ? std::abs(r.compliance / c.reference - 1) : none, quantile(r.seconds, 0.5),
              quantile(r.seconds, 0.25), quantile(r.seconds, 0.75), std::int64_t(r.seconds.size()),
              std::string(to_string(r.status))});
  }
  return true;
}

Table empty_rows() {
  return Table({{"case"},
                {"model"},
                {"cells"},
                {"unknowns"},
                {"compliance", "m/N"},
                {"reference", "m/N"},
                {"error"},
                {"seconds", "s"},
                {"q1", "s"},
                {"q3", "s"},
                {"repeats"},
                {"status"}});
}

Json configuration(const ValidationConfig& config) {
  Json all = Json::object(), models = Json::array();
  for (const ValidationCase& c : config.cases)
    all[c.name] = {{"description", c.description}, {"source", c.source}};
  for (const LatticeModel& m : config.models) models.push_back(m.name);
  return {{"young", config.material.young},
          {"poisson", config.material.poisson},
          {"cases", all},
          {"models", models},
          {"cells", config.cells},
          {"repetitions", config.repetitions},
          {"method", "K u = f at rest, CHOLMOD"},
          {"sharing", "weighted"},
          {"threads", 1}};
}

constexpr const char* caption =
    "Error of small static deflections (K u = f at rest) against cells across the width, and against wall"
    " time from nothing to the answer, one thread. Every lattice stands for E = 100 kPa and nu = 0.3; t "
    "is the share of the shear stiffness that face diagonals carry. The thesis's springs keep their "
    "proportions and are scaled to the right E along their edges; refining them does not make them right,"
    " because their Poisson's ratio and their stiffness in other directions are not. A pull along the "
    "edges is exact to rounding for all of them, and in the table only. Left out so far: torsion, "
    "hanging, large deformations, vibrations, finite elements as a model.";

bool exact(const Table& rows, const std::string& name) {
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.text(r, "case") == name && !(rows.number(r, "error") < rounding)) return false;
  return true;
}

ExperimentResult run_validate(const ExperimentOptions& options, Progress& progress) {
  const ValidationConfig config = validation_config(options);
  ValidationTables tables = measure_validation(config, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  Table summary = validation_summary(tables.rows);
  const auto measured = tables.rows.distinct("case");
  for (const ValidationCase& c : config.cases) {
    if (std::find(measured.begin(), measured.end(), c.name) == measured.end() || exact(tables.rows, c.name))
      continue;
    const bool first = result.charts.empty();
    result.charts.push_back({first ? "validate" : "validate_" + c.name + "_seconds",
                             validation_chart(tables.rows, c, "seconds")});
    result.charts.push_back({"validate_" + c.name + "_cells", validation_chart(tables.rows, c, "cells")});
  }
  for (std::size_t r = 0; r < summary.size(); ++r)
    result.summary += fmt::format(
        "{:<11} {:<22} error {:>9.2e} at {:>2} cells across; {}\n", summary.text(r, "case"),
        summary.text(r, "model"), summary.number(r, "error"), summary.number(r, "cells"),
        summary.text(r, "status") == "ok" ? fmt::format("order {:.2f}", summary.number(r, "order"))
                                          : summary.text(r, "status"));
  result.tables = {{"validate", std::move(tables.rows)}, {"validate_summary", std::move(summary)}};
  return result;
}

}  // namespace

ValidationConfig validation_config(const ExperimentOptions& options) {
  ValidationConfig config;
  config.cells = options.cells;
  if (config.cells.empty())
    config.cells = options.quick ? std::vector<int>{1, 2, 4} : std::vector<int>{1, 2, 4, 8};
  config.cases = cases(config.material);
  config.models = {{"thesis's springs", thesis_springs}, calibrated(0.25), calibrated(0.5), calibrated(1)};
  return config;
}

ValidationTables measure_validation(const ValidationConfig& config, Progress& progress) {
  ValidationTables tables{empty_rows()};
  const auto total = double(config.cases.size() * config.cells.size());
  double done = 0;
  for (const ValidationCase& c : config.cases)
    for (const int m : config.cells) {
      progress.report(done++ / total, fmt::format("{}, {} cells across", c.name, m));
      if (!measure_case(config, c, m, tables.rows, progress)) {
        tables.status = Status::interrupted;
        return tables;
      }
    }
  return tables;
}

Table validation_summary(const Table& rows) {
  Table summary({{"case"}, {"model"}, {"cells"}, {"error"}, {"order"}, {"status"}});
  for (const std::string& name : rows.distinct("case"))
    for (const std::string& model : rows.distinct("model")) {
      std::vector<std::pair<double, double>> errors;  // by cells
      for (std::size_t r = 0; r < rows.size(); ++r)
        if (rows.text(r, "case") == name && rows.text(r, "model") == model && rows.text(r, "status") == "ok")
          errors.emplace_back(rows.number(r, "cells"), rows.number(r, "error"));
      if (errors.empty()) continue;
      double order = none;
      const bool exact = errors.back().second < rounding;
      if (errors.size() > 1 && !exact) {
        const auto [fine, small] = errors.back();
        const auto [coarse, large] = errors[errors.size() - 2];
        order = std::log(large / small) / std::log(fine / coarse);
      }
      summary.add({name, model, errors.back().first, errors.back().second, order,
                   std::string(exact                  ? "exact to rounding"
                               : std::isfinite(order) ? "ok"
                                                      : "one size only")});
    }
  return summary;
}

Chart validation_chart(const Table& rows, const ValidationCase& c, const std::string& against) {
  const bool time = against == "seconds";
  Chart chart{.title = time ? "What accuracy costs" : "What refining gains",
              .subtitle = c.description + "; against " + c.source,
              .x = {.label = time ? "wall time, from nothing to the answer" : "cells across the width",
                    .logarithmic = true,
                    .unit = time ? "s" : ""},
              .y = {.label = "error of the deflection", .logarithmic = true}};
  for (const std::string& model : rows.distinct("model")) {
    ChartSeries series{.label = model};
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (rows.text(r, "case") != c.name || rows.text(r, "model") != model) continue;
      if (rows.text(r, "status") != "ok")
        series.label += fmt::format(" ({} at {} cells)", rows.text(r, "status"), rows.number(r, "cells"));
      else if (rows.number(r, "error") > 0)
        series.points.push_back({rows.number(r, against), rows.number(r, "error")});
      if (!time) chart.x.ticks.push_back(rows.number(r, "cells"));
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

ExperimentInfo validate() {
  return {.name = "validate",
          .summary = "error of static deflections against closed forms and finite elements, and its cost",
          .accepts = {.cells = true, .largest_cells = 16},
          .run = run_validate};
}

}  // namespace mss

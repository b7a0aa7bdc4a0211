// The largest stable step: for every method that has one, the step from which on small motions of a body
// grow, found by bisection, beside the limit predicted from the body's own stiffness and damping, and the
// guaranteed one on which `dt = "safe"` rests; against resolution, damping and deformation. Runs are in
// runs.cpp.
#include "experiments/studies/stability/stability.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "experiments/harness/settings.hpp"
#include "integrators/analysis/stable_step.hpp"

namespace mss::studies::stability {

namespace {

Json configuration(const StabilityConfig& c) {
  Json deformations = Json::array();
  for (const Deformation deformation : c.deformations) deformations.push_back(to_string(deformation));
  return {{"body",
           "free cube of 1 m, calibrated springs, t = 0.5; damping by a ratio of every spring's critical; "
           "deformed: clamped at two opposite faces"},
          {"young", c.young},
          {"poisson", c.poisson},
          {"density", c.density},
          {"cells", c.cells},
          {"ratios", c.ratios},
          {"deformations", deformations},
          {"deformed_cells", c.deformed_cells},
          {"deformed_ratios", c.deformed_ratios},
          {"integrators", c.integrators},
          {"resolution", c.resolution},
          {"seed", c.seed}};
}

constexpr const char* caption =
    "The largest step at which a small random motion about an equilibrium does not grow: from a hundredth of "
    "the time that sound takes through a cell the step is quadrupled until motion grows, and the limit "
    "bisected to 0.4 percent; a step is unstable if the mean kinetic energy of small motions grows from one "
    "window of the run to the next, each as long as all before, up to 131,072 steps (32,768 without "
    "damping). "
    "Free cubes of 1 m at rest; and between clamps at two opposite faces, 3 cells across, a cube stretched "
    "by "
    "30 percent, one compressed by 20 percent, and a bar of 3 m, its ends turned by 90 degrees. Predicted: "
    "the method's own limit for the mode about that equilibrium that allows the smallest step, computed from "
    "stiffness and damping there by the Lanczos method. Guaranteed: a lower bound, from upper bounds on "
    "stiffness and damping at rest; `dt = \"safe\"` takes nine tenths of it. The step falls as 1/n, so that "
    "the cost of a simulated second grows as n^4. A damping ratio is that of the springs, because limits are "
    "functions of it; a body of constant ratio loses viscosity as 1/n, and with a constant viscosity damped "
    "limits fall as 1/n^2. Methods without a limit are left out; those of orders 6 and 8 have no measured "
    "one without damping, where motions grow in a range of steps far narrower than 0.4 percent.";

/// A series per method that has chosen rows, with a point for each; the label of one without points says why.
template <class Chosen, class Point>
std::vector<ChartSeries> by_method(const Table& rows, Chosen&& chosen, Point&& point) {
  std::vector<ChartSeries> all;
  int style = 0;
  for (const std::string& name : rows.distinct("integrator")) {
    ChartSeries series{.label = name, .style = style++};
    std::string failure;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (rows.text(r, "integrator") != name || !chosen(r)) continue;
      if (rows.text(r, "status") == "ok")
        series.points.push_back(point(r));
      else
        failure = rows.text(r, "status");
    }
    if (series.points.empty() && failure.empty()) continue;
    if (series.points.empty()) series.label += fmt::format(" ({})", failure);
    all.push_back(std::move(series));
  }
  return all;
}

/// Of the bisection: the limit is known to so much of it.
constexpr double resolution_shown = 0.004;

std::string body_of(const Table& settings) {
  return fmt::format("free cube of 1 m, E = {:g} kPa, ν = {:g}", setting_number(settings, "young") / 1000,
                     setting_number(settings, "poisson"));
}

/// Methods whose curves coincide, for the subtitle: only the last of them is visible.
std::string coincident(const std::vector<ChartSeries>& all) {
  constexpr double visible = 0.01;
  const auto coincide = [](const ChartSeries& a, const ChartSeries& b) {
    return !a.points.empty() && std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(),
                                           [](const ChartPoint& p, const ChartPoint& q) {
                                             return p.x == q.x &&
                                                    std::abs(p.y - q.y) <= visible * std::abs(q.y);
                                           });
  };
  std::string text;
  std::set<std::string> listed;
  for (const ChartSeries& first : all) {
    std::vector<std::string> names;
    for (const ChartSeries& other : all)
      if (!listed.contains(other.label) && coincide(first, other)) names.push_back(other.label);
    if (names.size() > 1) text += fmt::format("; {}", fmt::join(names, " = "));
    listed.insert(names.begin(), names.end());
  }
  return text;
}

/// Every row: the step found over that predicted, a line of markers for each method and deformation.
Chart predicted_chart(const Table& rows) {
  constexpr double apart = 0.2;  // of markers in a row; rows are 1 apart
  const std::vector<std::string> methods = without_variants(rows.distinct("integrator")),
                                 deformations = rows.distinct("deformation");
  Chart chart{
      .title = "The largest stable step, over that predicted",
      .subtitle = "a marker for every resolution and damping ratio; dotted: 0.4 % off, to which it is found",
      .x = {.label = "step found by bisection / step by linear theory"},
      .y = named_rows(methods),
      .lines = {{ReferenceLine::Direction::vertical, 1 - resolution_shown, ""},
                {ReferenceLine::Direction::vertical, 1 + resolution_shown, ""}}};
  for (std::size_t d = 0; d < deformations.size(); ++d) {
    const bool at_rest = deformations[d] == to_string(Deformation::none);
    const double shift = apart * ((double(deformations.size()) - 1) / 2 - double(d));
    ChartSeries series{.label = at_rest ? "at rest" : deformations[d], .joined = false};
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const Table found =
          rows.where("deformation", deformations[d]).where("integrator", methods[m]).where("status", "ok");
      for (std::size_t r = 0; r < found.size(); ++r)
        series.points.push_back({found.number(r, "measured_over_predicted"), chart.y.ticks[m] + shift});
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

Chart damping_chart(const Table& rows, const Table& settings) {
  const double n = rows.distinct_numbers("cells").back();
  const std::vector<ChartSeries> series = by_method(
      rows, [&](std::size_t r) { return rows.number(r, "cells") == n; },
      [&](std::size_t r) {
        return ChartPoint{rows.number(r, "ratio"),
                          rows.number(r, "measured") * rows.number(r, "omega_max") / 2};
      });
  return {.title = "The largest stable step, against damping",
          .subtitle = fmt::format("{}, n = {}{}", body_of(settings), n, coincident(series)),
          .x = {.label = "damping ratio of every spring"},
          .y = {.label = "largest stable step × ω_max / 2", .logarithmic = true},
          .series = series,
          .lines = {{ReferenceLine::Direction::horizontal, 1, ""}}};
}

/// Measured steps of deformed bodies and of the cube at rest of as many cells, over those guaranteed at rest.
Chart deformation_chart(const Table& rows, const Table& settings) {
  const std::vector<std::string> deformations = rows.distinct("deformation");
  const double n = setting_number(settings, "deformed_cells"),
               ratio = setting_number(settings, "deformed_ratio");
  const auto position = [&](std::size_t r) {
    return double(std::find(deformations.begin(), deformations.end(), rows.text(r, "deformation")) -
                  deformations.begin());
  };
  const std::vector<ChartSeries> series = by_method(
      rows,
      [&](std::size_t r) {
        return rows.number(r, "cells") == n && rows.number(r, "ratio") == ratio &&
               rows.number(r, "guaranteed") > 0;
      },
      [&](std::size_t r) {
        return ChartPoint{position(r), rows.number(r, "measured") / rows.number(r, "guaranteed")};
      });
  ChartAxis x{.label = "deformation", .low = -0.3, .high = double(deformations.size()) - 0.7};
  for (std::size_t i = 0; i < deformations.size(); ++i) {
    x.ticks.push_back(double(i));
    x.names.push_back(deformations[i]);
  }
  return {.title = "Stable steps of deformed bodies",
          .subtitle = fmt::format("{} cells across, damping ratio {:g}{}", n, ratio, coincident(series)),
          .x = x,
          .y = {.label = "largest stable step / guaranteed at rest", .low = 0.8},
          .series = series,
          .lines = {{ReferenceLine::Direction::horizontal, safe_share, "safe"}}};
}

Drawings draw_stability(const std::vector<NamedTable>& tables) {
  const Table& rows = find_table(tables, "stability");
  const Table& settings = find_table(tables, "stability_settings");
  const Table cubes = rows.where("deformation", to_string(Deformation::none));
  if (cubes.size() == 0) return {};
  Drawings drawings{.charts = {{"stability", predicted_chart(rows)},
                               {"stability_damping", damping_chart(cubes, settings)}}};
  if (cubes.size() < rows.size())
    drawings.charts.push_back({"stability_deformation", deformation_chart(rows, settings)});
  return drawings;
}

std::string summary(const Table& rows) {
  std::string lines;
  for (const std::string& name : rows.distinct("integrator")) {
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (rows.text(r, "integrator") != name || rows.text(r, "status") != "ok") continue;
      least = std::min(least, rows.number(r, "measured_over_predicted"));
      most = std::max(most, rows.number(r, "measured_over_predicted"));
    }
    lines += most < least
                 ? fmt::format("{:<20} no step is stable\n", name)
                 : fmt::format("{:<20} measured / predicted from {:.4f} to {:.4f}\n", name, least, most);
  }
  return lines;
}

ExperimentResult run_stability(const ExperimentOptions& options, Progress& progress) {
  const StabilityConfig config = stability_config(options);
  Journal journal = open_journal(options, configuration(config));
  const StabilityTables tables = measure_stability(config, options.processes, journal, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  result.summary = summary(tables.rows);
  result.tables = stability_files(config, tables.rows);
  return result;
}

}  // namespace

StabilityConfig stability_config(const ExperimentOptions& options) {
  StabilityConfig config;
  config.cells = options.cells;
  if (config.cells.empty()) config.cells = options.quick ? std::vector<int>{2, 3} : std::vector<int>{2, 3, 4};
  config.ratios = options.quick ? std::vector<double>{0, 0.5} : std::vector<double>{0, 0.05, 0.2, 0.5, 1};
  config.deformations = {Deformation::stretched, Deformation::compressed, Deformation::bent};
  config.deformed_ratios = options.quick ? std::vector<double>{0.5} : std::vector<double>{0, 0.05, 0.5};
  config.integrators = limited_integrators(options.integrators);
  config.seed = options.seed;
  return config;
}

std::vector<NamedTable> stability_files(const StabilityConfig& config, const Table& rows) {
  return {{"stability", rows},
          {"stability_settings",
           settings_table(
               {{"young", config.young},
                {"poisson", config.poisson},
                {"deformed_cells", config.deformed_cells},
                {"deformed_ratio", config.deformed_ratios.empty() ? 0 : config.deformed_ratios.back()}})}};
}

namespace {

Table baseline_table(const BaselineOptions& options, Progress& progress) {
  StabilityConfig config = stability_config({.quick = options.quick});
  config.cells = options.quick ? std::vector<int>{1, 2} : std::vector<int>{1, 2, 3, 4, 5};
  Journal journal;
  return measure_stability(config, 1, journal, progress)
      .rows.select({"integrator", "deformation", "cells", "ratio", "omega_max", "guaranteed", "predicted",
                    "measured", "measured_over_predicted", "status"});
}

}  // namespace

ExperimentInfo experiment() {
  return {.name = "stability",
          .summary =
              "the largest stable step of every integrator, against resolution, damping and deformation; "
              "measured and predicted",
          .accepts = {.cells = true,
                      .largest_cells = 20,
                      .integrators = limited_integrators,
                      .seed = true,
                      .processes = true},
          .run = run_stability,
          .draw = draw_stability,
          .baseline = {.keys = {"integrator", "deformation", "cells", "ratio"},
                       .rules = {{"omega_max", 1e-7},
                                 {"guaranteed", 1e-9},
                                 {"predicted", 1e-5},
                                 {"measured", 0.004},
                                 {"measured_over_predicted", 0.004}},
                       .table = baseline_table}};
}

}  // namespace mss::studies::stability

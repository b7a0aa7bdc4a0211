// The largest stable step: for every method that has one, the step from which on small motions of a cube
// grow, found by bisection, beside the limit predicted from the cube's own stiffness and damping, and the
// guaranteed one on which `dt = "safe"` rests; against resolution and damping. How long a simulated second
// takes at that step. Runs are in runs.cpp.
#include "experiments/studies/stability/stability.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "experiments/harness/settings.hpp"

namespace mss::studies::stability {

namespace {

Json configuration(const StabilityConfig& c) {
  return {{"body",
           "free cube of 1 m, calibrated springs, t = 0.5; damping by a ratio of every spring's critical"},
          {"young", c.young},
          {"poisson", c.poisson},
          {"density", c.density},
          {"cells", c.cells},
          {"ratios", c.ratios},
          {"integrators", c.integrators},
          {"resolution", c.resolution},
          {"seed", c.seed},
          {"threads", c.threads}};
}

constexpr const char* caption =
    "The largest step at which a small random motion of a free cube does not grow, found by bisection "
    "to 0.4 percent, against cells per edge. Predicted: the method's own limit for the mode of the cube that "
    "allows the "
    "smallest step, computed from its stiffness and damping by the Lanczos method. Guaranteed: a lower "
    "bound, from "
    "upper bounds on stiffness and damping; `dt = \"safe\"` takes nine tenths of it. The step falls as 1/n, "
    "so that "
    "the cost of a simulated second grows as n^4. Methods without a limit are left out; so are "
    "deformed states, which are stiffer, and other bodies.";

/// A series per method with a point for each chosen row; the label of one without points says why.
template <class Chosen, class Point>
std::vector<ChartSeries> by_method(const Table& rows, Chosen&& chosen, Point&& point) {
  std::vector<ChartSeries> all;
  for (const std::string& name : rows.distinct("integrator")) {
    ChartSeries series{.label = name, .style = int(all.size())};
    std::string failure;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (rows.text(r, "integrator") != name || !chosen(r)) continue;
      if (rows.text(r, "status") == "ok")
        series.points.push_back(point(r));
      else
        failure = rows.text(r, "status");
    }
    if (series.points.empty() && !failure.empty()) series.label += fmt::format(" ({})", failure);
    all.push_back(std::move(series));
  }
  return all;
}

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

ChartAxis cells_axis(const Table& rows) {
  const std::vector<double> cells = rows.distinct_numbers("cells");
  return {.label = "cells per edge, n",
          .logarithmic = true,
          .low = 0.9 * cells.front(),
          .high = 1.1 * cells.back(),
          .ticks = cells};
}

Chart cells_chart(const Table& rows, const Table& settings, double ratio) {
  const std::vector<ChartSeries> series = by_method(
      rows, [&](std::size_t r) { return rows.number(r, "ratio") == ratio; },
      [&](std::size_t r) {
        return ChartPoint{rows.number(r, "cells"), rows.number(r, "measured")};
      });
  return {.title = "The largest stable step, against resolution",
          .subtitle = fmt::format("{}, damping ratio {:g}{}", body_of(settings), ratio, coincident(series)),
          .x = cells_axis(rows),
          .y = {.label = "largest stable step", .logarithmic = true, .unit = "s"},
          .series = series};
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

Chart speed_chart(const Table& rows, const Table& settings, double ratio) {
  const double threads = setting_number(settings, "threads");
  return {.title = "How much faster than real time at the largest stable step",
          .subtitle = fmt::format("{}, damping ratio {:g}; {} thread{}", body_of(settings), ratio, threads,
                                  threads == 1 ? "" : "s"),
          .x = cells_axis(rows),
          .y = {.label = "simulated time / wall time", .logarithmic = true},
          .series = by_method(
              rows, [&](std::size_t r) { return rows.number(r, "ratio") == ratio; },
              [&](std::size_t r) {
                return ChartPoint{rows.number(r, "cells"), rows.number(r, "real_time_factor")};
              }),
          .lines = {{ReferenceLine::Direction::horizontal, 1, "real time"}}};
}

Drawings draw_stability(const std::vector<NamedTable>& tables) {
  const Table& rows = find_table(tables, "stability");
  const Table& settings = find_table(tables, "stability_settings");
  if (rows.size() == 0) return {};
  const std::vector<double> ratios = rows.distinct_numbers("ratio");
  const double shown = ratios.size() > 1 ? ratios[1] : ratios.front();
  return {.charts = {{"stability", cells_chart(rows, settings, shown)},
                     {"stability_damping", damping_chart(rows, settings)},
                     {"stability_real_time", speed_chart(rows, settings, shown)}}};
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
  const StabilityTables tables = measure_stability(config, progress);
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
  if (config.cells.empty())
    config.cells = options.quick ? std::vector<int>{2, 3, 4} : std::vector<int>{2, 3, 4, 5, 6, 7, 8};
  config.ratios = options.quick ? std::vector<double>{0, 0.5} : std::vector<double>{0, 0.05, 0.2, 0.5, 1};
  config.integrators = limited_integrators(options.integrators);
  config.seed = options.seed;
  return config;
}

std::vector<NamedTable> stability_files(const StabilityConfig& config, const Table& rows) {
  return {
      {"stability", rows},
      {"stability_settings",
       settings_table({{"young", config.young}, {"poisson", config.poisson}, {"threads", config.threads}})}};
}

namespace {

Table baseline_table(const BaselineOptions& options, Progress& progress) {
  StabilityConfig config = stability_config({.quick = options.quick});
  config.cells = options.quick ? std::vector<int>{2, 3} : std::vector<int>{2, 3, 4, 5};
  config.threads = options.threads;
  return measure_stability(config, progress)
      .rows.select(
          {"integrator", "cells", "ratio", "omega_max", "guaranteed", "predicted", "measured", "status"});
}

}  // namespace

ExperimentInfo experiment() {
  return {.name = "stability",
          .summary =
              "the largest stable step of every integrator, against resolution and damping; measured and "
              "predicted",
          .accepts = {.cells = true, .largest_cells = 20, .integrators = limited_integrators, .seed = true},
          .run = run_stability,
          .draw = draw_stability,
          .baseline = {
              .keys = {"integrator", "cells", "ratio"},
              .rules = {{"omega_max", 1e-7}, {"guaranteed", 1e-9}, {"predicted", 1e-5}, {"measured", 0.008}},
              .table = baseline_table}};
}

}  // namespace mss::studies::stability

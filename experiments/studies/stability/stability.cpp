// How large a step may be: for every method with a limit, the step at which small motions of a cube begin to
// grow, by bisection, beside the limit predicted from the cube's own stiffness and damping, and the one that
// `dt = "safe"` is sure of; against resolution and damping. What a second of simulation costs at that step.
// Runs are in stability_runs.cpp.
#include "experiments/studies/stability/stability.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

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
    "to 0.4 percent, against cells per edge. Predicted: the method's own limit for that motion of the "
    "cube which has the least, found by Lanczos in its stiffness and damping. Sure: what `dt = "
    "\"safe\"` takes nine tenths of, from bounds on both. The step falls as 1 / n, so a simulated "
    "second costs n^4. Methods without a limit are not here; nor are deformations, which stiffen "
    "springs, and other bodies.";

/// A series per method of what the rows chosen say; of a method that has none, why.
template <class Chosen, class Point>
std::vector<ChartSeries> by_method(const Table& rows, const StabilityConfig& config, Chosen&& chosen,
                                   Point&& point) {
  std::vector<ChartSeries> all;
  for (const std::string& name : config.integrators) {
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

std::string body_of(const StabilityConfig& config) {
  return fmt::format("free cube of 1 m, E = {:g} kPa, nu = {:g}", config.young / 1000, config.poisson);
}

/// Methods whose lines lie on top of each other, for the subtitle: only the last can be seen.
std::string coincident(const std::vector<ChartSeries>& all) {
  constexpr double visible = 0.01;
  const auto lie_together = [](const ChartSeries& a, const ChartSeries& b) {
    return !a.points.empty() && std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(),
                                           [](const ChartPoint& p, const ChartPoint& q) {
                                             return p.x == q.x &&
                                                    std::abs(p.y - q.y) <= visible * std::abs(q.y);
                                           });
  };
  std::string text;
  std::set<std::string> told;
  for (const ChartSeries& first : all) {
    std::vector<std::string> names;
    for (const ChartSeries& other : all)
      if (!told.contains(other.label) && lie_together(first, other)) names.push_back(other.label);
    if (names.size() > 1) text += fmt::format("; {}", fmt::join(names, " = "));
    told.insert(names.begin(), names.end());
  }
  return text;
}

ChartAxis cells_axis(const StabilityConfig& config) {
  return {.label = "cells per edge, n",
          .logarithmic = true,
          .low = 0.9 * config.cells.front(),
          .high = 1.1 * config.cells.back(),
          .ticks = {config.cells.begin(), config.cells.end()}};
}

Chart cells_chart(const Table& rows, const StabilityConfig& config, double ratio) {
  const std::vector<ChartSeries> series = by_method(
      rows, config, [&](std::size_t r) { return rows.number(r, "ratio") == ratio; },
      [&](std::size_t r) {
        return ChartPoint{rows.number(r, "cells"), rows.number(r, "measured")};
      });
  return {.title = "The largest step that holds, against resolution",
          .subtitle = fmt::format("{}, damping ratio {:g}{}", body_of(config), ratio, coincident(series)),
          .x = cells_axis(config),
          .y = {.label = "largest stable step", .logarithmic = true, .unit = "s"},
          .series = series};
}

Chart damping_chart(const Table& rows, const StabilityConfig& config) {
  const int n = config.cells.back();
  const std::vector<ChartSeries> series = by_method(
      rows, config, [&](std::size_t r) { return rows.number(r, "cells") == n; },
      [&](std::size_t r) {
        return ChartPoint{rows.number(r, "ratio"),
                          rows.number(r, "measured") * rows.number(r, "omega_max") / 2};
      });
  return {.title = "The largest step that holds, against damping",
          .subtitle = fmt::format("{}, n = {}{}", body_of(config), n, coincident(series)),
          .x = {.label = "damping of every spring over its critical"},
          .y = {.label = "largest stable step x omega_max / 2", .logarithmic = true},
          .series = series,
          .lines = {{ReferenceLine::Direction::horizontal, 1, ""}}};
}

Chart speed_chart(const Table& rows, const StabilityConfig& config, double ratio) {
  return {.title = "How much faster than real time, at the largest step that holds",
          .subtitle = fmt::format("{}, damping ratio {:g}; {} thread{}", body_of(config), ratio,
                                  config.threads, config.threads == 1 ? "" : "s"),
          .x = cells_axis(config),
          .y = {.label = "simulated time / wall time", .logarithmic = true},
          .series = by_method(
              rows, config, [&](std::size_t r) { return rows.number(r, "ratio") == ratio; },
              [&](std::size_t r) {
                return ChartPoint{rows.number(r, "cells"), rows.number(r, "real_time_factor")};
              }),
          .lines = {{ReferenceLine::Direction::horizontal, 1, "real time"}}};
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
                 ? fmt::format("{:<20} no step holds\n", name)
                 : fmt::format("{:<20} measured / predicted from {:.4f} to {:.4f}\n", name, least, most);
  }
  return lines;
}

ExperimentResult run_stability(const ExperimentOptions& options, Progress& progress) {
  const StabilityConfig config = stability_config(options);
  StabilityTables tables = measure_stability(config, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  if (tables.rows.size() > 0) {
    const double shown = config.ratios.size() > 1 ? config.ratios[1] : config.ratios.front();
    result.charts = {{"stability", cells_chart(tables.rows, config, shown)},
                     {"stability_damping", damping_chart(tables.rows, config)},
                     {"stability_real_time", speed_chart(tables.rows, config, shown)}};
  }
  result.summary = summary(tables.rows);
  result.tables = {{"stability", std::move(tables.rows)}};
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

namespace {

Table baseline_table(const BaselineOptions& options, Progress& progress) {
  StabilityConfig config = stability_config({.quick = options.quick});
  config.cells = options.quick ? std::vector<int>{2, 3} : std::vector<int>{2, 3, 4, 5};
  config.threads = options.threads;
  return measure_stability(config, progress)
      .rows.select({"integrator", "cells", "ratio", "omega_max", "sure", "predicted", "measured", "status"});
}

}  // namespace

ExperimentInfo experiment() {
  return {
      .name = "stability",
      .summary =
          "the largest step that holds, per integrator, against resolution and damping; and what was "
          "predicted",
      .accepts = {.cells = true, .largest_cells = 20, .integrators = limited_integrators, .seed = true},
      .run = run_stability,
      .baseline = {.keys = {"integrator", "cells", "ratio"},
                   .rules = {{"omega_max", 1e-7}, {"sure", 1e-9}, {"predicted", 1e-5}, {"measured", 0.008}},
                   .table = baseline_table}};
}

}  // namespace mss::studies::stability

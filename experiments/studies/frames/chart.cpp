// Charts and summaries of `mss frames`, from its tables alone.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/harness/table.hpp"
#include "experiments/studies/frames/frames.hpp"
#include "experiments/studies/frames/total.hpp"

namespace mss::studies::frames {

namespace {

/// The rows that no other of the same method beats in both time and error, by time.
std::vector<ChartPoint> envelope(const Table& rows, const std::string& cost, const std::string& error) {
  std::vector<ChartPoint> points, best;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.text(r, "status") == "ok") points.push_back({rows.number(r, cost), rows.number(r, error)});
  std::sort(points.begin(), points.end(), [](const ChartPoint& a, const ChartPoint& b) { return a.x < b.x; });
  for (const ChartPoint& point : points)
    if (best.empty() || point.y < best.back().y) best.push_back(point);
  return best;
}

std::string description(const Table& rows) {
  return FrameScene{.name = rows.text(0, "scene"),
                    .cells = int(rows.number(0, "cells")),
                    .young = rows.number(0, "young"),
                    .poisson = rows.number(0, "poisson"),
                    .damping_ratio = rows.number(0, "damping_ratio")}
      .description();
}

/// What failed, on the upper edge.
void add_failures(Chart& chart, const Table& rows, const std::string& cost) {
  for (const std::string& method : rows.distinct("method")) {
    const Table of_method = rows.where("method", method);
    for (const std::string& status : of_method.distinct("status")) {
      if (status == "ok") continue;
      ChartSeries series{.label = fmt::format("{}: {}", method, status), .points = {}, .lines = false};
      const Table failed = of_method.where("status", status);
      for (std::size_t r = 0; r < failed.size(); ++r)
        series.points.push_back({failed.number(r, cost), chart.y.high});
      chart.series.push_back(std::move(series));
    }
  }
}

Chart motion_chart(const Table& rows) {
  Chart chart{.title = "Error of a motion against the time it takes",
              .subtitle = fmt::format("a third of a second of a cantilevered cube; {}; one thread",
                                      description(rows)),
              .x = {.label = "wall time, set-up included", .logarithmic = true, .unit = "s"},
              .y = {.label = "error over displacement", .logarithmic = true, .high = 1}};
  for (const std::string& method : rows.distinct("method"))
    if (ChartSeries series{.label = method,
                           .points = envelope(rows.where("method", method), "seconds", "error")};
        !series.points.empty())
      chart.series.push_back(std::move(series));
  add_failures(chart, rows, "seconds");
  return chart;
}

/// Whether more iterations of a family are meant to come nearer to backward Euler.
bool seeks_backward_euler(const std::string& method) {
  return method.rfind("backward_euler/", 0) == 0 || method == "xpbd" || method.rfind("vbd", 0) == 0;
}

/// At one step a frame, of families with iterations.
Chart iterations_chart(const Table& rows) {
  Chart chart{.title = "Distance from converged backward Euler against iterations",
              .subtitle = fmt::format("a step a frame; cantilevered cube; {}", description(rows)),
              .x = {.label = "iterations a step", .logarithmic = true},
              .y = {.label = "distance over displacement", .logarithmic = true, .high = 1}};
  const Table single = rows.where("steps_per_frame", 1).where("kind", "family");
  for (const std::string& method : single.distinct("method")) {
    if (!seeks_backward_euler(method)) continue;
    const Table of_method = single.where("method", method);
    ChartSeries series{.label = method};
    for (std::size_t r = 0; r < of_method.size(); ++r)
      if (of_method.number(r, "iterations") > 0 && of_method.text(r, "status") == "ok")
        series.points.push_back({of_method.number(r, "iterations"), of_method.number(r, "distance")});
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  }
  return chart;
}

/// Of every method and scene: the least time to an error, over that of the fastest explicit method.
Chart scenes_chart(const Table& rows) {
  constexpr double error = 0.1;
  const std::vector<std::string> scenes = rows.distinct("scene");
  Chart chart{
      .title = "Time to a motion with an error of 10 percent",
      .subtitle =
          "a third of a second of a cantilevered cube; names end in cells an edge; no marker: error not "
          "reached",
      .x = {.label = "wall time / that of the fastest explicit method at its safe step", .logarithmic = true},
      .y = named_rows(scenes),
      .lines = {{ReferenceLine::Direction::vertical, 1, ""}}};
  for (const std::string& method : rows.distinct("method")) {
    ChartSeries series{.label = method, .joined = false};
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      const Table of_scene = rows.where("method", method).where("scene", scenes[i]).where("status", "ok");
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t r = 0; r < of_scene.size(); ++r)
        if (of_scene.number(r, "error") <= error)
          least = std::min(least, of_scene.number(r, "over_explicit"));
      if (std::isfinite(least)) series.points.push_back({least, double(scenes.size() - i)});
    }
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  }
  return chart;
}

Chart rest_chart(const Table& rows) {
  Chart chart{.title = "Finding where a cube hangs at rest",
              .subtitle = fmt::format("cantilevered cube; {} cells an edge, E = 1 MPa, ν = 0.3; one thread; "
                                      "errors below 1e-6 are drawn there",
                                      rows.number(0, "cells")),
              .x = {.label = "wall time from straight to rest", .logarithmic = true, .unit = "s"},
              .y = {.label = "error over displacement", .logarithmic = true, .low = 1e-6, .high = 1}};
  for (const std::string& method : rows.distinct("method")) {
    const Table of_method = rows.where("method", method);
    ChartSeries series{.label = method};
    for (std::size_t r = 0; r < of_method.size(); ++r)
      if (of_method.text(r, "status") == "ok")
        series.points.push_back(
            {of_method.number(r, "seconds"), std::max(of_method.number(r, "error"), chart.y.low)});
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  }
  add_failures(chart, rows, "seconds");
  return chart;
}

}  // namespace

Table frames_summary(const Table& rows) {
  Table summary({{"scene"},
                 {"error"},
                 {"method"},
                 {"iterations"},
                 {"steps_per_frame"},
                 {"seconds", "s"},
                 {"over_explicit"},
                 {"over_explicit_q1"},
                 {"over_explicit_q3"},
                 {"status"}});
  for (const std::string& scene : rows.distinct("scene"))
    for (const double error : {0.1, 0.05, 0.02, 0.01}) {
      const Table of_scene = rows.where("scene", scene).where("status", "ok");
      std::size_t best = of_scene.size();
      for (std::size_t r = 0; r < of_scene.size(); ++r)
        if (of_scene.number(r, "error") <= error &&
            (best == of_scene.size() || of_scene.number(r, "seconds") < of_scene.number(best, "seconds")))
          best = r;
      if (best == of_scene.size()) {
        summary.add({scene, error, "", no_value, no_value, no_value, no_value, no_value, no_value,
                     "no method tried reaches it"});
        continue;
      }
      const auto number = [&](const char* column) { return of_scene.number(best, column); };
      summary.add({scene, error, of_scene.text(best, "method"), std::int64_t(number("iterations")),
                   std::int64_t(number("steps_per_frame")), number("seconds"), number("over_explicit"),
                   number("over_explicit_q1"), number("over_explicit_q3"), "ok"});
    }
  return summary;
}

Table frames_iterations(const Table& rows) {
  Table table({{"scene"},
               {"method"},
               {"iterations_to_10_percent"},
               {"iterations_to_1_percent"},
               {"lowest_distance"},
               {"status"}});
  const auto needed = [](const Table& of_method, double distance) {
    double fewest = no_value;
    for (std::size_t r = of_method.size(); r-- > 0 && of_method.number(r, "distance") <= distance;)
      fewest = of_method.number(r, "iterations");
    return fewest;
  };
  for (const std::string& scene : rows.distinct("scene")) {
    const Table single = rows.where("scene", scene).where("steps_per_frame", 1).where("kind", "family");
    for (const std::string& method : single.distinct("method")) {
      const Table of_method = single.where("method", method);
      if (!seeks_backward_euler(method)) continue;
      double lowest = no_value;
      for (std::size_t r = 0; r < of_method.size(); ++r)
        lowest = std::fmin(lowest, of_method.number(r, "distance"));
      const double ten = needed(of_method, 0.1), one = needed(of_method, 0.01);
      std::string status = std::isfinite(one) ? "ok" : "not within 1 percent";
      if (!std::isfinite(ten)) status = "not within 10 percent";
      table.add({scene, method, ten, one, lowest, status});
    }
  }
  return table;
}

Drawings draw_frames(const std::vector<NamedTable>& tables) {
  const Table& rows = find_table(tables, "frames");
  const Table& rest = find_table(tables, "frames_rest");
  Drawings drawings;
  if (rows.size() == 0) return drawings;
  const auto charted = [&](const std::string& wanted) {
    return rows.where("scene", wanted).size() > 0 ? wanted : rows.text(0, "scene");
  };
  const std::string motion = charted("medium_7"), iterations = charted("soft_7");
  drawings.charts = {
      {"frames", scenes_chart(rows)},
      {"frames_" + motion, motion_chart(rows.where("scene", motion))},
      {"frames_iterations_" + iterations, iterations_chart(rows.where("scene", iterations)), "frames"}};
  if (rest.size() > 0) {
    const std::string largest = rest.text(rest.size() - 1, "scene");
    drawings.charts.push_back({"frames_rest_" + largest, rest_chart(rest.where("scene", largest))});
  }
  if (const auto totals = std::find_if(tables.begin(), tables.end(),
                                       [](const NamedTable& table) { return table.name == "frames_total"; });
      totals != tables.end())
    for (NamedChart& chart : total_charts(totals->table, find_table(tables, "frames_total_cells")))
      drawings.charts.push_back(std::move(chart));
  std::erase_if(drawings.charts, [](const NamedChart& chart) { return !has_points(chart.chart); });
  return drawings;
}

}  // namespace mss::studies::frames

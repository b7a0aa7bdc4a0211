// Charts of `mss validate rope`.
#include <fmt/format.h>

#include <cmath>

#include "experiments/studies/rope/rope.hpp"

namespace mss::studies::rope {

namespace {

ChartSeries errors(const Table& all, const char* cells, const char* error, std::string label) {
  ChartSeries series{.label = std::move(label)};
  const Table rows = all.where("status", "ok");
  for (std::size_t r = 0; r < rows.size(); ++r)
    series.points.push_back({rows.number(r, cells), rows.number(r, error)});
  return series;
}

/// Of second order, below a series, for the eye.
ChartSeries second_order(const ChartSeries& like) {
  ChartSeries line{.label = "second order", .marked = false};
  const ChartPoint& first = like.points.front();
  for (const ChartPoint& point : like.points)
    line.points.push_back({point.x, first.y / 2 * std::pow(first.x / point.x, 2)});
  return line;
}

Chart waves_chart(const Table& waves, const Table& pulses) {
  Chart chart{.title = "Ropes and sheets beside strings and membranes",
              .subtitle = "stretched by 5 percent, ends or rim held; error of the continuum's closed form",
              .x = {.label = "cells along it",
                    .logarithmic = true,
                    .low = 3,
                    .high = 200,
                    .ticks = {4, 8, 16, 32, 64, 128}},
              .y = {.label = "error", .logarithmic = true}};
  const auto add = [&](const char* body, const char* motion, const char* mode, std::string label) {
    const Table rows = waves.where("body", body).where("motion", motion).where("mode", mode);
    if (rows.size() > 0) chart.series.push_back(errors(rows, "cells", "error_continuum", std::move(label)));
  };
  add("rope", "across", "1", "rope, mode 1 (across, and along alike)");
  add("rope", "across", "3", "rope across, mode 3");
  add("sheet", "across", "1,1", "sheet across, mode 1,1");
  add("sheet", "across", "2,2", "sheet across, mode 2,2");
  if (pulses.size() > 0) chart.series.push_back(errors(pulses, "links", "error", "rope, speed of a pulse"));
  if (!chart.series.empty()) chart.series.push_back(second_order(chart.series.front()));
  return chart;
}

Chart catenary_chart(const Table& rows) {
  Chart chart{
      .title = "A rope that hangs, beside the catenary",
      .subtitle = "2 m long over 1.4 m, as good as inextensible",
      .x = {.label = "links", .logarithmic = true, .low = 6, .high = 200, .ticks = {8, 16, 32, 64, 128}},
      .y = {.label = "error", .logarithmic = true}};
  chart.series = {errors(rows, "links", "error_sag", "sag"),
                  errors(rows, "links", "error_pull", "pull along the line between its ends")};
  chart.series.push_back(second_order(chart.series.front()));
  return chart;
}

}  // namespace

Drawings draw_ropes(const std::vector<NamedTable>& tables) {
  Drawings drawings;
  const Table &waves = find_table(tables, "rope"), &pulses = find_table(tables, "rope_pulses"),
              &catenaries = find_table(tables, "rope_catenaries");
  if (waves.size() > 0) drawings.charts.push_back({"rope", waves_chart(waves, pulses)});
  if (catenaries.size() > 0) drawings.charts.push_back({"rope_catenaries", catenary_chart(catenaries)});
  return drawings;
}

}  // namespace mss::studies::rope

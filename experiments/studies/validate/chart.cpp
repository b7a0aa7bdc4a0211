// What `mss validate` draws.
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "experiments/studies/validate/validate.hpp"

namespace mss::studies::validate {

namespace {

/// Ticks at the numbers of cells that occur, and little room beside them.
void show_cells(ChartAxis& axis, const Chart& chart) {
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points) axis.ticks.push_back(point.x);
  std::sort(axis.ticks.begin(), axis.ticks.end());
  axis.ticks.erase(std::unique(axis.ticks.begin(), axis.ticks.end()), axis.ticks.end());
  if (axis.ticks.empty()) return;
  axis.low = 0.9 * axis.ticks.front();
  axis.high = 1.1 * axis.ticks.back();
}

/// A line where errors say no more, if they come anywhere near.
void show_doubt(Chart& chart, double doubt) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points) smallest = std::min(smallest, point.y);
  if (doubt <= 0 || smallest > 30 * doubt) return;
  chart.lines.push_back(
      {ReferenceLine::Direction::horizontal, doubt, "what the reference was extrapolated by"});
  chart.y.low = std::min(smallest, doubt) / 2;
}

}  // namespace

Chart validation_chart(const Table& rows, const ValidationConfig& config, const ValidationCase& c,
                       const std::string& against) {
  const bool time = against == "seconds";
  Chart chart{
      .title = time ? "What accuracy costs" : "What refining gains",
      .subtitle = fmt::format("{}; nu = {:g}; against {}", c.description, c.poisson, c.source),
      .x = {.label = time ? "wall time, from nothing to the answer" : "cells across the width",
            .logarithmic = true,
            .unit = time ? "s" : ""},
      .y = {.label = (c.large ? "difference of the " : "error of the ") + c.quantity, .logarithmic = true}};
  for (std::size_t m = 0; m < config.models.size(); ++m) {
    ChartSeries series{.label = config.models[m].name, .style = int(m)};
    bool present = false;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (rows.text(r, "case") != c.name || rows.text(r, "model") != config.models[m].name) continue;
      present = true;
      if (rows.text(r, "status") != "ok")
        series.label += fmt::format(" ({} at {} cells)", rows.text(r, "status"), rows.number(r, "cells"));
      else if (rows.number(r, "error") > validation_rounding)
        series.points.push_back({rows.number(r, against), rows.number(r, "error")});
    }
    if (present) chart.series.push_back(std::move(series));
  }
  if (!time) show_cells(chart.x, chart);
  show_doubt(chart, c.doubt);
  return chart;
}

Chart refinement_chart(const Table& refinement) {
  Chart chart{
      .title = "What refining the thesis's cube does",
      .subtitle =
          "cube of 1 m, k = 100, 100, 300 N/m at n = 5; pulled along an edge; sharing of springs as named",
      .x = {.label = "cells per edge, n", .logarithmic = true},
      .y = {.label = "Young's modulus [Pa]", .logarithmic = true}};
  for (const std::string& held : refinement.distinct("held"))
    for (const std::string& sharing : refinement.distinct("sharing")) {
      ChartSeries series{.label = fmt::format("{} held, {}", held, sharing)};
      for (std::size_t r = 0; r < refinement.size(); ++r)
        if (refinement.text(r, "held") == held && refinement.text(r, "sharing") == sharing &&
            refinement.text(r, "status") == "ok")
          series.points.push_back({refinement.number(r, "cells"), refinement.number(r, "young")});
      chart.series.push_back(std::move(series));
    }
  show_cells(chart.x, chart);
  return chart;
}

}  // namespace mss::studies::validate

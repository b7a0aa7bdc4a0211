// Charts of `mss validate`.
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "experiments/studies/validate/validate.hpp"

namespace mss::studies::validate {

namespace {

/// Ticks at the numbers of cells that occur, and a narrow margin beside them.
void show_cells(ChartAxis& axis, const Chart& chart) {
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points) axis.ticks.push_back(point.x);
  std::sort(axis.ticks.begin(), axis.ticks.end());
  axis.ticks.erase(std::unique(axis.ticks.begin(), axis.ticks.end()), axis.ticks.end());
  if (axis.ticks.empty()) return;
  axis.low = 0.9 * axis.ticks.front();
  axis.high = 1.1 * axis.ticks.back();
}

/// A line at the uncertainty of the reference, if any error comes near it.
void show_uncertainty(Chart& chart, double uncertainty) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points) smallest = std::min(smallest, point.y);
  if (uncertainty <= 0 || smallest > 30 * uncertainty) return;
  chart.lines.push_back({ReferenceLine::Direction::horizontal, uncertainty, "uncertainty of the reference"});
  chart.y.low = std::min(smallest, uncertainty) / 2;
}

/// One model's errors; failed runs are named in the legend.
ChartSeries errors_of(const Table& runs, const std::string& model, const char* column) {
  ChartSeries series{.label = model};
  for (std::size_t r = 0; r < runs.size(); ++r)
    if (runs.text(r, "status") != "ok")
      series.label += fmt::format(" ({} at {} cells)", runs.text(r, "status"), runs.number(r, "cells"));
    else if (runs.number(r, "error") > validation_rounding)
      series.points.push_back({runs.number(r, column), runs.number(r, "error")});
  return series;
}

}  // namespace

Chart validation_chart(const Table& rows, const Table& description, Abscissa abscissa) {
  const bool time = abscissa == Abscissa::seconds;
  const Table of_case = rows.where("case", description.text(0, "case"));
  const bool large = description.text(0, "deformations") == "large";
  Chart chart{.title = time ? "Error against wall time" : "Error against resolution",
              .subtitle = fmt::format("{}; nu = {:g}; reference: {}", description.text(0, "description"),
                                      description.number(0, "poisson"), description.text(0, "source")),
              .x = {.label = time ? "wall time of setup and solution" : "cells across the width",
                    .logarithmic = true,
                    .unit = time ? "s" : ""},
              .y = {.label = (large ? "relative difference of the " : "relative error of the ") +
                             description.text(0, "quantity"),
                    .logarithmic = true}};
  const std::vector<std::string> models = rows.distinct("model");  // a model has one style in all charts
  for (std::size_t m = 0; m < models.size(); ++m) {
    const Table runs = of_case.where("model", models[m]);
    if (runs.size() == 0) continue;
    chart.series.push_back(errors_of(runs, models[m], time ? "seconds" : "cells"));
    chart.series.back().style = int(m);
  }
  if (!time) show_cells(chart.x, chart);
  show_uncertainty(chart, description.number(0, "uncertainty"));
  return chart;
}

Chart refinement_chart(const Table& refinement) {
  Chart chart{.title = "Young's modulus of the thesis's cube against resolution",
              .subtitle =
                  "cube of 1 m, k = 100, 100, 300 N/m at n = 5; in tension along an edge; springs "
                  "shared by cells as named",
              .x = {.label = "cells per edge, n", .logarithmic = true},
              .y = {.label = "Young's modulus [Pa]", .logarithmic = true}};
  for (const std::string& constant : refinement.distinct("constant"))
    for (const std::string& sharing : refinement.distinct("sharing")) {
      ChartSeries series{.label = fmt::format("constant {}, {} sharing", constant, sharing)};
      for (std::size_t r = 0; r < refinement.size(); ++r)
        if (refinement.text(r, "constant") == constant && refinement.text(r, "sharing") == sharing &&
            refinement.text(r, "status") == "ok")
          series.points.push_back({refinement.number(r, "cells"), refinement.number(r, "young")});
      chart.series.push_back(std::move(series));
    }
  show_cells(chart.x, chart);
  return chart;
}

Drawings draw_validation(const std::vector<NamedTable>& tables) {
  const Table& rows = find_table(tables, "validate");
  const Table& cases = find_table(tables, "validate_cases");
  const Table& refinement = find_table(tables, "validate_refinement");
  const std::vector<std::string> measured = rows.distinct("case");
  Drawings drawings;
  for (const std::string& name : cases.distinct("case")) {
    const Table description = cases.where("case", name);
    if (description.text(0, "charted") != "yes" ||
        std::find(measured.begin(), measured.end(), name) == measured.end())
      continue;
    const bool first = drawings.charts.empty();
    drawings.charts.push_back({first ? "validate" : "validate_" + name + "_seconds",
                               validation_chart(rows, description, Abscissa::seconds)});
    drawings.charts.push_back(
        {"validate_" + name + "_cells", validation_chart(rows, description, Abscissa::cells)});
  }
  if (refinement.size() > 0) drawings.charts.push_back({"validate_refinement", refinement_chart(refinement)});
  return drawings;
}

}  // namespace mss::studies::validate

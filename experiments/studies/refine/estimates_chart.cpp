// Charts of estimates: raw, corrected and extrapolated errors against cells.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/studies/refine/refine.hpp"

namespace mss::studies::refine {

namespace {

/// Magnitudes; where the error changes its sign a curve has a gap in a logarithmic axis only at zero itself.
ChartSeries errors_of(const Table& rows, const std::string& label, const char* column) {
  ChartSeries series{.label = label};
  for (std::size_t r = 0; r < rows.size(); ++r)
    series.points.push_back({rows.number(r, "cells"), std::abs(rows.number(r, column))});
  return series;
}

Chart estimate_chart(const Table& rows, const std::string& description, double uncertainty) {
  Chart chart{.title = fmt::format("A displacement as computed, corrected, extrapolated: {}",
                                   rows.text(0, "problem")),
              .subtitle = fmt::format("{}; nu = 0.3", description),
              .x = {.label = "cells across 1 m", .logarithmic = true},
              .y = {.label = "relative error", .logarithmic = true}};
  for (const double face_share : rows.distinct_numbers("face_share")) {
    const Table of_share = rows.where("face_share", face_share);
    const std::string springs = fmt::format("t = {:g}: ", face_share);
    chart.series.push_back(errors_of(of_share, springs + "as computed", "raw_error"));
    chart.series.push_back(errors_of(of_share, springs + "corrected", "corrected_error"));
    chart.series.push_back(errors_of(of_share, springs + "Richardson, order 2", "richardson_error"));
  }
  chart.x.ticks = rows.distinct_numbers("cells");
  if (chart.x.ticks.empty()) return chart;
  chart.x.low = 0.9 * chart.x.ticks.front();
  chart.x.high = 1.1 * chart.x.ticks.back();
  double smallest = 1;
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points) smallest = std::min(smallest, point.y);
  if (uncertainty > smallest / 10)
    chart.lines.push_back(
        {ReferenceLine::Direction::horizontal, uncertainty, "uncertainty of the reference"});
  return chart;
}

}  // namespace

std::vector<NamedChart> estimate_charts(const Table& rows, const Table& references) {
  std::vector<NamedChart> charts;
  for (std::size_t r = 0; r < references.size(); ++r) {
    const std::string& problem = references.text(r, "problem");
    const Table of_problem = rows.where("problem", problem).where("status", "ok");
    if (of_problem.size() == 0) continue;
    std::string name = "refine" + (r == 0 ? "" : "_" + problem);
    std::replace(name.begin(), name.end(), ' ', '_');
    charts.push_back({name, estimate_chart(of_problem, references.text(r, "description"),
                                           references.number(r, "uncertainty"))});
  }
  return charts;
}

}  // namespace mss::studies::refine

#include "experiments/fit/chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace mss::fit {

namespace {

/// The values that were fitted, in a line: without the table of their keys, so that four fit on a chart.
std::string fitted_values(const Table& parameters) {
  std::string text;
  for (std::size_t row = 0; row < parameters.size(); ++row) {
    const std::string& key = parameters.text(row, "parameter");
    text += fmt::format("{}{} = {:.4g}", row == 0 ? "" : ", ", key.substr(key.find('.') + 1),
                        parameters.number(row, "fitted"));
  }
  return text;
}

/// Single values, a row each.
Chart chart_of_values(const Table& data, const std::string& subtitle) {
  std::vector<std::string> names;
  std::vector<double> residuals;
  for (std::size_t row = 0; row < data.size(); ++row) {
    if (data.text(row, "kind") == "series") continue;
    names.push_back(fmt::format("{}: {:.4g} {}", data.text(row, "observation"), data.number(row, "measured"),
                                data.text(row, "unit")));
    residuals.push_back(data.number(row, "residual") / data.number(row, "uncertainty"));
  }
  Chart chart{.title = "Fit beside single values that were measured",
              .subtitle = subtitle,
              .x = {.label = "measured less fitted, over the uncertainty (dotted: -1, 0, 1)"},
              .y = named_rows(names)};
  ChartSeries series{.joined = false};
  double widest = 2;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    series.points.push_back({residuals[i], double(residuals.size() - i)});
    widest = std::max(widest, 1.1 * std::abs(residuals[i]));
  }
  chart.x.low = -widest;
  chart.x.high = widest;
  chart.series = {series};
  for (const double at : {-1.0, 0.0, 1.0})
    chart.lines.push_back({ReferenceLine::Direction::vertical, at, ""});
  return chart;
}

Chart chart_of_series(const Table& data, const std::string& name, const std::string& subtitle) {
  const Table rows = data.where("observation", name);
  const std::string& unit = rows.text(0, "unit");
  Chart chart{.title = fmt::format("Fit beside what was measured: {}", name),
              .subtitle = subtitle,
              .x = {.label = "time [s]"},
              .y = {.label = rows.text(0, "column") + (unit.empty() ? "" : fmt::format(" [{}]", unit))},
              .series = {{.label = "measured", .joined = false}, {.label = "fitted"}}};
  for (std::size_t row = 0; row < rows.size(); ++row) {
    chart.series[0].points.push_back({rows.number(row, "time"), rows.number(row, "measured")});
    chart.series[1].points.push_back({rows.number(row, "time"), rows.number(row, "fitted")});
  }
  return chart;
}

}  // namespace

Drawings draw(const std::vector<NamedTable>& tables) {
  const Table &parameters = find_table(tables, "fit"), &data = find_table(tables, "fit_data");
  const std::string subtitle = fitted_values(parameters);
  Drawings drawings;
  bool has_values = false;
  int number = 0;
  for (const std::string& name : data.distinct("observation")) {
    if (data.where("observation", name).text(0, "kind") == "series")
      drawings.charts.push_back(
          {fmt::format("fit_series_{}", ++number), chart_of_series(data, name, subtitle), "fit_data"});
    else
      has_values = true;
  }
  if (has_values)
    drawings.charts.insert(drawings.charts.begin(), {"fit", chart_of_values(data, subtitle), "fit_data"});
  return drawings;
}

}  // namespace mss::fit

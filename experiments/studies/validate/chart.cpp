// Charts of `mss validate`.
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

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

namespace {

/// The finest resolution that every charted case was measured at.
double common_cells(const Table& rows, const std::vector<std::string>& cases) {
  double finest = 0;
  for (const double cells : rows.distinct_numbers("cells")) {
    const bool all = std::all_of(cases.begin(), cases.end(), [&](const std::string& name) {
      return rows.where("case", name).where("cells", cells).size() > 0;
    });
    if (all) finest = std::max(finest, cells);
  }
  return finest;
}

/// Charted cases that were measured, in the order of their table.
std::vector<std::string> charted_cases(const Table& rows, const Table& cases) {
  std::vector<std::string> names = cases.where("charted", "yes").distinct("case");
  const std::vector<std::string> measured = rows.distinct("case");
  std::erase_if(names, [&](const std::string& name) {
    return std::find(measured.begin(), measured.end(), name) == measured.end();
  });
  return names;
}

}  // namespace

Chart cases_chart(const Table& rows, const Table& cases) {
  const std::vector<std::string> names = charted_cases(rows, cases);
  const double cells = common_cells(rows, names);
  std::vector<std::string> shown;
  for (std::string name : names) {
    std::replace(name.begin(), name.end(), '_', ' ');
    shown.push_back(name == "cantilever 45" ? "cantilever, nu = 0.45" : name);
  }
  Chart chart{.title = "Error of springs and of elements, by case",
              .subtitle = fmt::format("{:g} cells across the width; where deformations are large, relative "
                                      "difference from St. Venant's and Kirchhoff's law",
                                      cells),
              .x = {.label = "relative error", .logarithmic = true},
              .y = named_rows(shown)};
  const std::vector<std::string> models = rows.distinct("model");
  for (std::size_t m = 0; m < models.size(); ++m) {
    ChartSeries series{.label = models[m], .style = int(m), .joined = false};
    const Table of_model = rows.where("model", models[m]).where("cells", cells).where("status", "ok");
    for (std::size_t i = 0; i < names.size(); ++i)
      if (const Table run = of_model.where("case", names[i]);
          run.size() > 0 && run.number(0, "error") > validation_rounding)
        series.points.push_back({run.number(0, "error"), chart.y.ticks[i]});
    chart.series.push_back(std::move(series));
  }
  return chart;
}

Chart large_strain_chart(const Table& strains) {
  Chart chart{.title = "Springs at large strain beside laws of elasticity",
              .subtitle =
                  "a bar with free sides, as far as its lattice is stable; same E; nu = 0.3 but where said "
                  "and for the "
                  "thesis's springs",
              .x = {.label = "strain along the bar"},
              .y = {.label = "nominal stress / that of a neo-Hookean solid"}};
  const std::vector<std::string> models = strains.distinct("springs");
  for (std::size_t m = 0; m < models.size(); ++m) {
    const Table of_model = strains.where("springs", models[m]).where("status", "ok");
    ChartSeries limit{.label = models[m], .style = int(m)};
    for (std::size_t r = 0; r < of_model.size(); ++r)
      limit.points.push_back({of_model.number(r, "strain"),
                              of_model.number(r, "stress") / of_model.number(r, "neo_hookean_stress")});
    chart.series.push_back(std::move(limit));
  }
  ChartSeries quadratic{.label = "St. Venant-Kirchhoff", .style = int(models.size())};
  const Table first = strains.where("springs", models.front()).where("status", "ok");
  for (std::size_t r = 0; r < first.size(); ++r)
    quadratic.points.push_back({first.number(r, "strain"), first.number(r, "st_venant_kirchhoff_stress") /
                                                               first.number(r, "neo_hookean_stress")});
  chart.series.push_back(std::move(quadratic));
  chart.lines.push_back({ReferenceLine::Direction::horizontal, 1, "neo-Hookean"});
  return chart;
}

Drawings draw_validation(const std::vector<NamedTable>& tables) {
  const Table& rows = find_table(tables, "validate");
  const Table& cases = find_table(tables, "validate_cases");
  const Table& refinement = find_table(tables, "validate_refinement");
  Drawings drawings;
  const std::vector<std::string> names = charted_cases(rows, cases);
  if (!names.empty()) {
    drawings.charts.push_back({"validate", cases_chart(rows, cases)});
    const Table first = cases.where("case", names.front());
    for (const auto& [abscissa, name] : {std::pair{Abscissa::cells, "cells"}, {Abscissa::seconds, "seconds"}})
      drawings.charts.push_back(
          {fmt::format("validate_{}_{}", names.front(), name), validation_chart(rows, first, abscissa)});
  }
  for (const auto& [name, table] : tables)  // results of earlier versions have none
    if (name == "validate_large_strain" && table.size() > 0)
      drawings.charts.push_back({name, large_strain_chart(table)});
  for (const auto& [name, table] : tables)
    if (name == "validate_estimates" && table.size() > 0)
      drawings.charts.push_back({name, estimates_chart(table, cases)});
  if (refinement.size() > 0) drawings.charts.push_back({"validate_refinement", refinement_chart(refinement)});
  return drawings;
}

}  // namespace mss::studies::validate

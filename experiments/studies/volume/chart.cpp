// Charts of `mss volume`.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>
#include <utility>

#include "experiments/studies/volume/volume.hpp"

namespace mss::studies::volume {

namespace {

using RowNumber = std::function<double(const Table& rows, std::size_t row)>;

double drift(const Table& rows, std::size_t r) { return rows.number(r, "drift"); }
double drift_over_strain(const Table& rows, std::size_t r) {
  return rows.number(r, "drift") / rows.number(r, "strain");
}

/// The numbers of a column, in ascending order.
std::set<double> values(const Table& rows, const char* column) {
  std::set<double> all;
  for (std::size_t r = 0; r < rows.size(); ++r) all.insert(rows.number(r, column));
  return all;
}

/// One model's rows of a study; failed runs are named in the legend.
ChartSeries series_of(const Table& rows, const std::string& model, const char* x, const RowNumber& y) {
  ChartSeries series{.label = model};
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows.text(r, "model") != model) continue;
    if (rows.text(r, "status") == "ok")
      series.points.push_back({rows.number(r, x), y(rows, r)});
    else
      series.label += fmt::format(" ({} at {:g})", rows.text(r, "status"), rows.number(r, x));
  }
  return series;
}

void add_models(Chart& chart, const Table& rows, const char* x, const RowNumber& y) {
  for (const std::string& model : rows.distinct("model"))
    chart.series.push_back(series_of(rows, model, x, y));
}

/// Rows that elasticity predicts, and with particles that are not clamped.
Table predicted_rows(const Table& rows) {
  Table some(rows.columns());
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.number(r, "predicted") != 0 && rows.number(r, "cells") > 1) some.add(rows.rows()[r]);
  return some;
}

Chart cells_chart(const Table& all) {
  const Table rows = predicted_rows(all);
  Chart chart{
      .title = "Error of the change of volume of a stretched cube",
      .subtitle = "cube of 1 m, ends clamped; left out: the thesis's springs, which are not isotropic",
      .x = {.label = "cells per edge, n", .logarithmic = true},
      .y = {.label = "| change of volume / that of elasticity - 1 |", .logarithmic = true}};
  if (rows.size() == 0) return chart;
  add_models(chart, rows, "cells", [](const Table& of, std::size_t r) {
    return std::abs(drift(of, r) / of.number(r, "predicted") - 1);
  });
  const std::set<double> cells = values(rows, "cells");
  chart.x.ticks.assign(cells.begin(), cells.end());
  chart.x.low = 0.9 * *cells.begin();
  chart.x.high = 1.1 * *cells.rbegin();
  return chart;
}

Chart twist_chart(const Table& rows) {
  Chart chart{.title = "Change of volume against twist",
              .subtitle = fmt::format("cube of 1 m, {} cells per edge, ends clamped, one rotated; by "
                                      "elasticity 0 to first order",
                                      rows.number(0, "cells")),
              .x = {.label = "angle [degrees]"},
              .y = {.label = "change of volume / volume"}};
  add_models(chart, rows, "angle", drift);
  return chart;
}

Chart tension_chart(const Table& rows) {
  Chart chart{
      .title = "Change of volume in large tension",
      .subtitle = fmt::format("cube of 1 m, {} cells per edge, plates without friction; curves end where "
                              "the cube has no stable equilibrium",
                              rows.number(0, "cells")),
      .x = {.label = "strain"},
      .y = {.label = "change of volume / strain"}};
  for (const std::string& model : rows.distinct("model")) {
    ChartSeries series{.label = model};
    bool ended = false;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (rows.text(r, "model") != model) continue;
      if (rows.text(r, "status") == "ok")
        series.points.push_back({rows.number(r, "strain"), drift_over_strain(rows, r)});
      else if (!std::exchange(ended, true))
        series.label += fmt::format(" (no longer stable at {:g})", rows.number(r, "strain"));
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

/// In terms of k_vol all isotropic materials have the same Poisson's ratio: k_vol = lambda - mu, so
/// nu = (1 + r) / (4 + 2 r) with r = k_vol / mu.
ChartSeries prediction(double low, double high) {
  ChartSeries line{.label = "elasticity: 1 - 2 nu, k_vol = lambda - mu"};
  for (double r = low; r <= high * 1.001; r *= std::pow(high / low, 1.0 / 30))
    line.points.push_back({r, 1 - 2 * (1 + r) / (4 + 2 * r)});
  return line;
}

/// Adds the models of one filling; the thesis's own values of k_vol are marked.
void add_filling(Chart& chart, const Table& rows, const Table& models, const std::string& filling) {
  ChartSeries series{.label = filling};
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::string& model = rows.text(r, "model");
    if (models.where("filling", filling).where("model", model).size() == 0) continue;
    if (rows.text(r, "status") != "ok") {
      series.label += fmt::format(" ({}: {})", model, rows.text(r, "status"));
      continue;
    }
    const double share = rows.number(r, "k_vol_over_shear"), swelling = drift_over_strain(rows, r);
    if (share > 1e-9) series.points.push_back({share, swelling});
    if (filling != to_string(Filling::thesis_springs)) continue;
    if (rows.number(r, "k_vol") == 0.1)
      chart.marks.push_back({{share, swelling}, "the thesis's k_vol = 0.1"});
    if (rows.number(r, "k_vol") == 0)
      chart.lines.push_back({ReferenceLine::Direction::horizontal, swelling, ""});
  }
  if (!series.points.empty() || series.label != filling) chart.series.push_back(std::move(series));
}

Chart volume_force_chart(const Table& rows, const Table& models) {
  Chart chart{.title = "Effect of the volume force",
              .subtitle = fmt::format(
                  "cube of 1 m, {} cells per edge, plates without friction, strain {:g} %; dotted: "
                  "thesis's springs, k_vol = 0",
                  rows.number(0, "cells"), 100 * rows.number(0, "strain")),
              .x = {.label = "k_vol / shear modulus", .logarithmic = true},
              .y = {.label = "change of volume / strain", .low = 0}};
  for (const std::string& filling : models.distinct("filling")) add_filling(chart, rows, models, filling);
  chart.series.push_back(prediction(1e-5, 100));
  return chart;
}

/// Error of the volume against the step; the first failed step is named in the legend.
Chart steps_chart(const Table& rows, const std::vector<NamedTable>& tables) {
  Chart chart{
      .title = "Error of the volume against the step",
      .subtitle = "springs, nu = 0.45; the cube falls and bounces; against RK4 with fine steps",
      .x = {.label = "step / the limit that is guaranteed to central differences", .logarithmic = true},
      .y = {.label = "largest error of the change of volume", .logarithmic = true}};
  for (const auto& [name, table] : tables)  // results of earlier versions have none
    if (name == "volume_limit" && table.size() > 0)
      chart.lines.push_back(
          {ReferenceLine::Direction::vertical, table.number(0, "limit_over_guaranteed"), "limit at rest"});
  Table runs(rows.columns());  // neither reference runs nor adaptive methods
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.number(r, "step") > reference_bounce_step) runs.add(rows.rows()[r]);
  for (const std::string& integrator : runs.distinct("integrator")) {
    ChartSeries series{.label = integrator};
    bool failed = false;
    for (std::size_t r = 0; r < runs.size(); ++r) {
      if (runs.text(r, "integrator") != integrator) continue;
      const double step = runs.number(r, "step");
      if (runs.text(r, "status") == "ok")
        series.points.push_back({step, runs.number(r, "difference")});
      else if (!std::exchange(failed, true))
        series.label += fmt::format(" ({} at {:g})", runs.text(r, "status"), step);
    }
    chart.series.push_back(std::move(series));
  }
  const std::set<double> steps = values(runs, "step");
  chart.x.ticks.assign(steps.begin(), steps.end());
  return chart;
}

}  // namespace

Drawings draw_volume(const std::vector<NamedTable>& tables) {
  const Table &rows = find_table(tables, "volume"), &models = find_table(tables, "volume_models");
  const auto of = [&](Study study) { return rows.where("study", to_string(study)); };
  Drawings drawings;
  if (const Table cells = of(Study::cells); cells.size() > 0)
    drawings.charts.push_back({"volume", cells_chart(cells)});
  if (const Table twists = of(Study::twist); twists.size() > 0)
    drawings.charts.push_back({"volume_twist", twist_chart(twists)});
  if (const Table tensions = of(Study::tension); tensions.size() > 0)
    drawings.charts.push_back({"volume_tension", tension_chart(tensions)});
  if (const Table free = of(Study::free); free.size() > 0)
    drawings.charts.push_back({"volume_k_vol", volume_force_chart(free, models)});
  if (const Table bounces = of(Study::bounce); bounces.size() > 0)
    drawings.charts.push_back({"volume_steps", steps_chart(bounces, tables)});
  return drawings;
}

}  // namespace mss::studies::volume

// What `mss volume` draws.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <utility>

#include "experiments/studies/volume/volume.hpp"
#include "reference/calculix/calculix.hpp"

namespace mss::studies::volume {

namespace {

using RowNumber = std::function<double(std::size_t row)>;

/// A study's rows of one model; what failed is named in the legend.
ChartSeries series_of(const Table& rows, const std::string& study, const std::string& model,
                      const std::string& x, const RowNumber& y) {
  ChartSeries series{.label = model};
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows.text(r, "study") != study || rows.text(r, "model") != model) continue;
    if (rows.text(r, "status") == "ok")
      series.points.push_back({rows.number(r, x), y(r)});
    else
      series.label += fmt::format(" ({} at {:g})", rows.text(r, "status"), rows.number(r, x));
  }
  return series;
}

double swelling(double poisson) {
  return reference::calculix_value("glued_stretch", poisson, "swelling").value;
}

Chart cells_chart(const Table& rows, const VolumeConfig& config) {
  Chart chart{
      .title = "How much a pulled cube swells",
      .subtitle = fmt::format("cube of 1 m, ends glued, pulled by {:g} %; lines are what elasticity predicts",
                              100 * config.small_strain),
      .x = {.label = "cells per edge, n", .logarithmic = true},
      .y = {.label = "change of volume / strain"}};
  for (const VolumeModel& m : config.models)
    chart.series.push_back(series_of(rows, "cells", m.name, "cells", [&](std::size_t r) {
      return rows.number(r, "drift") / rows.number(r, "strain");
    }));
  for (const double nu : {0.3, 0.45})
    chart.lines.push_back(
        {ReferenceLine::Direction::horizontal, swelling(nu), fmt::format("elasticity, nu = {:g}", nu)});
  for (const int n : config.cells) chart.x.ticks.push_back(n);
  chart.x.low = 0.9 * config.cells.front();
  chart.x.high = 1.1 * config.cells.back();
  return chart;
}

Chart strain_chart(const Table& rows, const VolumeConfig& config) {
  Chart chart{
      .title = "Volume against strain",
      .subtitle = fmt::format("cube of 1 m, {} cells per edge, ends glued; predictions are tangents at 0",
                              config.study_cells),
      .x = {.label = "strain"},
      .y = {.label = "change of volume / volume"}};
  for (const VolumeModel& m : config.models)
    chart.series.push_back(
        series_of(rows, "strain", m.name, "strain", [&](std::size_t r) { return rows.number(r, "drift"); }));
  const auto [low, high] = std::minmax_element(config.strains.begin(), config.strains.end());
  for (const double nu : {0.3, 0.45})
    chart.series.push_back({.label = fmt::format("elasticity, nu = {:g}, to first order", nu),
                            .points = {{*low, swelling(nu) * *low}, {*high, swelling(nu) * *high}}});
  return chart;
}

Chart twist_chart(const Table& rows, const VolumeConfig& config) {
  Chart chart{.title = "Volume against twist",
              .subtitle = fmt::format(
                  "cube of 1 m, {} cells per edge, ends glued, one turned; to first order elasticity says 0",
                  config.study_cells),
              .x = {.label = "angle [degrees]"},
              .y = {.label = "change of volume / volume"}};
  for (const VolumeModel& m : config.models)
    chart.series.push_back(
        series_of(rows, "twist", m.name, "angle", [&](std::size_t r) { return rows.number(r, "drift"); }));
  return chart;
}

/// One model's volume three ways: exactly, by the thesis's estimate, and of the worst cell.
Chart local_chart(const Table& rows, const VolumeConfig& config, const VolumeModel& model) {
  Chart chart{.title = "The whole, its estimate and its worst cell",
              .subtitle = fmt::format("{}; cube of 1 m, {} cells per edge, ends glued, one turned",
                                      model.name, config.study_cells),
              .x = {.label = "angle [degrees]"},
              .y = {.label = "change of volume / volume, without sign", .logarithmic = true}};
  const auto add = [&](const std::string& column, const std::string& label) {
    ChartSeries series = series_of(rows, "twist", model.name, "angle",
                                   [&](std::size_t r) { return std::abs(rows.number(r, column)); });
    series.label = label;
    chart.series.push_back(std::move(series));
  };
  add("drift", "exact volume");
  add("drift_thesis", "the thesis's estimate (3-5, 3-6)");
  add("worst_cell", "the worst cell, exact");
  return chart;
}

std::string kind_of(const std::string& model) { return model.substr(0, model.find(',')); }

/// The same place in Poisson's ratio for all isotropic materials: k_vol = lambda - mu, so
/// nu = (1 + r) / (4 + 2 r) with r = k_vol / mu.
ChartSeries prediction(double low, double high) {
  ChartSeries line{.label = "elasticity: 1 - 2 nu, k_vol = lambda - mu"};
  for (double r = low; r <= high * 1.001; r *= std::pow(high / low, 1.0 / 30))
    line.points.push_back({r, 1 - 2 * (1 + r) / (4 + 2 * r)});
  return line;
}

Chart stiffness_chart(const Table& rows, const VolumeConfig& config) {
  Chart chart{
      .title = "What a volume force does",
      .subtitle = fmt::format(
          "cube of 1 m, {} cells per edge, plates without friction, pulled by {:g} %; dotted: the thesis's "
          "without volume force",
          config.study_cells, 100 * config.tiny_strain),
      .x = {.label = "k_vol / shear modulus", .logarithmic = true},
      .y = {.label = "change of volume / strain", .low = 0}};
  std::vector<std::string> kinds;
  for (const VolumeModel& m : config.materials)
    if (std::find(kinds.begin(), kinds.end(), kind_of(m.name)) == kinds.end())
      kinds.push_back(kind_of(m.name));
  for (const std::string& kind : kinds) {
    ChartSeries series{.label = kind};
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (rows.text(r, "study") != "free" || kind_of(rows.text(r, "model")) != kind) continue;
      if (rows.text(r, "status") != "ok") {
        series.label += fmt::format(" ({}: {})", rows.text(r, "model"), rows.text(r, "status"));
        continue;
      }
      const double share = rows.number(r, "k_vol_over_shear");
      const double swells = rows.number(r, "drift") / rows.number(r, "strain");
      if (share > 1e-9) series.points.push_back({share, swells});
      if (rows.text(r, "model") == "thesis's, k_vol = 0.1")
        chart.marks.push_back({{share, swells}, "the thesis's k_vol = 0.1"});
      if (rows.text(r, "model") == "thesis's, k_vol = 0")
        chart.lines.push_back({ReferenceLine::Direction::horizontal, swells, ""});
    }
    chart.series.push_back(std::move(series));
  }
  chart.series.push_back(prediction(1e-5, 100));
  return chart;
}

Chart bounce_chart(const Table& bounce, const VolumeConfig& config) {
  Chart chart{.title = "Volume of a bouncing cube",
              .subtitle = "cube of 1 m, 4 cells per edge, falls a little askew at 0.5 m/s; RK4, fine steps",
              .x = {.label = "time [s]"},
              .y = {.label = "change of volume / volume"}};
  for (const VolumeModel& m : config.models) {
    ChartSeries series{.label = m.name};
    for (std::size_t r = 0; r < bounce.size(); ++r)
      if (bounce.text(r, "model") == m.name && bounce.text(r, "integrator") == "rk4" &&
          bounce.number(r, "step") == exact_bounce_step)
        series.points.push_back({bounce.number(r, "t"), bounce.number(r, "drift")});
    chart.series.push_back(std::move(series));
  }
  return chart;
}

/// Error of the volume against the step; what failed is named in the legend by its first step.
Chart steps_chart(const Table& rows, const VolumeConfig& config) {
  Chart chart{.title = "What the step does to volume",
              .subtitle = "springs, nu = 0.45; the cube falls and bounces; against RK4 with fine steps",
              .x = {.label = "step / limit of central differences", .logarithmic = true},
              .y = {.label = "largest error of the change of volume", .logarithmic = true}};
  chart.x.ticks = config.step_shares;
  for (const std::string& integrator : config.integrators) {
    ChartSeries series{.label = integrator};
    bool failed = false;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (rows.text(r, "study") != "bounce" || rows.text(r, "integrator") != integrator ||
          rows.number(r, "step") < config.step_shares.front())
        continue;
      if (rows.text(r, "status") == "ok")
        series.points.push_back({rows.number(r, "step"), rows.number(r, "difference")});
      else if (!std::exchange(failed, true))
        series.label += fmt::format(" ({} at {:g})", rows.text(r, "status"), rows.number(r, "step"));
    }
    if (failed || !series.points.empty()) chart.series.push_back(std::move(series));
  }
  return chart;
}

}  // namespace

std::vector<NamedChart> volume_charts(const VolumeTables& tables, const VolumeConfig& config) {
  const Table& rows = tables.rows;
  const std::vector<std::string> studies = rows.distinct("study");
  const auto done = [&](const char* study) {
    return std::find(studies.begin(), studies.end(), study) != studies.end();
  };
  std::vector<NamedChart> charts;
  if (done("cells")) charts.push_back({"volume", cells_chart(rows, config)});
  if (done("strain")) charts.push_back({"volume_strain", strain_chart(rows, config)});
  if (done("twist")) {
    charts.push_back({"volume_twist", twist_chart(rows, config)});
    for (const VolumeModel& m : config.models)
      if (m.model == spring_model && m.poisson == 0.45)
        charts.push_back({"volume_local", local_chart(rows, config, m)});
  }
  if (done("free")) charts.push_back({"volume_k_vol", stiffness_chart(rows, config)});
  if (done("bounce")) {
    charts.push_back({"volume_bounce", bounce_chart(tables.bounce, config)});
    charts.push_back({"volume_steps", steps_chart(rows, config)});
  }
  return charts;
}

}  // namespace mss::studies::volume

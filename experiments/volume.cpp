// What happens to a body's volume: drift against cube resolution, strain and the stiffness of the volume
// force, for the thesis's springs, calibrated ones and finite elements, beside what elasticity predicts.
// Elasticity lets volume change: a material of Poisson's ratio nu swells when pulled, by (1 - 2 nu) of the
// strain where its ends may narrow. Less drift is right only if it is that much less.
#include "experiments/volume.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "core/measures.hpp"
#include "experiments/equilibrium.hpp"
#include "experiments/model.hpp"
#include "reference/calculix/calculix.hpp"

namespace mss {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

BodyConfig cube(const VolumeModel& model, int n) {
  BodyConfig body{.voxels = VoxelGrid::box(n, n, n), .cell_size = 1.0 / n};
  if (model.elastic) {
    body.fill(*model.elastic, 0.5);
  } else {  // the material that they are at five cells per edge
    const double k = 100 * 5.0 / n;
    body.springs = {.edge = k, .face = k, .body = 3 * k, .volume = model.thesis_volume};
  }
  return body;
}

/// Both ends glued, the upper one moved.
Environment pulled(double strain) {
  return {.holds = {{.box = {{0, 0, 0}, {1, 1, 0}}},
                    {.box = {{0, 0, 1}, {1, 1, 1}}, .displacement = {0, 0, strain}}}};
}

/// Largest change of a cell's volume, over its volume at rest.
double worst_cell(const Body& body, const Field<double>& x) {
  double worst = 0;
  body.for_each_cell([&](std::ptrdiff_t site) {
    worst = std::max(worst, std::abs(trilinear_volume(corners_of(body, x, site)) / body.cell_volume() - 1));
  });
  return worst;
}

Table empty_rows() {
  return Table({{"study"},
                {"model"},
                {"cells"},
                {"strain"},
                {"k_vol", "Pa"},
                {"drift"},
                {"drift_paper"},
                {"worst_cell"},
                {"predicted"},
                {"status"}});
}

void add_row(Table& rows, const std::string& study, const VolumeModel& model, int n, double strain) {
  const Body body(cube(model, n));
  const auto system = make_system<double>(model.model, body, pulled(strain), 1);
  const auto stretched = [strain](const Vec3& rest) -> Vec3 {
    return {rest[0], rest[1], (1 + strain) * rest[2]};
  };
  const auto [status, state] = find_equilibrium(*system, stretched);
  const bool ok = status == Status::ok;
  const Measures m = measure(*system, state);
  rows.add({study, model.name, n, strain, body.config().springs.volume, ok ? m.volume_ratio - 1 : none,
            ok ? m.volume_ratio_paper - 1 : none, ok ? worst_cell(body, state.x) : none,
            model.small_change * strain, std::string(to_string(status))});
}

VolumeModel thesis(double k_vol) {
  return {
      .name = fmt::format("thesis's, k_vol = {:g}", k_vol), .model = spring_model, .thesis_volume = k_vol};
}

VolumeModel material(const std::string& name, const std::string& model, double poisson) {
  return {.name = fmt::format("{}, nu = {:g}", name, poisson),
          .model = model,
          .elastic = ElasticConstants{.young = 1416.67, .poisson = poisson},
          .small_change = reference::calculix_value("glued_stretch", poisson, "swelling").value};
}

Json configuration(const VolumeConfig& c) {
  Json models = Json::array();
  for (const VolumeModel& m : c.models)
    models.push_back({{"name", m.name}, {"model", m.model}, {"swelling_predicted", m.small_change}});
  return {{"body", "cube of 1 m, both ends glued, one pulled along an edge; at rest"},
          {"models", models},
          {"cells", c.cells},
          {"small_strain", c.small_strain},
          {"strains", c.strains},
          {"k_vol", c.stiffness},
          {"large_strain", c.large_strain},
          {"study_cells", c.study_cells},
          {"prediction", "CalculiX C3D20, to first order in the strain"},
          {"threads", 1}};
}

constexpr const char* caption =
    "Change of a cube's volume at equilibrium, its ends glued and pulled apart or together. Elasticity "
    "itself "
    "lets volume change: the prediction is that of quadratic finite elements (CalculiX), to first order in "
    "the "
    "strain, for that Poisson's ratio; less drift than that is wrong too. The thesis's springs keep the "
    "material that they are at five cells per edge. Volumes are exact (trilinear cells); the thesis's own "
    "estimate and the worst cell are in the table. Left out so far: twist, bounce, motion, other volume "
    "forces.";

ChartSeries series_of(const Table& rows, const std::string& study, const std::string& model,
                      const std::string& x, const std::function<double(std::size_t)>& y) {
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
    chart.lines.push_back({ReferenceLine::Direction::horizontal,
                           reference::calculix_value("glued_stretch", nu, "swelling").value,
                           fmt::format("elasticity, nu = {:g}", nu)});
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
      .y = {.label = "change of volume / volume"},
      .legend = Chart::Legend::below};
  for (const VolumeModel& m : config.models)
    chart.series.push_back(
        series_of(rows, "strain", m.name, "strain", [&](std::size_t r) { return rows.number(r, "drift"); }));
  for (const double nu : {0.3, 0.45}) {
    const double slope = reference::calculix_value("glued_stretch", nu, "swelling").value;
    chart.series.push_back({.label = fmt::format("elasticity, nu = {:g}, to first order", nu),
                            .points = {{config.strains.front(), slope * config.strains.front()},
                                       {config.strains.back(), slope * config.strains.back()}}});
  }
  return chart;
}

Chart stiffness_chart(const Table& rows, const VolumeConfig& config) {
  Chart chart{.title = "What the volume force does for the thesis's cube",
              .subtitle = fmt::format(
                  "{} cells per edge, ends glued, pulled by {:g} %; the line is without volume force",
                  config.study_cells, 100 * config.large_strain),
              .x = {.label = "k_vol [Pa]", .logarithmic = true, .low = 0.05},
              .y = {.label = "change of volume / volume", .low = 0}};
  ChartSeries series{.label = "thesis's springs"};
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows.text(r, "study") != "k_vol" || rows.text(r, "status") != "ok") continue;
    const double k_vol = rows.number(r, "k_vol"), drift = rows.number(r, "drift");
    if (k_vol > 0) series.points.push_back({k_vol, drift});
    if (k_vol == 0) chart.lines.push_back({ReferenceLine::Direction::horizontal, drift, ""});
    if (k_vol == 0.1) chart.marks.push_back({{k_vol, drift}, "the thesis's 0.1"});
  }
  chart.series.push_back(std::move(series));
  return chart;
}

/// By how much the thesis's volume force changes the drift, in a sentence.
std::string verdict(const Table& rows) {
  double without = none, with = none;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows.text(r, "study") != "k_vol" || rows.text(r, "status") != "ok") continue;
    if (rows.number(r, "k_vol") == 0) without = rows.number(r, "drift");
    if (rows.number(r, "k_vol") == 0.1) with = rows.number(r, "drift");
  }
  if (!std::isfinite(without) || !std::isfinite(with)) return {};
  return fmt::format(
      "the thesis's k_vol = 0.1 changes the drift of its cube by {:.1e} of itself: it does nothing\n",
      std::abs(with / without - 1));
}

ExperimentResult run_volume(const ExperimentOptions& options, Progress& progress) {
  const VolumeConfig config = volume_config(options);
  VolumeTables tables = measure_volume(config, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  const auto studies = tables.rows.distinct("study");
  const auto done = [&](const char* study) {
    return std::find(studies.begin(), studies.end(), study) != studies.end();
  };
  if (done("cells")) result.charts.push_back({"volume", cells_chart(tables.rows, config)});
  if (done("strain")) result.charts.push_back({"volume_strain", strain_chart(tables.rows, config)});
  if (done("k_vol")) result.charts.push_back({"volume_k_vol", stiffness_chart(tables.rows, config)});
  for (std::size_t r = 0; r < tables.rows.size(); ++r)
    if (tables.rows.text(r, "study") == "cells" && tables.rows.number(r, "cells") == config.cells.back() &&
        tables.rows.text(r, "status") == "ok")
      result.summary += fmt::format(
          "{:<26} swells by {:.4f} of the strain at n = {}; elasticity: {}\n", tables.rows.text(r, "model"),
          tables.rows.number(r, "drift") / tables.rows.number(r, "strain"), config.cells.back(),
          tables.rows.number(r, "predicted") == 0
              ? "not isotropic"
              : fmt::format("{:.4f}", tables.rows.number(r, "predicted") / tables.rows.number(r, "strain")));
  result.summary += verdict(tables.rows);
  result.tables = {{"volume", std::move(tables.rows)}};
  return result;
}

}  // namespace

VolumeConfig volume_config(const ExperimentOptions& options) {
  VolumeConfig config;
  config.cells = options.cells;
  if (config.cells.empty())
    config.cells = options.quick ? std::vector<int>{1, 2, 4} : std::vector<int>{1, 2, 3, 4, 6, 8, 12, 16, 20};
  config.strains = options.quick
                       ? std::vector<double>{-0.2, -0.1, 0.1, 0.3}
                       : std::vector<double>{-0.3, -0.2, -0.1, -0.05, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5};
  config.stiffness = {0, 0.1};
  for (int half_decade = 0; half_decade <= 10; ++half_decade)
    config.stiffness.push_back(std::pow(10, half_decade / 2.0));
  if (options.quick) config.study_cells = 3;
  config.models = {thesis(0),
                   thesis(0.1),
                   material("springs", spring_model, 0.3),
                   material("springs", spring_model, 0.45),
                   material("elements", "corotational", 0.3),
                   material("elements", "corotational", 0.45)};
  return config;
}

VolumeTables measure_volume(const VolumeConfig& config, Progress& progress) {
  struct Task {
    std::string study;
    VolumeModel model;
    int cells;
    double strain;
  };
  std::vector<Task> tasks;
  for (const int n : config.cells)
    for (const VolumeModel& m : config.models) tasks.push_back({"cells", m, n, config.small_strain});
  for (const double strain : config.strains)
    for (const VolumeModel& m : config.models) tasks.push_back({"strain", m, config.study_cells, strain});
  for (const double k_vol : config.stiffness)
    tasks.push_back({"k_vol", thesis(k_vol), config.study_cells, config.large_strain});
  VolumeTables tables{empty_rows()};
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    const auto& [study, model, cells, strain] = tasks[i];
    progress.report(double(i) / double(tasks.size()),
                    fmt::format("{}: {}, n = {}, strain {:g}", study, model.name, cells, strain));
    if (progress.stopped()) {
      tables.status = Status::interrupted;
      break;
    }
    add_row(tables.rows, study, model, cells, strain);
  }
  return tables;
}

namespace {

Table guarded(bool quick, Progress& progress) {
  VolumeConfig config = volume_config({.quick = quick});
  if (!quick) config.cells = {1, 2, 4, 8};
  return measure_volume(config, progress).rows;
}

}  // namespace

ExperimentInfo volume() {
  return {.name = "volume",
          .summary =
              "change of volume against resolution, strain and volume force, beside elasticity's prediction",
          .accepts = {.cells = true, .largest_cells = 30},
          .run = run_volume,
          .guard = {.keys = {"study", "model", "cells", "strain", "k_vol"},
                    .rules = {{"drift", 1e-6, 1e-9},
                              {"drift_paper", 1e-6, 1e-9},
                              {"worst_cell", 1e-6, 1e-9},
                              {"predicted", 1e-12}},
                    .table = guarded}};
}

}  // namespace mss

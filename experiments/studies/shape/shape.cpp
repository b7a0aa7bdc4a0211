// Bodies whose surface is a mesh, in cubic cells: how a cell at the surface is filled, and what that does to
// frequencies, to the volume and to the largest step. Runs are in runs.cpp.
#include "experiments/studies/shape/shape.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/mesh/shapes.hpp"
#include "experiments/harness/settings.hpp"
#include "reference/sphere_modes.hpp"

namespace mss::studies::shape {

namespace {

constexpr double bar_length = 4;  ///< over its width

ShapeBody ball() {
  constexpr int divisions = 48;
  ShapeBody body{.name = "sphere", .mesh = icosphere(0.5, divisions), .across = 1, .sphere = true};
  // A sphere through the vertices holds more than the mesh, by 0.08 percent.
  const double grown = std::cbrt(std::numbers::pi / 6 / enclosed_volume(body.mesh));
  for (Vec3& vertex : body.mesh.vertices) vertex *= grown;
  return body;
}

ShapeBody bar(const std::string& name, double degrees, const Vec3& axis, bool aligned = false) {
  ShapeBody body{
      .name = name, .mesh = box_mesh({0, 0, 0}, {bar_length, 1, 1}), .across = 1, .aligned = aligned};
  place(body.mesh, {.axis = axis, .degrees = degrees});
  return body;
}

Json configuration(const ShapeConfig& c) {
  Json bodies = Json::array(), fillings = Json::array();
  for (const ShapeBody& body : c.bodies)
    bodies.push_back(
        {{"name", body.name}, {"triangles", body.mesh.triangles.size()}, {"across", body.across}});
  for (const Filling& filling : c.fillings) fillings.push_back(filling.label());
  return {{"bodies", bodies},
          {"fillings", fillings},
          {"cells", c.cells},
          {"reference_cells", c.reference_cells},
          {"offsets", c.offsets},
          {"step_offsets", c.step_offsets},
          {"step_poissons", c.step_poissons},
          {"young", c.material.young},
          {"poisson", c.material.poisson},
          {"density", c.density},
          {"face_share", c.face_share},
          {"seed", c.seed}};
}

constexpr const char* caption =
    "Free bodies given by the mesh of their surface, in cubic cells at random places of the lattice: errors "
    "of their slowest frequencies against cells across the body (root mean square over modes and places). "
    "Sphere: the five torsional and the five spheroidal modes of degree 2, against their closed forms; bar "
    "of "
    "4 x 1 x 1, aligned with the lattice and turned by 30 degrees about z and about [111]: its six slowest, "
    "against the aligned bar's, extrapolated from three sizes. Staircase: a cell is full if its centre is "
    "inside. Even: springs, volume force and mass of a cell are scaled by the share f of it that is filled. "
    "Local: an edge takes the filled share of its quarter of the cell, a face diagonal that of its half, the "
    "others f, blended with f by a; mass goes to corners as it is distributed, blended with f by b: by the "
    "default, a = 0.3 and b = 0.35 (both 0.4 with nu below 1/4), and by b = 0.5. Springs with t = 1, "
    "undamped. "
    "The largest step is compared with that of a full body of the same cells, over 24 places; the slowest "
    "vibration there with the sphere's true one and the aligned bar's in as many cells, so that none that "
    "cells at the surface add is missed. Not varied: the material but for nu, holds, large strains.";

ExperimentResult run_shape(const ExperimentOptions& options, Progress& progress) {
  const ShapeConfig config = shape_config(options);
  Journal journal = open_journal(options, configuration(config));
  const ShapeTables tables = measure_shape(config, options.processes, journal, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  result.tables = shape_files(config, tables);
  const Table& summary = find_table(result.tables, "shape_summary");
  for (std::size_t r = 0; r < summary.size(); ++r)
    result.summary +=
        fmt::format("{:<24} {:<16} {:>3} cells  {:<10} {:>8.3g} %  {}\n", summary.text(r, "body"),
                    summary.text(r, "fill"), int(summary.number(r, "cells")), summary.text(r, "mode"),
                    100 * summary.number(r, "error"), summary.text(r, "status"));
  return result;
}

/// Rows of a table that have the same values in these columns of text and numbers.
Table alike(const Table& table, std::size_t row, const std::vector<std::string>& texts,
            const std::vector<std::string>& numbers) {
  Table chosen = table;
  for (const std::string& column : texts) chosen = chosen.where(column, table.text(row, column));
  for (const std::string& column : numbers) chosen = chosen.where(column, table.number(row, column));
  return chosen;
}

}  // namespace

ShapeConfig shape_config(const ExperimentOptions& options) {
  ShapeConfig config;
  const Vec3 z(0, 0, 1), diagonal(1, 1, 1);
  config.bodies = {ball(), bar("bar, aligned", 0, z, true), bar("bar, 30 deg about z", 30, z),
                   bar("bar, 30 deg about 111", 30, diagonal)};
  if (!options.quick) config.bodies.push_back(bar("bar, shifted", 0, z));
  config.fillings = {
      {.name = "staircase"}, {.name = "even"}, {.name = "local"}, {.name = "local", .blend_mass = 0.5}};
  config.cells = options.cells;
  if (config.cells.empty())
    config.cells = options.quick ? std::vector<int>{5, 7} : std::vector<int>{5, 10, 20};
  config.reference_cells = options.quick ? std::vector<int>{2, 4, 8} : std::vector<int>{4, 8, 16};
  config.step_poissons = options.quick ? std::vector<double>{0.3} : std::vector<double>{0, 0.3};
  if (options.quick) config.step_offsets = 6;
  if (options.cells.empty())
    for (ShapeBody& body : config.bodies)
      if (!body.sphere) body.most_cells = 10;  // its modes take minutes in finer ones
  config.seed = options.seed;
  return config;
}

Table shape_summary(const Table& rows) {
  Table summary({{"body"},
                 {"fill"},
                 {"mode"},
                 {"cells"},
                 {"places"},
                 {"error"},
                 {"volume_error"},
                 {"order"},
                 {"status"}});
  for (const std::string& body : rows.distinct("body"))
    for (const std::string& fill : rows.distinct("fill"))
      for (const std::string& mode : rows.distinct("mode")) {
        const Table all = rows.where("body", body).where("fill", fill).where("mode", mode);
        double before = 0, cells_before = 0;
        for (const double cells : all.distinct_numbers("cells")) {
          const Table places = all.where("cells", cells).where("status", "ok");
          double sum = 0, volume = 0;
          for (std::size_t r = 0; r < places.size(); ++r) {
            sum += std::pow(places.number(r, "error"), 2);
            volume = std::max(volume, std::abs(places.number(r, "volume_error")));
          }
          const bool ok = places.size() > 0;
          const double error = ok ? std::sqrt(sum / double(places.size())) : no_value;
          const bool first = !ok || before == 0;
          summary.add({body, fill, mode, std::int64_t(cells), std::int64_t(places.size()), error,
                       ok ? volume : no_value,
                       first ? no_value : std::log(before / error) / std::log(cells / cells_before),
                       std::string(!ok     ? all.text(0, "status")
                                   : first ? "the first size"
                                           : "ok")});
          before = error;
          cells_before = cells;
        }
      }
  return summary;
}

Table step_summary(const Table& steps) {
  Table summary({{"body"},
                 {"fill"},
                 {"cells"},
                 {"poisson"},
                 {"places"},
                 {"least_step_over_full"},
                 {"least_slowest_over_expected"},
                 {"status"}});
  for (std::size_t r = 0; r < steps.size(); ++r) {
    if (steps.number(r, "place") != 0) continue;
    const Table places = alike(steps, r, {"body", "fill"}, {"cells", "poisson"});
    double least = std::numeric_limits<double>::infinity(), slowest = least;
    std::string status = "ok";
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (places.text(i, "status") != "ok") status = places.text(i, "status");
      least = std::min(least, places.number(i, "step_over_full"));
      slowest = std::min(slowest, places.number(i, "slowest_over_expected"));
    }
    summary.add({steps.text(r, "body"), steps.text(r, "fill"), std::int64_t(steps.number(r, "cells")),
                 steps.number(r, "poisson"), std::int64_t(places.size()), status == "ok" ? least : no_value,
                 status == "ok" ? slowest : no_value, status});
  }
  return summary;
}

std::vector<NamedTable> shape_files(const ShapeConfig& config, const ShapeTables& tables) {
  return {{"shape", tables.rows},
          {"shape_summary", shape_summary(tables.rows)},
          {"shape_steps", tables.steps},
          {"shape_steps_summary", step_summary(tables.steps)},
          {"shape_reference", tables.reference},
          {"shape_settings", settings_table({{"poisson", config.material.poisson},
                                             {"face_share", config.face_share},
                                             {"offsets", std::int64_t(config.offsets)}})}};
}

namespace {

Chart frequency_chart(const Table& summary, const Table& settings, const std::vector<std::string>& bodies,
                      const std::string& title) {
  Chart chart{
      .title = title,
      .subtitle = fmt::format("rms over modes and {:g} random places in the lattice; nu = {:g}, t = {:g}",
                              setting_number(settings, "offsets"), setting_number(settings, "poisson"),
                              setting_number(settings, "face_share")),
      .x = {.label = "cells across the body", .logarithmic = true},
      .y = {.label = "relative error of frequencies", .logarithmic = true}};
  for (const std::string& body : bodies)
    for (const std::string& mode : summary.distinct("mode"))
      for (const std::string& fill : summary.distinct("fill")) {
        const Table points = summary.where("body", body).where("mode", mode).where("fill", fill);
        ChartSeries series{.label = bodies.size() > 1 ? fmt::format("{}: {}", body, fill)
                                                      : fmt::format("{}: {}", mode, fill)};
        if (body == "bar, aligned") series.label = body;
        if (body.starts_with("bar, ")) series.label.erase(0, 5);
        for (std::size_t r = 0; r < points.size(); ++r)
          if (std::isfinite(points.number(r, "error")))
            series.points.push_back({points.number(r, "cells"), points.number(r, "error")});
        if (!series.points.empty()) chart.series.push_back(std::move(series));
      }
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points)
      if (std::find(chart.x.ticks.begin(), chart.x.ticks.end(), point.x) == chart.x.ticks.end())
        chart.x.ticks.push_back(point.x);
  std::sort(chart.x.ticks.begin(), chart.x.ticks.end());
  if (!chart.x.ticks.empty()) {
    chart.x.low = 0.85 * chart.x.ticks.front();
    chart.x.high = chart.x.ticks.back() / 0.85;
  }
  return chart;
}

Drawings draw_shape(const std::vector<NamedTable>& tables) {
  const Table &summary = find_table(tables, "shape_summary"),
              &settings = find_table(tables, "shape_settings");
  if (summary.size() == 0) return {};
  std::vector<std::string> bars;
  for (const std::string& body : summary.distinct("body"))
    if (body.starts_with("bar")) bars.push_back(body);
  Drawings drawings{.charts = {{"shape",
                                frequency_chart(summary, settings, {"sphere"},
                                                "A sphere in cubic cells: error of its slowest modes"),
                                "shape_summary"}}};
  if (!bars.empty())
    drawings.charts.push_back(
        {"shape_bar", frequency_chart(summary, settings, bars, "A bar that is turned in the lattice"),
         "shape_summary"});
  return drawings;
}

Table baseline_table(const BaselineOptions& options, Progress& progress) {
  ShapeConfig config = shape_config({.quick = true});
  if (options.quick) config.cells = {4};
  config.step_offsets = 2;
  Journal journal;
  return measure_shape(config, 1, journal, progress).rows;
}

}  // namespace

ExperimentInfo experiment() {
  return {.name = "shape",
          .summary =
              "frequencies, volume and largest step of bodies whose surface is a mesh, by how surface "
              "cells are filled",
          .accepts = {.cells = true, .largest_cells = 24, .seed = true, .processes = true},
          .run = run_shape,
          .draw = draw_shape,
          .baseline = {.keys = {"body", "fill", "cells", "mode", "place"},
                       .rules = {{"error", 1e-6, 1e-9}, {"volume_error", 1e-9, 1e-12}},
                       .table = baseline_table}};
}

}  // namespace mss::studies::shape

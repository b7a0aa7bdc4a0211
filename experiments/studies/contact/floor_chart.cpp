// A body on the floor: what a reader sees.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "experiments/studies/contact/floor.hpp"

namespace mss::studies::contact {

namespace {

/// Indices of what fills a map's cell.
enum Kind { holds = 0, off = 1, sinks = 3, gains = 4, fails = 5, refuses = 7 };
const std::vector<std::string> kinds{"as it should",
                                     "off",
                                     "",
                                     "behind the plane",
                                     "gains energy: times that of the start",
                                     "a step fails",
                                     "",
                                     "refused by the method"};

Kind kind_of(const Table& rows, std::size_t r) {
  const std::string& status = rows.text(r, "status");
  const bool unpriced = status == "not_compared" && rows.number(r, "error") <= rows.number(r, "bound");
  if (status == "ok" || unpriced) return holds;
  if (status == "refused") return refuses;
  if (status == "gains_energy") return gains;
  if (status == "penetrates") return sinks;
  if (status == "off" || status == "never_touched") return off;
  return fails;
}

/// At most four letters.
std::string brief(double x) {
  if (x >= 9999) return fmt::format("1e{:.0f}", std::floor(std::log10(x)));
  if (x >= 10) return fmt::format("{:.0f}", x);
  std::string text = fmt::format("{:.2g}", x);
  return text.starts_with("0.") ? text.substr(1) : text;
}

/// What a cell says: errors in percent or millimetres, energies over the initial one.
std::string text_of(const Table& rows, std::size_t r) {
  const Kind kind = kind_of(rows, r);
  const double energy = rows.number(r, "energy");
  if (kind == gains) return energy < 2 ? fmt::format("{:.2f}", energy) : brief(energy);
  if (kind == sinks) return brief(1e3 * rows.number(r, "penetration"));
  if (kind != off) return "";
  const bool is_length = rows.text(r, "quantity").ends_with("[m]");
  return brief((is_length ? 1e3 : 1e2) * rows.number(r, "error"));
}

/// The rows that the map shows: of the cube, at 60 steps a second, of methods with a limit at safe steps.
Table mapped(const Table& rows) {
  Table some(rows.columns());
  const std::string &shape = floor_shapes().front(), &frame = floor_steps().front().name,
                    &safe = floor_steps().back().name;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows.text(r, "shape") != shape) continue;
    const std::string& step = rows.text(r, "step");
    if (step == frame || (step == safe && find_integrator(rows.text(r, "integrator")).limit))
      some.add(rows.rows()[r]);
  }
  return some;
}

std::string method_label(const std::string& integrator) {
  return find_integrator(integrator).limit ? integrator + " *" : integrator;
}

/// What the numbers of a scene are.
std::string numbers_of(const FloorScene& scene) {
  switch (scene.task) {
    case FloorTask::rest:
    case FloorTask::loaded:
      return "sag [%]";
    case FloorTask::stick:
    case FloorTask::groove:
      return "creep [mm]";
    case FloorTask::slide:
      return "accel. [%]";
    case FloorTask::drop:
      return "energy";
  }
  return "";
}

/// Methods that take steps of 1/60 s first.
std::vector<std::string> methods_of(const Table& rows) {
  std::vector<std::string> methods = rows.distinct("integrator");
  std::stable_partition(methods.begin(), methods.end(),
                        [](const std::string& name) { return !find_integrator(name).limit; });
  return methods;
}

MapPanel panel_of(const FloorScene& scene, const Table& rows, const std::vector<std::string>& methods,
                  const std::vector<double>& youngs) {
  MapPanel panel{.title = scene.label + "\n" + numbers_of(scene),
                 .x = ChartAxis{.label = "E [MPa]", .low = -0.5, .high = double(youngs.size()) - 0.5}};
  for (std::size_t i = 0; i < youngs.size(); ++i) {
    panel.x->ticks.push_back(double(i));
    panel.x->names.push_back(short_number(youngs[i] / 1e6));
  }
  const Table of_scene = rows.where("scene", scene.name);
  for (std::size_t r = 0; r < of_scene.size(); ++r) {
    const auto column = std::find(youngs.begin(), youngs.end(), of_scene.number(r, "young")) - youngs.begin();
    const auto row =
        std::find(methods.begin(), methods.end(), of_scene.text(r, "integrator")) - methods.begin();
    const double x = double(column), y = double(std::ptrdiff_t(methods.size()) - row);
    panel.cells.push_back(
        {x - 0.46, x + 0.46, y - 0.42, y + 0.42, kind_of(of_scene, r), text_of(of_scene, r)});
  }
  return panel;
}

}  // namespace

MapChart floor_map(const Table& rows) {
  const Table shown = mapped(rows);
  const std::vector<std::string> methods = methods_of(shown);
  std::vector<double> youngs = shown.distinct_numbers("young");
  std::sort(youngs.begin(), youngs.end());
  std::vector<std::string> names;
  names.reserve(methods.size());
  for (const std::string& method : methods) names.push_back(method_label(method));
  MapChart chart{
      .title = "A block on the floor at 60 steps a second: which methods get it right",
      .subtitle =
          "cube of 20 cm, 4 cells an edge, 1000 kg/m^3; numbers: off by so much, where that is too "
          "much; * safe steps; white: no law",
      .x = {.label = ""},
      .y = named_rows(names),
      .kinds = kinds,
      .panel_height = 130 + 24.0 * double(methods.size()),
      .columns = int(floor_scenes().size())};
  for (const FloorScene& scene : floor_scenes())
    if (shown.where("scene", scene.name).size() > 0)
      chart.panels.push_back(panel_of(scene, shown, methods, youngs));
  return chart;
}

Chart floor_steps_chart(const Table& rows) {
  constexpr double young = 1e6, negligible = 1e-3, lowest = 1e-6;
  const Table shown = rows.where("shape", floor_shapes().front())
                          .where("scene", floor_scenes().front().name)
                          .where("young", young);
  Chart chart{.title = "A block at rest: error of its sag against the step",
              .subtitle = "",
              .x = {.label = "step", .logarithmic = true, .unit = "s"},
              .y = {.label = "| sag / static answer - 1 |", .logarithmic = true, .low = lowest}};
  int right = 0;
  for (const std::string& method : shown.distinct("integrator")) {
    const Table of_method = shown.where("integrator", method);
    ChartSeries series{.label = method};
    bool errs = false;
    for (std::size_t r = 0; r < of_method.size(); ++r) {
      const double error = of_method.number(r, "error");
      errs = errs || !(error < negligible);
      if (std::isfinite(error)) series.points.push_back({of_method.number(r, "dt"), std::max(lowest, error)});
    }
    if (series.points.empty()) continue;
    if (errs)
      chart.series.push_back(std::move(series));
    else
      ++right;
  }
  chart.subtitle = fmt::format(
      "cube of 20 cm, 4 cells an edge, E = 1 MPa; {} other methods err by less than 0.1 % at all their steps",
      right);
  return chart;
}

}  // namespace mss::studies::contact

// Bars of `mss stability failures`: how many methods have which outcome, a panel per scene.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "experiments/studies/failures/failures.hpp"

namespace mss::studies::failures {

namespace {

/// The rows of one variant of a body.
Table rows_of(const Table& rows, Variant variant) {
  return rows.where("guarded", variant.guarded ? 1.0 : 0.0)
      .where("guarded_step", variant.guarded_step ? 1.0 : 0.0);
}

/// Adds a bar of the outcomes in the rows, in the order of the legend from the foot.
void add_bar(const Table& rows, double left, double right, MapPanel& panel) {
  double low = 0;
  for (int kind = 0; kind < int(failure_statuses().size()); ++kind) {
    const double high = low + double(rows.where("status", failure_statuses()[std::size_t(kind)].name).size());
    if (high > low) panel.cells.push_back({left, right, low, high, kind});
    low = high;
  }
}

/// The panel of a scene from its rows.
MapPanel panel_of(const Table& rows, const std::string& label) {
  constexpr double width = 0.28, gap = 0.03;  // of a bar, and beside it; severities are 1 apart
  std::vector<double> severities;             // as listed, ascending or not
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (std::find(severities.begin(), severities.end(), rows.number(r, "severity")) == severities.end())
      severities.push_back(rows.number(r, "severity"));
  MapPanel panel{.title = label,
                 .x = ChartAxis{.label = "", .low = -0.5, .high = double(severities.size()) - 0.5}};
  for (std::size_t s = 0; s < severities.size(); ++s) {
    panel.x->ticks.push_back(double(s));
    panel.x->names.push_back(short_number(severities[s]));
    const Table of_severity = rows.where("severity", severities[s]);
    for (std::size_t v = 0; v < variants.size(); ++v) {
      const double middle = double(s) + (double(v) - 1) * (width + gap);
      add_bar(rows_of(of_severity, variants[v]), middle - width / 2, middle + width / 2, panel);
    }
  }
  return panel;
}

/// The rows of methods that are counted.
Table counted(const Table& rows) {
  Table some(rows.columns());
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (find_integrator(rows.text(r, "integrator")).variant_of.empty()) some.add(rows.rows()[r]);
  return some;
}

/// Whether a method takes the guard in the scene of a row, and is not refused there.
bool takes_the_guard(const Table& guarded, const Table& rows, std::size_t r) {
  for (std::size_t g = 0; g < guarded.size(); ++g)
    if (guarded.text(g, "integrator") == rows.text(r, "integrator") &&
        guarded.number(g, "severity") == rows.number(r, "severity"))
      return guarded.text(g, "status") != "refused";
  return false;
}

/// A scene by its label, without the quantity and the unit of its severities.
std::string name_of(const std::string& label) {
  std::string name = label.substr(0, label.find(" ["));
  if (name.ends_with(" to")) name.resize(name.size() - 3);
  return name;
}

/// Stable runs of those methods that take the guard, in percent, scene by scene.
Chart stable_chart(const Table& rows, const Table& scenes) {
  constexpr double apart = 0.18;  // of markers in a row; rows are 1 apart
  constexpr std::array labels{"without fold guard", "without, at the step of the guarded body",
                              "with fold guard"};
  Chart chart{.title = "Stable runs in hard scenes, without and with the fold guard",
              .subtitle = "of methods that take the guard and run there; in brackets: runs of each kind",
              .x = {.label = "stable runs [%]", .low = 0, .high = 101},
              .y = {}};
  for (const char* label : labels) chart.series.push_back({.label = label, .joined = false});
  std::vector<Table> of_scenes;
  std::vector<std::string> names;
  for (std::size_t s = 0; s < scenes.size(); ++s)
    if (Table of_scene = rows.where("scene", scenes.text(s, "scene")); of_scene.size() > 0) {
      of_scenes.push_back(std::move(of_scene));
      names.push_back(name_of(scenes.text(s, "label")));
    }
  for (std::size_t s = 0; s < of_scenes.size(); ++s) {
    const Table guarded = rows_of(of_scenes[s], variants.back());
    for (std::size_t v = 0; v < variants.size(); ++v) {
      const Table runs = rows_of(of_scenes[s], variants[v]);
      int all = 0, stable = 0;
      for (std::size_t r = 0; r < runs.size(); ++r)
        if (takes_the_guard(guarded, runs, r)) {
          ++all;
          stable += runs.text(r, "status") == "stable" ? 1 : 0;
        }
      if (all == 0) continue;
      chart.series[v].points.push_back(
          {100.0 * stable / all, double(of_scenes.size() - s) + apart * (1 - double(v))});
      if (v + 1 == variants.size()) names[s] += fmt::format(" ({})", all);
    }
  }
  chart.y = named_rows(names);
  return chart;
}

}  // namespace

Drawings draw_failures(const std::vector<NamedTable>& tables) {
  const Table rows = counted(find_table(tables, "failures"));
  const Table& scenes = find_table(tables, "failures_scenes");
  if (rows.size() == 0) return {};
  const double methods = double(rows.distinct("integrator").size());
  std::vector<std::string> labels;
  for (const FailureStatus& status : failure_statuses()) labels.push_back(status.label);
  MapChart chart{.title = "Outcomes of stress cases",
                 .subtitle = fmt::format(
                     "{} methods and variants; without a limit, at ten explicit steps; bars: no fold guard; "
                     "none, at the guarded body's step; with it",
                     methods),
                 .x = {.label = ""},
                 .y = {.label = "methods", .low = 0, .high = methods},
                 .kinds = labels,
                 .panel_height = 300};
  for (std::size_t s = 0; s < scenes.size(); ++s)
    if (const Table of_scene = rows.where("scene", scenes.text(s, "scene")); of_scene.size() > 0)
      chart.panels.push_back(panel_of(of_scene, scenes.text(s, "label")));
  return {.charts = {{"failures", stable_chart(rows, scenes)}},
          .maps = {{"failures_outcomes", std::move(chart), "failures"}}};
}

}  // namespace mss::studies::failures

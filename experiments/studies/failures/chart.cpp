// The map of `mss stability failures`: outcome per method and severity, a panel per scene.
#include <algorithm>

#include "experiments/studies/failures/failures.hpp"

namespace mss::studies::failures {

namespace {

/// Numbers of a column, once each, in order of first appearance.
std::vector<double> distinct_numbers(const Table& table, std::string_view column) {
  std::vector<double> values;
  for (std::size_t r = 0; r < table.size(); ++r)
    if (const double value = table.number(r, column);
        std::find(values.begin(), values.end(), value) == values.end())
      values.push_back(value);
  return values;
}

/// The panel of a scene from its rows; methods from the top.
MapPanel panel_of(const Table& rows, const std::string& label, const std::vector<std::string>& integrators) {
  constexpr double gap = 0.06;
  const std::vector<double> severities = distinct_numbers(rows, "severity");
  MapPanel panel{.title = label,
                 .x = ChartAxis{.label = "", .low = -0.5, .high = double(severities.size()) - 0.5}};
  for (std::size_t s = 0; s < severities.size(); ++s) {
    panel.x->ticks.push_back(double(s));
    panel.x->names.push_back(short_number(severities[s]));
  }
  const auto place = [](const auto& values, const auto& value) {
    return double(std::find(values.begin(), values.end(), value) - values.begin());
  };
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const double x = place(severities, rows.number(r, "severity"));
    const double y = double(integrators.size()) - place(integrators, rows.text(r, "integrator"));
    const bool guarded = rows.number(r, "guarded") != 0;
    panel.cells.push_back({x - 0.5 + gap, x + 0.5 - gap, guarded ? y - 0.44 : y, guarded ? y : y + 0.44,
                           int(read_outcome(rows.text(r, "status")))});
  }
  return panel;
}

}  // namespace

Drawings draw_failures(const std::vector<NamedTable>& tables) {
  const Table &rows = find_table(tables, "failures"), &scenes = find_table(tables, "failures_scenes");
  const std::vector<std::string> integrators = rows.distinct("integrator");
  MapChart chart{.title = "Where methods fail",
                 .subtitle =
                     "safe step, or ten times that of semi_implicit_euler; upper half of a bar: no "
                     "fold guard, lower half: with fold guard",
                 .x = {.label = ""},
                 .y = named_rows(integrators),
                 .kinds = outcome_labels(),
                 .panel_height = 400};
  for (std::size_t s = 0; s < scenes.size(); ++s)
    if (const Table of_scene = rows.where("scene", scenes.text(s, "scene")); of_scene.size() > 0)
      chart.panels.push_back(panel_of(of_scene, scenes.text(s, "label"), integrators));
  return {.maps = {{"failures", std::move(chart)}}};
}

}  // namespace mss::studies::failures

// Maps of `mss stability atlas`: outcome over step and one parameter, a panel per method.
#include <fmt/format.h>

#include <cmath>

#include "experiments/studies/atlas/atlas.hpp"

namespace mss::studies::atlas {

namespace {

/// Runs of one method with one value of the parameter.
struct MapRow {
  double value = 0;
  double position = 0;                            ///< on the axis of the parameter
  std::vector<std::pair<long, Outcome>> steps{};  ///< ascending, in parts of an octave
};

/// Where on its axis a value of a parameter is; `parameter` has the rows of that parameter alone.
double position_of(const Table& parameter, double value) {
  return parameter.where("value", value).number(0, "position");
}

/// The parameter's values, equally spaced whatever they are.
ChartAxis parameter_axis(const Table& parameter) {
  ChartAxis axis{.label = parameter.text(0, "label"), .low = -0.5};
  for (std::size_t r = 0; r < parameter.size(); ++r) {
    const double position = parameter.number(r, "position");
    if (position != std::floor(position)) continue;
    axis.ticks.push_back(position);
    axis.names.push_back(fmt::format("{:g}", parameter.number(r, "value")));
  }
  axis.high = axis.ticks.back() + 0.5;
  return axis;
}

/// Rows from the points of one method and parameter.
std::vector<MapRow> rows_of(const Table& points, const Table& parameter) {
  const std::string& name = parameter.text(0, "parameter");
  std::vector<MapRow> rows;
  for (std::size_t r = 0; r < points.size(); ++r) {
    const double value = points.number(r, name);
    if (rows.empty() || rows.back().value != value)
      rows.push_back({.value = value, .position = position_of(parameter, value)});
    rows.back().steps.emplace_back(std::lround(octave_parts * std::log2(points.number(r, "dt_omega"))),
                                   read_outcome(points.text(r, "status")));
  }
  return rows;
}

/// The steps of a row as bars that meet halfway between two outcomes.
void add_bars(const MapRow& row, double y_low, double y_high, MapPanel& panel) {
  const auto& steps = row.steps;
  double low = double(steps.front().first) - octave_parts / 2.0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const bool last = i + 1 == steps.size();
    if (!last && steps[i + 1].second == steps[i].second) continue;
    const double high = last ? double(steps[i].first) + octave_parts / 2.0
                             : double(steps[i].first + steps[i + 1].first) / 2.0;
    panel.cells.push_back({dt_omega(low), dt_omega(high), y_low, y_high, int(steps[i].second)});
    low = high;
  }
}

/// The rows of a panel, which meet halfway.
void add_cells(const std::vector<MapRow>& rows, const ChartAxis& y, MapPanel& panel) {
  const auto middle = [&](std::size_t r) { return (rows[r].position + rows[r + 1].position) / 2; };
  for (std::size_t r = 0; r < rows.size(); ++r)
    add_bars(rows[r], r == 0 ? y.low : middle(r - 1), r + 1 == rows.size() ? y.high : middle(r), panel);
}

/// Without variants, and without methods that choose their own steps where there are others: theirs are
/// intervals.
std::vector<std::string> shown_methods(const Table& points) {
  const std::vector<std::string> names = without_variants(points.distinct("integrator"));
  std::vector<std::string> fixed = names;
  std::erase_if(fixed, chooses_its_steps);
  return fixed.empty() ? names : fixed;
}

MapChart map_of(const Table& points, const Table& limits, const Table& parameter) {
  const ChartAxis y = parameter_axis(parameter);
  const double viscosity = points.size() > 0 ? points.number(0, "viscosity") : 0;
  MapChart chart{.title = "Outcome per method: step against " + y.label,
                 .subtitle = fmt::format(
                     "stretched cube, released; face share t = 0.5; otherwise 3 cells per edge, nu 0.3, "
                     "strain 0.01, {}; white: not tried",
                     viscosity > 0 ? fmt::format("viscosity {:g} Pa s", viscosity) : "damping ratio 0.05"),
                 .x = {.label = "dt omega_max",
                       .logarithmic = true,
                       .low = 0.01,
                       .high = 1000,
                       .ticks = {0.1, 1, 10, 100}},
                 .y = y,
                 .kinds = outcome_labels(),
                 .line_label = "predicted limit"};
  for (const std::string& integrator : shown_methods(points)) {
    MapPanel panel{.title = integrator};
    add_cells(rows_of(points.where("integrator", integrator), parameter), y, panel);
    const Table predicted = limits.where("integrator", integrator);
    for (std::size_t r = 0; r < predicted.size(); ++r)
      if (const double limit = predicted.number(r, "predicted"); limit > 0)
        panel.line.push_back({limit, position_of(parameter, predicted.number(r, "value"))});
    chart.panels.push_back(std::move(panel));
  }
  return chart;
}

}  // namespace

Drawings draw_atlas(const std::vector<NamedTable>& tables) {
  const Table &points = find_table(tables, "atlas"), &limits = find_table(tables, "atlas_limits"),
              &parameters = find_table(tables, "atlas_parameters");
  Drawings drawings;
  for (const std::string& name : parameters.distinct("parameter"))
    drawings.maps.push_back(
        {"atlas_" + name, map_of(points.where("parameter", name), limits.where("parameter", name),
                                 parameters.where("parameter", name))});
  return drawings;
}

}  // namespace mss::studies::atlas

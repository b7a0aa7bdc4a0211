// The maps of `mss regimes`: the cheapest kind of method over Young's modulus and damping, a row of panels
// per scene and a column per demand.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/simulation/bench_scenes.hpp"
#include "experiments/studies/regimes/regimes.hpp"

namespace mss::studies::regimes {

namespace {

int index_of(const std::string& label) {
  const std::vector<std::string> labels = kind_labels();
  return int(std::find(labels.begin(), labels.end(), label) - labels.begin());
}

/// The middle, on a logarithmic axis, between a value and its neighbour; half a step beyond the last.
double edge(const std::vector<double>& values, std::size_t i, bool above) {
  const std::size_t n = values.size();
  if (n == 1) return values[0] * (above ? 3 : 1.0 / 3);
  const auto step = [&](std::size_t a) { return std::sqrt(values[a + 1] / values[a]); };
  if (above) return values[i] * step(i + 1 < n ? i : n - 2);
  return values[i] / step(i > 0 ? i - 1 : 0);
}

/// An error in percent, of at most three digits; empty if there is none.
std::string percent(double error) {
  if (!std::isfinite(error)) return "";
  return error < 0.095 ? short_number(std::round(1e3 * error) / 10) : fmt::format("{:.0f}", 100 * error);
}

/// Whether a row's demand was not made: what would answer it is not known that well.
bool is_not_asked(const Table& cheapest, std::size_t r) {
  const std::string& status = cheapest.text(r, "status");
  return status == "no reference" || status == uncertain;
}

/// A row of the map, damping y: cells that meet halfway, in two halves where two kinds tie. Where any error
/// is allowed it is said.
void add_cells(const Table& row, double y, bool says_error, MapPanel& panel) {
  constexpr double gap = 0.03;
  const std::vector<double> moduli = row.distinct_numbers("young");
  for (std::size_t i = 0; i < moduli.size(); ++i) {
    const Table point = row.where("young", moduli[i]);
    if (is_not_asked(point, 0)) continue;
    const double low = edge(moduli, i, false), high = edge(moduli, i, true);
    const bool tie = point.number(0, "tie") != 0;
    panel.cells.push_back({low, high, tie ? y : y - 0.5 + gap, y + 0.5 - gap, index_of(point.text(0, "kind")),
                           says_error ? percent(point.number(0, "error")) : ""});
    if (tie) panel.cells.push_back({low, high, y - 0.5 + gap, y, index_of(point.text(0, "runner_up_kind"))});
  }
}

/// Young's moduli; where there are many, ticks at every second power of ten.
ChartAxis modulus_axis(double low, double high) {
  ChartAxis axis{.label = "", .logarithmic = true, .low = low / 3, .high = high * 3};
  const int first = int(std::ceil(std::log10(low) - 1e-9)), last = int(std::floor(std::log10(high) + 1e-9));
  for (int exponent = first; exponent <= last; exponent += last - first > 3 ? 2 : 1) {
    axis.ticks.push_back(std::pow(10, exponent));
    axis.names.push_back(fmt::format("1e{}", exponent));
  }
  return axis;
}

/// The rows of one scene in one resolution.
struct SceneRows {
  std::string scene;
  double cells;
  Table cheapest, boundaries;
};
std::vector<SceneRows> scenes_of(const Table& cheapest, const Table& boundaries) {
  std::vector<SceneRows> all;
  for (const std::string& scene : cheapest.distinct("scene"))
    for (const double cells : cheapest.where("scene", scene).distinct_numbers("cells"))
      all.push_back({scene, cells, cheapest.where("scene", scene).where("cells", cells),
                     boundaries.where("scene", scene).where("cells", cells)});
  return all;
}

MapPanel panel_of(const SceneRows& of, const Demand& demand, const std::vector<double>& ratios) {
  const bool only_stable = std::isinf(demand.error);
  MapPanel panel{.title =
                     fmt::format("{} ({:g})\n{}", find_bench_scene(of.scene).label, of.cells, demand.label)};
  const std::vector<double> moduli = of.cheapest.distinct_numbers("young");
  const auto [least, most] = std::minmax_element(moduli.begin(), moduli.end());
  panel.x = modulus_axis(*least, *most);
  const Table rows = of.cheapest.where("demand", demand.name);
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    add_cells(rows.where("damping_ratio", ratios[i]), double(i), only_stable, panel);
    const Table b = of.boundaries.where("damping_ratio", ratios[i]);
    if (!only_stable || b.size() == 0) continue;
    const double predicted = b.number(0, "predicted");
    const bool inside = predicted > panel.x->low && predicted < panel.x->high;
    for (const double end : {-0.5, 0.5})
      panel.line.push_back({inside ? predicted : no_value, double(i) + end});
  }
  return panel;
}

/// Kinds as the legend has them.
std::vector<std::string> kinds_shown() {
  std::vector<std::string> kinds = kind_labels();
  kinds.back() = "nothing tried met it";
  return kinds;
}

bool leaves_blanks(const Table& cheapest) {
  for (std::size_t r = 0; r < cheapest.size(); ++r)
    if (is_not_asked(cheapest, r)) return true;
  return false;
}

/// Panels of the demands on motions, or of those on rests, of scenes that have them.
MapChart map_of(const Table& cheapest, const Table& boundaries, bool at_rest) {
  const std::vector<double> ratios = cheapest.distinct_numbers("damping_ratio");
  ChartAxis y{.label = "damping ratio", .low = -0.5, .high = double(ratios.size()) - 0.5};
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    y.ticks.push_back(double(i));
    y.names.push_back(short_number(ratios[i]));
  }
  MapChart chart{.title = at_rest ? "Which method finds rest most cheaply" : "Which method is cheapest where",
                 .subtitle = at_rest ? "scenes (cells across); two halves: a tie"
                                     : "scenes (cells across), 60 frames a second, all families tuned alike; "
                                       "numbers: error [%]; two halves: a tie",
                 .x = {.label = "Young's modulus [Pa]"},
                 .y = y,
                 .kinds = kinds_shown(),
                 .line_label = at_rest ? "" : "predicted crossing",
                 .panel_height = 170,
                 .columns = at_rest ? 2
                                    : int(std::count_if(demands().begin(), demands().end(),
                                                        [](const Demand& d) { return !d.at_rest; }))};
  for (const SceneRows& of : scenes_of(cheapest, boundaries))
    for (const Demand& demand : demands())
      if (const Table asked = of.cheapest.where("demand", demand.name);
          demand.at_rest == at_rest && asked.size() > 0) {
        chart.panels.push_back(panel_of(of, demand, ratios));
        if (leaves_blanks(asked)) chart.blank_label = "not judged: its true motion is too uncertain";
      }
  const std::size_t lowest = chart.panels.size() - std::min(chart.panels.size(), std::size_t(chart.columns));
  for (std::size_t i = lowest; i < chart.panels.size(); ++i) chart.panels[i].x->label = chart.x.label;
  return chart;
}

}  // namespace

Drawings draw_regimes(const std::vector<NamedTable>& tables) {
  const Table& cheapest = find_table(tables, "regimes");
  if (cheapest.size() == 0) return {};
  const Table& crossings = find_table(tables, "regimes_boundaries");
  Drawings drawings{.maps = {{"regimes", map_of(cheapest, crossings, false)}}};
  if (MapChart rests = map_of(cheapest, crossings, true); has_cells(rests))
    drawings.maps.push_back({"regimes_rest", std::move(rests), "regimes"});
  if (const Table& loaded = find_table(tables, "regimes_loaded"); loaded.size() > 0)
    drawings.charts.push_back(
        {"regimes_loaded", loaded_chart(loaded, find_table(tables, "regimes_crossings"))});
  return drawings;
}

}  // namespace mss::studies::regimes

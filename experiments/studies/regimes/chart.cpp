// The maps of `mss regimes`: the cheapest kind of method over Young's modulus and damping, a row of panels
// per resolution and a column per demand.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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

/// A row of the map, damping y: cells that meet halfway, in two halves where two kinds tie.
void add_cells(const Table& row, double y, MapPanel& panel) {
  constexpr double gap = 0.03;
  const std::vector<double> moduli = row.distinct_numbers("young");
  for (std::size_t i = 0; i < moduli.size(); ++i) {
    const Table point = row.where("young", moduli[i]);
    if (point.text(0, "status") == "no reference") continue;
    const double low = edge(moduli, i, false), high = edge(moduli, i, true);
    const bool tie = point.number(0, "tie") != 0;
    panel.cells.push_back(
        {low, high, tie ? y : y - 0.5 + gap, y + 0.5 - gap, index_of(point.text(0, "kind"))});
    if (tie) panel.cells.push_back({low, high, y - 0.5 + gap, y, index_of(point.text(0, "runner_up_kind"))});
  }
}

/// Young's moduli, ticks at every second power of ten between two of them.
ChartAxis modulus_axis(double low, double high) {
  ChartAxis axis{.label = "Young's modulus [Pa]", .logarithmic = true, .low = low / 3, .high = high * 3};
  const int first = int(std::ceil(std::log10(low) - 1e-9)), last = int(std::floor(std::log10(high) + 1e-9));
  for (int exponent = first; exponent <= last; exponent += 2) {
    axis.ticks.push_back(std::pow(10, exponent));
    axis.names.push_back(fmt::format("1e{}", exponent));
  }
  return axis;
}

MapChart map_of(const Table& cheapest, const Table& boundaries) {
  const std::vector<double> ratios = cheapest.distinct_numbers("damping_ratio"),
                            moduli = cheapest.distinct_numbers("young");
  ChartAxis y{.label = "damping ratio", .low = -0.5, .high = double(ratios.size()) - 0.5};
  for (std::size_t i = 0; i < ratios.size(); ++i) {
    y.ticks.push_back(double(i));
    y.names.push_back(short_number(ratios[i]));
  }
  const auto [least, most] = std::minmax_element(moduli.begin(), moduli.end());
  MapChart chart{.title = "Which method is cheapest where",
                 .subtitle =
                     "held cube of n cells an edge under gravity, 60 frames a second; two halves: a tie; "
                     "line: explicit frames cost as much as any other",
                 .x = modulus_axis(*least, *most),
                 .y = y,
                 .kinds = kind_labels(),
                 .line_label = "predicted",
                 .panel_height = 190,
                 .columns = int(demands().size())};
  for (const double cells : cheapest.distinct_numbers("cells"))
    for (const Demand& demand : demands()) {
      MapPanel panel{.title = fmt::format("n = {:g}: {}", cells, demand.label)};
      const Table rows = cheapest.where("cells", cells).where("demand", demand.name);
      for (std::size_t i = 0; i < ratios.size(); ++i) {
        add_cells(rows.where("damping_ratio", ratios[i]), double(i), panel);
        const Table b = boundaries.where("cells", cells).where("damping_ratio", ratios[i]);
        if (demand.name != "stable" || b.size() == 0) continue;
        for (const double end : {-0.5, 0.5})
          panel.line.push_back({b.number(0, "predicted"), double(i) + end});
      }
      chart.panels.push_back(std::move(panel));
    }
  return chart;
}

}  // namespace

Drawings draw_regimes(const std::vector<NamedTable>& tables) {
  const Table& cheapest = find_table(tables, "regimes");
  if (cheapest.size() == 0) return {};
  Drawings drawings{.maps = {{"regimes", map_of(cheapest, find_table(tables, "regimes_boundaries"))}}};
  if (const Table& loaded = find_table(tables, "regimes_loaded"); loaded.size() > 0)
    drawings.charts.push_back(
        {"regimes_loaded", loaded_chart(loaded, find_table(tables, "regimes_crossings"))});
  return drawings;
}

}  // namespace mss::studies::regimes

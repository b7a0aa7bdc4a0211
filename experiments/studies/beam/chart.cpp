// Charts of `mss validate beam`.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "experiments/studies/beam/beam.hpp"

namespace mss::studies::beam {

namespace {

constexpr const char* beam_body = "Dragon Skin 10, 0.1 x 0.03 x 0.03 m, clamped at one end";

/// Places of styles that are told apart in grey: measured black-ish, computed in colour.
constexpr int measured_a_style = 15, measured_b_style = 3, comsol_style = 2;
constexpr std::array<int, 4> material_styles{5, 0, 8, 7};

double finest_cells(const Table& rows) {
  double finest = 0;
  for (const double n : rows.distinct_numbers("cells")) finest = std::max(finest, n);
  return finest;
}

Table in_finest_cells(const Table& rows) { return rows.where("cells", finest_cells(rows)); }

std::string weight_label(const std::string& load) { return load == "none" ? "no weight" : load; }

/// A table's rows of its first material.
Table of_first_material(const Table& rows) {
  return rows.size() == 0 ? rows : rows.where("material", rows.distinct("material").front());
}

double over_mean(double drop, double a, double b) { return 100 * (2 * drop / (a + b) - 1); }

/// COMSOL's value of a row of drops; NaN where it is not known.
double comsol_of(const Table& comsol, const std::string& load, double marker) {
  const Table row = comsol.where("load", load).where("marker", marker);
  return row.size() == 0 ? no_value : row.number(0, "comsol");
}

/// From 1 on, where the load and marker of row `r` stand in `first`; beyond it if they do not.
double place_of_row(const Table& rows, std::size_t r, const Table& first) {
  std::size_t place = 0;
  while (place < first.size() && !(first.text(place, "load") == rows.text(r, "load") &&
                                   first.number(place, "marker") == rows.number(r, "marker")))
    ++place;
  return double(place) + 1;
}

/// How far markers sink, over the mean of both runs.
Chart drops_chart(const Table& all, const Table& comsol) {
  const double cells = finest_cells(all);
  const Table first = of_first_material(all.where("cells", cells));
  Chart chart{.title = "How far a silicone beam sinks",
              .subtitle = fmt::format("{}; springs {:g} cells across, COMSOL where its value is known",
                                      beam_body, cells),
              .x = {.label = "weight at its end: marker", .low = 0.4, .high = double(first.size()) + 0.6},
              .y = {.label = "drop over that measured, less one [%]"}};
  ChartSeries measured{.label = "measured, from run to run", .style = measured_a_style, .joined = false};
  ChartSeries others{.label = "COMSOL", .style = comsol_style, .joined = false};
  for (std::size_t r = 0; r < first.size(); ++r) {
    const double a = first.number(r, "measured_a"), b = first.number(r, "measured_b"), x = double(r) + 1;
    const double half = std::abs(over_mean(a, a, b));
    chart.x.ticks.push_back(x);
    chart.x.names.push_back(fmt::format("{}: {:g}", first.text(r, "load"), first.number(r, "marker")));
    measured.points.push_back({x, 0, -half, half});
    others.points.push_back(
        {x + 0.15, over_mean(comsol_of(comsol, first.text(r, "load"), first.number(r, "marker")), a, b)});
  }
  chart.series = {measured, others};
  for (const std::string& material : all.distinct("material")) {
    ChartSeries series{.label = "springs, " + material,
                       .style = material_styles[(chart.series.size() - 2) % material_styles.size()],
                       .joined = false};
    const Table of = in_finest_cells(all.where("material", material));
    if (of.number(0, "cells") != cells) series.label += fmt::format(", {:g} cells", of.number(0, "cells"));
    for (std::size_t r = 0; r < of.size(); ++r)
      series.points.push_back(
          {place_of_row(of, r, first) - 0.2 + 0.1 * double(chart.series.size() - 2),
           over_mean(of.number(r, "drop"), of.number(r, "measured_a"), of.number(r, "measured_b"))});
    chart.series.push_back(std::move(series));
  }
  chart.lines.push_back({ReferenceLine::Direction::horizontal, 0, ""});
  return chart;
}

/// The drop of marker 1 over COMSOL's against cells.
Chart cells_chart(const Table& all, const Table& comsol) {
  const Table rows = of_first_material(all).where("marker", 1);
  Chart chart{.title = "A silicone beam in finer cells",
              .subtitle = fmt::format("{}; drop of marker 1 at rest", beam_body),
              .x = {.label = "cells across",
                    .logarithmic = true,
                    .low = 0.8 * rows.number(0, "cells"),
                    .high = 1.25 * finest_cells(rows),
                    .ticks = rows.distinct_numbers("cells")},
              .y = {.label = "drop over COMSOL's, less one [%]"}};
  for (const std::string& load : rows.distinct("load")) {
    ChartSeries series{.label = weight_label(load)};
    const Table of = rows.where("load", load);
    const double value = comsol_of(comsol, load, 1);
    for (std::size_t r = 0; r < of.size(); ++r)
      series.points.push_back({of.number(r, "cells"), 100 * (of.number(r, "drop") / value - 1)});
    chart.series.push_back(std::move(series));
  }
  chart.lines.push_back({ReferenceLine::Direction::horizontal, 0, "COMSOL", true});
  return chart;
}

/// Turning points of both runs, and the computed motion.
Chart ring_down_chart(const std::string& load, const Table& all_turns, const Table& all_motion) {
  const double cells = finest_cells(all_motion);
  const Table turns = of_first_material(all_turns.where("load", load).where("cells", cells)),
              motion = all_motion.where("load", load).where("cells", cells);
  Chart chart{.title = fmt::format("A silicone beam rings down, {}", weight_label(load)),
              .subtitle = fmt::format("{}; marker 1, springs {:g} cells across", beam_body, cells),
              .x = {.label = "time since it moved 0.3 mm [s]", .low = 0},
              .y = {.label = "height over its rest [mm]"}};
  for (const char* run : {"a", "b"}) {
    ChartSeries series{.label = fmt::format("measured, run {}: turning points", run),
                       .style = *run == 'a' ? measured_a_style : measured_b_style,
                       .joined = false};
    for (std::size_t r = 0; r < turns.size(); ++r)
      series.points.push_back(
          {turns.number(r, fmt::format("time_{}", run)), turns.number(r, fmt::format("height_{}", run))});
    chart.series.push_back(std::move(series));
  }
  double last = 0;
  for (std::size_t r = 0; r < turns.size(); ++r)
    last = std::max({last, turns.number(r, "time_a"), turns.number(r, "time_b")});
  chart.x.high = 1.1 * last;
  for (const std::string& material : motion.distinct("material")) {
    ChartSeries series{.label = "springs, " + material,
                       .style = material_styles[(chart.series.size() - 2) % material_styles.size()],
                       .marked = false};
    const Table of = motion.where("material", material);
    for (std::size_t r = 0; r < of.size(); ++r)
      if (of.number(r, "time") >= 0 && of.number(r, "time") <= chart.x.high)
        series.points.push_back({of.number(r, "time"), of.number(r, "height")});
    chart.series.push_back(std::move(series));
  }
  chart.lines.push_back({ReferenceLine::Direction::horizontal, 0, ""});
  return chart;
}

/// Damping against frequency: what a material's law has to give.
Chart damping_chart(const Table& all) {
  const double cells = finest_cells(all);
  const Table rows = all.where("cells", cells), first = of_first_material(rows);
  Chart chart{.title = "Damping of a silicone beam against its frequency",
              .subtitle = fmt::format("{}; three weights, springs {:g} cells across", beam_body, cells),
              .x = {.label = "frequency [Hz]", .low = 0},
              .y = {.label = "damping ratio of upper peaks [%]", .low = 0}};
  for (const char* run : {"a", "b"}) {
    ChartSeries series{.label = fmt::format("measured, run {}", run),
                       .style = *run == 'a' ? measured_a_style : measured_b_style,
                       .joined = false};
    for (std::size_t r = 0; r < first.size(); ++r)
      series.points.push_back({first.number(r, fmt::format("frequency_{}", run)),
                               100 * first.number(r, fmt::format("damping_ratio_{}", run))});
    chart.series.push_back(std::move(series));
  }
  for (const std::string& material : rows.distinct("material")) {
    ChartSeries series{.label = "springs, " + material,
                       .style = material_styles[(chart.series.size() - 2) % material_styles.size()]};
    const Table of = rows.where("material", material);
    for (std::size_t r = 0; r < of.size(); ++r)
      series.points.push_back({of.number(r, "frequency"), 100 * of.number(r, "damping_ratio")});
    chart.series.push_back(std::move(series));
  }
  return chart;
}

std::string file_of(const std::string& load) {
  std::string name = "beam_motion_" + load;
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

}  // namespace

Drawings draw_beam(const std::vector<NamedTable>& tables) {
  const Table &drops = find_table(tables, "beam"), &comsol = find_table(tables, "beam_comsol"),
              &ring_down = find_table(tables, "beam_ring_down"), &turns = find_table(tables, "beam_turns"),
              &motion = find_table(tables, "beam_motion");
  Drawings drawings;
  const auto add = [&](const std::string& name, Chart chart, const char* table) {
    if (has_points(chart)) drawings.charts.push_back({name, std::move(chart), table});
  };
  if (drops.size() > 0) {
    add("beam", drops_chart(drops, comsol), "beam");
    add("beam_cells", cells_chart(drops, comsol), "beam");
  }
  if (ring_down.size() > 0) add("beam_damping", damping_chart(ring_down), "beam_ring_down");
  if (motion.size() > 0)
    for (const std::string& load : motion.distinct("load"))
      add(file_of(load), ring_down_chart(load, turns, motion), "beam_motion");
  return drawings;
}

}  // namespace mss::studies::beam

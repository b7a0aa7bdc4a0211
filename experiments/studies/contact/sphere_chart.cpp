// Elastic spheres: what a reader sees.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/studies/contact/sphere.hpp"

namespace mss::studies::contact {

namespace {

/// Rows of finite numbers as points.
ChartSeries points_of(const Table& rows, const char* x, const char* y, std::string label) {
  ChartSeries series{.label = std::move(label)};
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (std::isfinite(rows.number(r, y))) series.points.push_back({rows.number(r, x), rows.number(r, y)});
  return series;
}

/// On the plane of law `impulse` the three finest spheres, on what else they are pressed the finest.
void add_spheres(const Table& rows, Chart& chart) {
  for (const std::string& on : rows.distinct("on"))
    for (const double stiffness : rows.where("on", on).distinct_numbers("stiffness")) {
      const Table runs = rows.where("on", on).where("stiffness", stiffness);
      const std::string with =
          on == to_string(PressedOn::sphere) ? fmt::format(", stiffness {:g}", stiffness) : "";
      std::vector<double> cells = runs.distinct_numbers("cells");
      const std::size_t shown =
          std::min<std::size_t>(cells.size(), on == to_string(PressedOn::impulse) ? 3 : 1);
      cells.erase(cells.begin(), cells.end() - std::ptrdiff_t(shown));
      for (const double n : cells)
        chart.series.push_back(points_of(runs.where("cells", n), "approach_over_radius", "force_over_hertz",
                                         fmt::format("{}{}, {:g} cells", on, with, n)));
    }
}

/// Of the power of speed that durations follow, from the slowest to the fastest.
double exponent_of(const Table& runs) {
  const std::size_t last = runs.size() - 1;
  return std::log(runs.number(last, "duration") / runs.number(0, "duration")) /
         std::log(runs.number(last, "speed_over_c") / runs.number(0, "speed_over_c"));
}

/// The largest amount in a column of rows of which something is claimed.
double worst_claimed(const Table& rows, const char* column) {
  double worst = 0;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.text(r, "status") == "ok" || rows.text(r, "status") == "off")
      worst = std::max(worst, std::abs(rows.number(r, column)));
  return worst;
}

}  // namespace

Chart sphere_chart(const Table& rows) {
  Chart chart{.title = "An elastic sphere pressed on a plane and on its like",
              .subtitle = "force over Hertz's; vertices of the surface touch, about a cell apart; nu = 0.3",
              .x = {.label = "approach / radius", .low = 0, .high = 0.042},
              .y = {.label = "force / Hertz's", .low = 0.7, .high = 1.3},
              .lines = {{ReferenceLine::Direction::horizontal, 1, "Hertz", true}}};
  ChartSeries finite{.label = "finite sphere", .marked = false};
  for (int i = 1; i <= 80; ++i) finite.points.push_back({0.0005 * i, finite_over_hertz(0.0005 * i)});
  chart.series.push_back(std::move(finite));
  add_spheres(rows, chart);
  return chart;
}

Chart impact_chart(const Table& rows) {
  Chart chart{
      .title = "A free elastic sphere hits a plane: how long they touch",
      .subtitle = "c = sqrt(E / density); vertices of the surface touch, about a cell apart; nu = 0.3",
      .x = {.label = "speed / c",
            .logarithmic = true,
            .low = 0.0014,
            .high = 0.018,
            .ticks = {0.0016, 0.0028, 0.005, 0.009, 0.016},
            .names = {"0.0016", "0.0028", "0.005", "0.009", "0.016"}},
      .y = {.label = "duration [R / c]",
            .logarithmic = true,
            .low = 9.5,
            .high = 20,
            .ticks = {10, 12, 14, 16, 18, 20}}};
  const Table first = rows.where("law", rows.text(0, "law")).where("cells", rows.number(0, "cells"));
  chart.series = {points_of(first, "speed_over_c", "hertz_duration", "Hertz"),
                  points_of(first, "speed_over_c", "known_duration", "finite sphere")};
  for (ChartSeries& line : chart.series) line.marked = false;
  for (const std::string& law : rows.distinct("law"))
    for (const double cells : rows.distinct_numbers("cells"))
      chart.series.push_back(points_of(rows.where("law", law).where("cells", cells), "speed_over_c",
                                       "duration", fmt::format("{}, {:g} cells", law, cells)));
  return chart;
}

std::string sphere_summary(const Table& spheres, const Table& impacts) {
  std::string lines;
  for (const std::string& on : spheres.distinct("on"))
    for (const double stiffness : spheres.where("on", on).distinct_numbers("stiffness")) {
      const Table rows = spheres.where("on", on).where("stiffness", stiffness);
      lines += fmt::format(
          "sphere on {}, stiffness {:g}: {} of {} rows ok, {} not claimed; force off by at most {:.1f} %\n",
          on, stiffness, rows.where("status", "ok").size(), rows.size(),
          rows.where("status", "not_claimed").size(), 100 * worst_claimed(rows, "force_error"));
    }
  for (const std::string& law : impacts.distinct("law"))
    for (const double cells : impacts.distinct_numbers("cells")) {
      const Table rows = impacts.where("law", law).where("cells", cells);
      if (rows.size() > 1)
        lines += fmt::format("impact on {}, {:g} cells: duration as speed^{:.3f}\n", law, cells,
                             exponent_of(rows));
    }
  return lines;
}

}  // namespace mss::studies::contact

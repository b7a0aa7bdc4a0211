// Charts of `mss validate relaxation`.
#include <fmt/format.h>

#include <cmath>

#include "experiments/studies/relaxation/relaxation.hpp"

namespace mss::studies::relaxation {

namespace {

ChartSeries column(const Table& rows, const char* x, const char* y, std::string label) {
  ChartSeries series{.label = std::move(label)};
  for (std::size_t r = 0; r < rows.size(); ++r)
    series.points.push_back({rows.number(r, x), rows.number(r, y)});
  return series;
}

Chart modulus_chart(const Table& all) {
  const double steps = all.distinct_numbers("steps_per_period").back();
  const Table rows = all.where("steps_per_period", steps);
  Chart chart{.title = "Complex modulus of a bar that relaxes",
              .subtitle = fmt::format("4 x 1 x 1 cells in axial strain, {:g} steps a period", steps),
              .x = {.label = "angular frequency x relaxation time", .logarithmic = true},
              .y = {.label = "modulus / Young's modulus at rest", .low = 0}};
  for (const char* part : {"storage", "loss"}) {
    chart.series.push_back(column(rows, "frequency", fmt::format("{}_exact", part).c_str(),
                                  fmt::format("{}, closed form", part)));
    chart.series.back().marked = false;
    chart.series.push_back(column(rows, "frequency", part, fmt::format("{}, measured", part)));
    chart.series.back().joined = false;
  }
  return chart;
}

Chart creep_chart(const Table& all) {
  Chart chart{.title = "Error of creep against the step",
              .subtitle = "a bar of 4 x 1 x 1 cells, 1 relaxation time after its load began",
              .x = {.label = "step / relaxation time", .logarithmic = true},
              .y = {.label = "error / strain at rest", .logarithmic = true}};
  for (const std::string& name : all.distinct("integrator"))
    chart.series.push_back(column(all.where("integrator", name).where("time", 1), "step", "error", name));
  return chart;
}

}  // namespace

Drawings draw_relaxation(const std::vector<NamedTable>& tables) {
  Drawings drawings;
  if (const Table& rows = find_table(tables, "relaxation"); rows.size() > 0)
    drawings.charts.push_back({"relaxation", modulus_chart(rows)});
  if (const Table& rows = find_table(tables, "relaxation_creep"); rows.size() > 0)
    drawings.charts.push_back({"relaxation_creep", creep_chart(rows)});
  return drawings;
}

}  // namespace mss::studies::relaxation

// Charts of bodies with cells of several sizes: errors against what they cost.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "experiments/studies/refine/maps.hpp"

namespace mss::studies::refine {

namespace {

struct Cost {
  const char* column;
  const char* file;
  const char* label;
  const char* unit;
};
constexpr std::array<Cost, 4> costs{
    {{"particles", "particles", "particles that move", ""},
     {"static_seconds", "static", "time of a static solution, its matrix included", "s"},
     {"period_seconds", "steps", "time of a period of the slowest vibration in safe steps of Verlet", "s"},
     {"local_period_seconds", "local_steps", "time of such a period, larger cells in longer steps", "s"}}};

std::string label_of(const std::string& map) {
  if (map == to_string(Map::uniform)) return "cells of one size";
  if (map == to_string(Map::by_hand)) return "smaller where stress concentrates, by hand";
  if (map == to_string(Map::estimated)) return "smaller where the estimate says";
  return "two layers of smaller ones at the surface";
}

Chart map_chart(const Table& rows, const Cost& cost) {
  Chart chart{.title = "A displacement under a load: cells of one size and of several",
              .subtitle = fmt::format("{}; nu = 0.3, t = 0.5", rows.text(0, "description")),
              .x = {.label = cost.label, .logarithmic = true, .unit = cost.unit},
              .y = {.label = "relative error", .logarithmic = true}};
  for (const std::string& map : rows.distinct("map")) {
    const Table of_map = rows.where("map", map);
    ChartSeries series{.label = label_of(map)};
    for (std::size_t r = 0; r < of_map.size(); ++r)
      series.points.push_back({of_map.number(r, cost.column), of_map.number(r, "error")});
    chart.series.push_back(std::move(series));
  }
  return chart;
}

}  // namespace

std::vector<NamedChart> map_charts(const Table& rows) {
  std::vector<NamedChart> charts;
  for (const std::string& problem : rows.distinct("problem")) {
    const Table of_problem = rows.where("problem", problem).where("status", "ok");
    std::string name = problem;
    std::replace(name.begin(), name.end(), ' ', '_');
    for (const Cost& cost : costs)
      if (of_problem.size() > 0)
        charts.push_back({fmt::format("refine_maps_{}_{}", name, cost.file), map_chart(of_problem, cost)});
  }
  return charts;
}

}  // namespace mss::studies::refine

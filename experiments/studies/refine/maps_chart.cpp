// Charts of bodies with cells of several sizes: errors against what they cost.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "experiments/studies/refine/answers.hpp"
#include "experiments/studies/refine/maps.hpp"

namespace mss::studies::refine {

namespace {

struct Cost {
  const char* column;
  const char* file;
  const char* in_title;
  std::string label;
  const char* unit;
};

std::array<Cost, 3> costs(const std::string& quantity) {
  std::string of_answer = "time of the run in safe steps of Verlet's method";
  if (quantity == to_string(Quantity::displacement))
    of_answer = "time of the static solution, its matrix included";
  if (quantity == to_string(Quantity::frequency)) of_answer = "time to find the mode";
  return {
      {{"particles", "particles", "particles", "particles that move", ""},
       {"answer_seconds", "answer", "time of one answer", of_answer, "s"},
       {"local_period_seconds", "steps", "time in local steps",
        "time of a period of the slowest vibration by Verlet's method, larger cells in longer steps", "s"}}};
}

std::string label_of(const std::string& map) {
  if (map == to_string(Map::uniform)) return "cells of one size";
  if (map == to_string(Map::by_hand)) return "smaller where stress concentrates, by hand";
  if (map == to_string(Map::estimated)) return "smaller where the estimate says";
  if (map == to_string(Map::for_time)) return "the same, deep cells last";
  return "two layers of smaller ones at the surface";
}

Chart map_chart(const Table& rows, const Cost& cost) {
  const std::string& quantity = rows.text(0, "quantity");
  Chart chart{.title = fmt::format("Cells of one size and of several: {}, by {}", rows.text(0, "problem"),
                                   cost.in_title),
              .subtitle = fmt::format("{}; nu = 0.3, t = 0.5", rows.text(0, "description")),
              .x = {.label = cost.label, .logarithmic = true, .unit = cost.unit},
              .y = {.label = fmt::format("relative error of the {}", quantity.substr(0, quantity.find(" ["))),
                    .logarithmic = true}};
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
    if (of_problem.size() == 0) continue;
    std::string name = problem;
    std::replace(name.begin(), name.end(), ' ', '_');
    for (const Cost& cost : costs(of_problem.text(0, "quantity")))
      charts.push_back({fmt::format("refine_maps_{}_{}", name, cost.file), map_chart(of_problem, cost)});
  }
  return charts;
}

}  // namespace mss::studies::refine

// Charts of `mss reduce`, from its tables alone.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "experiments/studies/reduce/reduce.hpp"

namespace mss::studies::reduce {

namespace {

/// Above it a model is of no use to anybody, however little it costs.
constexpr double largest_error = 0.1;

/// A model and how charts show it, alike in all of them.
struct Shown {
  const char* model;
  const char* label;
  int style;
};
constexpr std::array shown_models{Shown{"modal", "modal", 2}, Shown{"modal_warped", "warped modal", 3},
                                  Shown{"modal_cubic", "cubic in modes", 4}};

double cost_at(const Table& rows, std::size_t r) {
  return rows.number(r, "step_us") + rows.number(r, "draw_us");
}

/// The rows that no other beats in both cost and error, by cost.
std::vector<ChartPoint> pareto(const Table& rows) {
  std::vector<ChartPoint> points, best;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.text(r, "status") == "ok") points.push_back({cost_at(rows, r), rows.number(r, "error")});
  std::sort(points.begin(), points.end(), [](const ChartPoint& a, const ChartPoint& b) { return a.x < b.x; });
  for (const ChartPoint& point : points)
    if (best.empty() || point.y < best.back().y) best.push_back(point);
  return best;
}

Table lattices(const Table& rows, bool matched) {
  Table kept(rows.columns());
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.number(r, "modes") == 0 && matched == (rows.text(r, "model") != spring_model))
      kept.add(rows.rows()[r]);
  return kept;
}

Chart scene_chart(const Table& rows, const Table& scenes, const std::string& scene) {
  const Table about = scenes.where("scene", scene);
  Chart chart{.title = fmt::format("{}: error of a motion against the cost of a frame", scene),
              .subtitle = fmt::format("{}, {:g} particles, {}; one thread", about.text(0, "body"),
                                      about.number(0, "particles"), about.text(0, "description")),
              .times = true,
              .x = {.label = "steps and positions of a frame", .logarithmic = true, .unit = "s"},
              .y = {.label = "error over displacement", .logarithmic = true}};
  const Table of_scene = rows.where("scene", scene);
  const auto add = [&](const std::string& label, const Table& from, int style) {
    ChartSeries series{.label = label, .points = pareto(from), .style = style};
    for (ChartPoint& point : series.points) point.x *= 1e-6;
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  };
  add("lattices as they are", lattices(of_scene, false), 0);
  add("lattices with matched moduli", lattices(of_scene, true), 1);
  for (const Shown& model : shown_models) add(model.label, of_scene.where("model", model.model), model.style);
  return chart;
}

/// Of every scene and model the largest gain with a useful error.
Chart gain_chart(const Table& rows, const std::string& column, const std::string& over) {
  const std::vector<std::string> scenes = rows.distinct("scene");
  Chart chart{.title = "What fewer unknowns gain in the cost of a frame",
              .subtitle = fmt::format("over {} of no larger error; the best of each kind with an error of at "
                                      "most {:g} percent",
                                      over, 100 * largest_error),
              .times = true,
              .x = {.label = "gain; left of 1 is a loss", .logarithmic = true},
              .y = named_rows(scenes),
              .lines = {{ReferenceLine::Direction::vertical, 1, ""}}};
  const auto add = [&](const std::string& label, int style, const auto& rows_of) {
    ChartSeries series{.label = label, .style = style, .joined = false};
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      const Table of = rows_of(rows.where("scene", scenes[i]).where("status", "ok"));
      double best = 0;
      for (std::size_t r = 0; r < of.size(); ++r)
        if (of.number(r, "error") <= largest_error) best = std::max(best, of.number(r, column));
      if (best > 0) series.points.push_back({best, double(scenes.size() - i)});
    }
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  };
  if (column == "gain_unmatched")
    add("lattices with matched moduli", 1, [](const Table& of) { return lattices(of, true); });
  for (const Shown& model : shown_models)
    add(model.label, model.style, [&](const Table& of) { return of.where("model", model.model); });
  return chart;
}

}  // namespace

Drawings draw_reduce(const std::vector<NamedTable>& tables) {
  const Table& rows = find_table(tables, "reduce");
  const Table& scenes = find_table(tables, "reduce_scenes");
  Drawings drawings{
      .charts = {{"reduce", gain_chart(rows, "gain_unmatched", "the cheapest lattice as it is")},
                 {"reduce_over_matched",
                  gain_chart(rows, "gain_matched", "the cheapest lattice, as it is or matched,"), "reduce"}}};
  for (const std::string& scene : rows.distinct("scene"))
    drawings.charts.push_back({"reduce_" + scene, scene_chart(rows, scenes, scene), "reduce"});
  std::erase_if(drawings.charts, [](const NamedChart& chart) { return !has_points(chart.chart); });
  return drawings;
}

}  // namespace mss::studies::reduce

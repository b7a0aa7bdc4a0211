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
/// In scene charts and among losses alone.
constexpr std::array losing_models{
    Shown{"frames", "frames", 5}, Shown{"shape_matching", "shape matching, regions of one size", 6},
    Shown{"adaptive_shape_matching", "shape matching, regions of several sizes", 7}};

double cost_at(const Table& rows, std::size_t r) {
  return rows.number(r, "step_us") + rows.number(r, "draw_us");
}

/// All rows that ended well, by cost.
std::vector<ChartPoint> all_points(const Table& rows) {
  std::vector<ChartPoint> points;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.text(r, "status") == "ok") points.push_back({1e-6 * cost_at(rows, r), rows.number(r, "error")});
  std::sort(points.begin(), points.end(), [](const ChartPoint& a, const ChartPoint& b) { return a.x < b.x; });
  return points;
}

/// Those that no other beats in both cost and error.
std::vector<ChartPoint> pareto(const Table& rows) {
  std::vector<ChartPoint> best;
  for (const ChartPoint& point : all_points(rows))
    if (best.empty() || point.y < best.back().y) best.push_back(point);
  return best;
}

Table lattices(const Table& rows, bool matched) {
  Table kept(rows.columns());
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (const std::string& model = rows.text(r, "model");
        matched ? model.rfind("matched_", 0) == 0 : model == spring_model)
      kept.add(rows.rows()[r]);
  return kept;
}

/// Of models that reduce bodies, where their runs warn.
std::vector<ChartPoint> warned_points(const Table& rows) {
  std::vector<ChartPoint> points;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.text(r, "status") == "ok" && rows.number(r, "modes") > 0 && !rows.text(r, "warned").empty())
      points.push_back({1e-6 * cost_at(rows, r), rows.number(r, "error")});
  return points;
}

Chart scene_chart(const Table& rows, const Table& scenes, const std::string& scene) {
  const Table about = scenes.where("scene", scene);
  Chart chart{.title = fmt::format("{}: error against the cost of a frame", about.text(0, "label")),
              .subtitle = fmt::format("{}, {:g} particles, {}; one thread", about.text(0, "body"),
                                      about.number(0, "particles"), about.text(0, "description")),
              .times = true,
              .x = {.label = "steps and positions of a frame", .logarithmic = true, .unit = "s"},
              .y = {.label = "relative error", .logarithmic = true}};
  const Table of_scene = rows.where("scene", scene);
  const auto add = [&](const std::string& label, std::vector<ChartPoint> points, int style) {
    if (!points.empty())
      chart.series.push_back({.label = label, .points = std::move(points), .style = style});
  };
  add("lattices as they are", pareto(lattices(of_scene, false)), 0);
  add("lattices with matched moduli", pareto(lattices(of_scene, true)), 1);
  for (const Shown& model : shown_models)
    add(model.label, all_points(of_scene.where("model", model.model)), model.style);
  for (const Shown& model : losing_models)
    add(model.label, pareto(of_scene.where("model", model.model)), model.style);
  if (ChartSeries warned{.label = "a run of it warns", .points = warned_points(of_scene), .lines = false};
      !warned.points.empty())
    chart.series.push_back(std::move(warned));
  return chart;
}

/// Of every scene and model the largest gain with a useful error.
Chart gain_chart(const Table& rows, const Table& described, const std::string& column,
                 const std::string& over) {
  const std::vector<std::string> scenes = rows.distinct("scene");
  std::vector<std::string> labels;
  for (const std::string& scene : scenes) labels.push_back(described.where("scene", scene).text(0, "label"));
  Chart chart{.title = "What fewer unknowns gain in the cost of a frame",
              .subtitle = fmt::format("over {} of no larger error; the best with an error of at "
                                      "most {:g} percent",
                                      over, 100 * largest_error),
              .times = true,
              .x = {.label = "gain; left of 1 is a loss", .logarithmic = true},
              .y = named_rows(labels),
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

/// A model of a scene that costs more than a lattice of no larger error.
struct Loss {
  std::string label;
  double gain;
};

/// The row of the largest gain of those with a useful error; without one that of the smallest error.
std::size_t best_row(const Table& rows) {
  const auto is_useful = [&](std::size_t r) { return rows.number(r, "error") <= largest_error; };
  std::size_t best = 0;
  for (std::size_t r = 1; r < rows.size(); ++r)
    if (is_useful(r) && is_useful(best) ? rows.number(r, "gain_matched") > rows.number(best, "gain_matched")
                                        : rows.number(r, "error") < rows.number(best, "error"))
      best = r;
  return best;
}

/// Of every scene and model the best row, if it loses.
std::vector<Loss> losses_of(const Table& rows) {
  std::vector<Loss> losses;
  const auto add = [&](const std::string& scene, const Shown& model) {
    const Table of = rows.where("scene", scene).where("model", model.model).where("status", "ok");
    if (of.size() == 0) return;
    const std::size_t best = best_row(of);
    if (of.number(best, "gain_matched") < 1)
      losses.push_back(
          {fmt::format("{}, {}: {:.3g} percent", scene, model.label, 100 * of.number(best, "error")),
           of.number(best, "gain_matched")});
  };
  for (const std::string& scene : rows.distinct("scene")) {
    for (const Shown& model : shown_models) add(scene, model);
    for (const Shown& model : losing_models) add(scene, model);
  }
  return losses;
}

Chart loss_chart(const Table& rows) {
  std::vector<std::string> names;
  ChartSeries series{.label = "", .style = 0, .joined = false};
  const std::vector<Loss> losses = losses_of(rows);
  for (const Loss& loss : losses) {
    series.points.push_back({loss.gain, double(losses.size() - names.size())});
    names.push_back(loss.label);
  }
  Chart chart{.title = "Where fewer unknowns lose",
              .subtitle =
                  "of each model that costs more than a lattice of no larger error the best setting, "
                  "with its error",
              .times = true,
              .x = {.label = "gain in a frame's cost", .logarithmic = true},
              .y = named_rows(names),
              .lines = {{ReferenceLine::Direction::vertical, 1, ""}}};
  if (!losses.empty()) chart.series.push_back(std::move(series));
  return chart;
}

}  // namespace

Drawings draw_reduce(const std::vector<NamedTable>& tables) {
  const Table& rows = find_table(tables, "reduce");
  const Table& scenes = find_table(tables, "reduce_scenes");
  Drawings drawings{
      .charts = {
          {"reduce", gain_chart(rows, scenes, "gain_unmatched", "the cheapest lattice as it is")},
          {"reduce_over_matched",
           gain_chart(rows, scenes, "gain_matched", "the cheapest lattice, as it is or matched,"), "reduce"},
          {"reduce_losses", loss_chart(rows), "reduce"}}};
  for (const std::string& scene : rows.distinct("scene"))
    drawings.charts.push_back({"reduce_" + scene, scene_chart(rows, scenes, scene), "reduce"});
  std::erase_if(drawings.charts, [](const NamedChart& chart) { return !has_points(chart.chart); });
  return drawings;
}

}  // namespace mss::studies::reduce

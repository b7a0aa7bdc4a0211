// Charts of bodies and scenes whose frames are solved, from their tables alone.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "experiments/studies/convergence/scenes.hpp"

namespace mss::studies::convergence {

namespace {

constexpr double charted_poisson = 0.3;
constexpr double lowest_charted = 1e-4, highest_charted = 1;

/// Styles of a solver for the first body of a chart, a solid line, and for the second, a dashed one.
constexpr std::array<std::array<int, 2>, 5> styles{{{4, 5}, {0, 1}, {6, 7}, {10, 11}, {12, 13}}};

/// A row of a table as words.
std::string words(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

/// As far as errors are charted, and one more, on the lower edge.
std::vector<ChartPoint> error_points(const Table& rows) {
  std::vector<ChartPoint> points;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const double error = rows.number(r, "error");
    if (!(error <= highest_charted)) continue;
    points.push_back({rows.number(r, "iterations"), std::max(error, lowest_charted)});
    if (error <= lowest_charted) break;
  }
  return points;
}

/// Error against iterations of one body or two.
Chart bodies_chart(const Table& rows, const std::vector<std::string>& bodies, const Table& references) {
  Chart chart{.title = "Distance from the converged step of a frame against iterations",
              .subtitle = "",
              .x = {.label = "iterations", .logarithmic = true},
              .y = {.label = "distance / displacement, median of frames",
                    .logarithmic = true,
                    .low = lowest_charted,
                    .high = highest_charted},
              .lines = {{ReferenceLine::Direction::horizontal, 1e-2, "1 percent"},
                        {ReferenceLine::Direction::horizontal, 1e-3, "0.1 percent"}}};
  const std::string description = references.where("scene", bodies.front()).text(0, "description");
  chart.subtitle = "frames of 1/60 s by backward Euler, cells a metre in the legend" +
                   description.substr(std::min(description.find(';'), description.size()));
  const std::vector<std::string> solvers = rows.where("scene", bodies.front()).distinct("solver");
  for (std::size_t s = 0; s < solvers.size(); ++s)
    for (std::size_t b = 0; b < bodies.size(); ++b)
      chart.series.push_back(
          {.label = fmt::format("{}, {}", solvers[s], words(bodies[b])),
           .points = error_points(rows.where("scene", bodies[b]).where("solver", solvers[s])),
           .style = styles[s % styles.size()][b]});
  return chart;
}

Chart scenes_chart(const Table& scenes) {
  std::vector<std::string> names;
  std::vector<Table> tables;
  for (const std::string& scene : scenes.distinct("scene")) {
    names.push_back(words(scene));
    tables.push_back(scenes.where("scene", scene));
  }
  Chart chart = time_to_percent(names, tables, scenes.distinct("solver"));
  chart.title = "Time to within 1 percent of the converged step of a frame";
  chart.subtitle =
      "scenes that people have; 1/60 s by backward Euler, each of six frames; one thread, without set-up";
  chart.x.label = "processor time of a step [ms]";
  return chart;
}

}  // namespace

std::vector<NamedChart> step_charts(const std::vector<NamedTable>& tables) {
  if (std::none_of(tables.begin(), tables.end(),
                   [](const NamedTable& table) { return table.name == "convergence_bodies"; }))
    return {};
  const Table &bodies = find_table(tables, "convergence_bodies"),
              &rows = find_table(tables, "convergence_steps"),
              &references = find_table(tables, "convergence_references"),
              &scenes = find_table(tables, "convergence_scenes");
  std::vector<NamedChart> charts;
  const std::vector<std::string> names = bodies.where("poisson", charted_poisson).distinct("scene");
  constexpr std::size_t together = 2;
  for (std::size_t i = 0; i < names.size(); i += together) {
    std::vector<std::string> some(names.begin() + std::ptrdiff_t(i),
                                  names.begin() + std::ptrdiff_t(std::min(i + together, names.size())));
    charts.push_back(
        {"convergence_bodies_" + some.front(), bodies_chart(rows, some, references), "convergence_steps"});
  }
  if (scenes.size() > 0) charts.push_back({"convergence_scenes", scenes_chart(scenes)});
  return charts;
}

}  // namespace mss::studies::convergence

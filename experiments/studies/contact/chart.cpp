// Charts of `mss validate contact`.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/studies/contact/contact.hpp"

namespace mss::studies::contact {

namespace {

/// What is drawn, from the given coefficient and the measured value of a row.
using Ordinate = double (*)(double given, double measured);

/// The rows of a chart: one method, pushes along an edge.
Table charted(const Table& rows, Study study) {
  return rows.where("study", to_string(study))
      .where("integrator", charted_integrator(rows))
      .where("angle", 0.0);
}

/// One law and body against the given coefficient; failures are counted in the legend.
ChartSeries series_of(const Table& runs, const std::string& label, Ordinate shown) {
  ChartSeries series{.label = label};
  int failed = 0;
  std::string why;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const double given = runs.number(r, "coefficient");
    if (runs.text(r, "status") == "ok") {
      series.points.push_back({given, shown(given, runs.number(r, "value"))});
    } else {
      ++failed;
      why = runs.text(r, "status");
    }
  }
  if (failed > 0) series.label += fmt::format(" ({} failed: {})", failed, why);
  return series;
}

void add_series(Chart& chart, const Table& rows, Study study, const std::vector<BodyKind>& bodies,
                Ordinate shown) {
  const Table runs = charted(rows, study);
  for (const BodyKind body : bodies)
    for (const std::string& law : rows.distinct("law"))
      chart.series.push_back(series_of(runs.where("body", to_string(body)).where("law", law),
                                       fmt::format("{}, {}", law, to_string(body)), shown));
}

/// Largest relative deviation from the law, by experiment and law of contact.
Chart laws_chart(const Table& rows) {
  struct Experiment {
    Study study;
    BodyKind body;
    const char* name;
  };
  constexpr Experiment experiments[]{{Study::bounce, BodyKind::particle, "bounces, a particle"},
                                     {Study::stop, BodyKind::particle, "pushes, a particle"},
                                     {Study::stop, BodyKind::block, "pushes, a block"},
                                     {Study::slope, BodyKind::particle, "a slope, a particle"},
                                     {Study::slope, BodyKind::block, "a slope, a block"}};
  std::vector<std::string> names;
  for (const Experiment& e : experiments) names.emplace_back(e.name);
  Chart chart{
      .title = "Contact: largest error over all coefficients",
      .subtitle = fmt::format("of the height of bounces, of the distance after pushes and down a slope, "
                              "each over that of the law; {}",
                              charted_integrator(rows)),
      .x = {.label = "largest relative error", .logarithmic = true},
      .y = named_rows(names)};
  for (const std::string& law : rows.distinct("law")) {
    ChartSeries series{.label = law, .joined = false};
    for (std::size_t e = 0; e < names.size(); ++e) {
      const Table runs = charted(rows, experiments[e].study)
                             .where("body", to_string(experiments[e].body))
                             .where("law", law)
                             .where("status", "ok");
      double worst = 0;
      for (std::size_t r = 0; r < runs.size(); ++r) worst = std::max(worst, runs.number(r, "error"));
      if (worst > 0) series.points.push_back({worst, chart.y.ticks[e]});
      if (runs.size() == 0) series.label += fmt::format(" ({}: failed)", names[e]);
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

Chart stop_chart(const Table& rows) {
  Chart chart{.title = "Friction: error of the stopping distance after a push",
              .subtitle = fmt::format("2 m/s along an edge on level ground; by the law v^2 / (2 mu g); {}",
                                      charted_integrator(rows)),
              .x = {.label = "given coefficient of friction, mu", .low = 0},
              .y = {.label = "| distance / that of the law - 1 |", .logarithmic = true}};
  add_series(chart, rows, Study::stop, {BodyKind::particle, BodyKind::block},
             [](double given, double measured) { return std::abs(given / measured - 1); });
  return chart;
}

Chart rest_chart(const Table& rows, const Table& rest) {
  constexpr double lowest = 1e-35;  // below, nothing moves
  Chart chart{.title = "Coming to rest",
              .subtitle = fmt::format("the thesis's cube, dropped spinning; e = 0.5, mu = 0.4; {}",
                                      charted_integrator(rows)),
              .x = {.label = "time [s]"},
              .y = {.label = "kinetic energy / its peak", .logarithmic = true}};
  for (const std::string& law : rows.distinct("law")) {
    ChartSeries series{.label = law};
    for (std::size_t r = 0; r < rest.size(); ++r)
      if (rest.text(r, "law") == law && rest.number(r, "kinetic_over_peak") > lowest)
        series.points.push_back({rest.number(r, "t"), rest.number(r, "kinetic_over_peak")});
    chart.series.push_back(std::move(series));
  }
  return chart;
}

}  // namespace

std::string charted_integrator(const Table& rows) {
  const Table blocks = rows.where("body", to_string(BodyKind::block));
  const std::vector<std::string> methods = (blocks.size() > 0 ? blocks : rows).distinct("integrator");
  const bool has_verlet = std::find(methods.begin(), methods.end(), "verlet") != methods.end();
  return has_verlet ? "verlet" : methods.front();
}

Drawings draw_contact(const std::vector<NamedTable>& tables) {
  const Table& rows = find_table(tables, "contact");
  const Table& floor = find_table(tables, "contact_floor");
  Drawings drawings;
  if (rows.size() > 0)
    drawings.charts = {{"contact", laws_chart(rows)},
                       {"contact_stop", stop_chart(rows)},
                       {"contact_rest", rest_chart(rows, find_table(tables, "contact_rest"))}};
  if (const Table* bars = rows_of(tables, "contact_bars"))
    drawings.charts.push_back({"contact_bars", bars_chart(*bars)});
  if (const Table* spheres = rows_of(tables, "contact_sphere"))
    drawings.charts.push_back({"contact_sphere", sphere_chart(*spheres)});
  if (const Table* impacts = rows_of(tables, "contact_impact"))
    drawings.charts.push_back({"contact_impact", impact_chart(*impacts)});
  add_robustness_charts(tables, drawings);
  if (floor.size() == 0) return drawings;
  drawings.charts.push_back({"contact_floor_steps", floor_steps_chart(floor)});
  drawings.maps.push_back({"contact_floor", floor_map(floor)});
  return drawings;
}

}  // namespace mss::studies::contact

// Charts of `mss recovery`, from its tables.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/studies/recovery/recovery.hpp"

namespace mss::studies::recovery {

namespace {

std::vector<std::string> texts(const Table& table, std::string_view column) {
  std::vector<std::string> out;
  for (std::size_t r = 0; r < table.size(); ++r) out.push_back(table.text(r, column));
  return out;
}

double index_of(const std::vector<std::string>& names, const std::string& name) {
  return double(std::find(names.begin(), names.end(), name) - names.begin());
}

/// Seeds of a state: one number for all models, or the least and the greatest.
std::string seeds_text(const Table& rows) {
  double least = rows.number(0, "trials"), most = least;
  for (std::size_t r = 1; r < rows.size(); ++r) {
    least = std::min(least, rows.number(r, "trials"));
    most = std::max(most, rows.number(r, "trials"));
  }
  return least == most ? fmt::format("{:g}", most) : fmt::format("{:g} to {:g}", least, most);
}

Chart models_chart(const Table& rows, const Table& models) {
  const std::vector<std::string> names = texts(models.where("guarded", 0.0), "model");
  Chart chart{.title = "Share of trapped states from which a cube recovers",
              .subtitle = "",
              .x = {.label = "share of trials that recovered", .low = -0.03, .high = 1.03},
              .y = named_rows(names)};
  if (rows.size() == 0) return chart;  // interrupted before
  chart.subtitle = fmt::format("cube of 3 x 3 x 3 cells, released from {} trapped states; seeds of each: {}",
                               rows.distinct("state").size(), seeds_text(rows));
  for (const bool guarded : {false, true}) {
    ChartSeries series{.label = guarded ? "with fold guard" : "without fold guard",
                       .style = guarded ? 9 : 0,
                       .joined = false};
    const Table of_guard = models.where("guarded", guarded ? 1.0 : 0.0);
    for (std::size_t m = 0; m < of_guard.size(); ++m)
      if (const double row = index_of(names, of_guard.text(m, "unguarded")); row < double(names.size()))
        series.points.push_back({recovered_share(rows.where("model", of_guard.text(m, "model"))),
                                 chart.y.ticks[std::size_t(row)]});
    chart.series.push_back(std::move(series));
  }
  return chart;
}

/// A model in the little width of a column of the map: t over nu.
std::string short_name(const Table& models, std::size_t m) {
  const std::string& stiffness = models.text(m, "stiffness");
  if (stiffness == to_string(Stiffness::thesis_springs)) return "T";
  const bool springs = stiffness == to_string(Stiffness::calibrated_springs);
  return (springs ? short_number(models.number(m, "face_share")) : "FE") + "\n" +
         short_number(models.number(m, "poisson"));
}

/// How a rate is drawn: index into the map's kinds.
int kind_of(double rate) { return rate == 1 ? 0 : rate > 0.5 ? 1 : rate > 0 ? 2 : 3; }

/// `models`: those of the panel.
MapPanel states_panel(const Table& rows, const Table& models, const std::vector<std::string>& states,
                      const std::string& title) {
  MapPanel panel{.title = title};
  ChartAxis x{.label = "", .low = 0.4, .high = double(models.size()) + 0.6};
  for (std::size_t m = 0; m < models.size(); ++m) {
    const double column = double(m) + 1;
    x.ticks.push_back(column);
    x.names.push_back(short_name(models, m));
    const Table of_model = rows.where("model", models.text(m, "model"));
    for (std::size_t r = 0; r < of_model.size(); ++r) {
      const double y = double(states.size()) - index_of(states, of_model.text(r, "state"));
      panel.cells.push_back(
          {column - 0.45, column + 0.45, y - 0.4, y + 0.4, kind_of(of_model.number(r, "rate"))});
    }
  }
  panel.x = x;
  return panel;
}

MapChart states_map(const Table& rows, const Table& models) {
  const std::vector<std::string> states = rows.distinct("state");
  MapChart chart{
      .title = "Recovery from trapped states, per model",
      .subtitle =
          "share of seeds that recover; numbers after states: cells; columns: face share t over nu, "
          "T: thesis's springs, FE: finite elements",
      .x = {.label = ""},
      .y = named_rows(states),
      .kinds = {"all recover", "more than half", "half or less", "none"},
      .panel_height = 640};
  for (const bool guarded : {false, true})
    if (const Table of_guard = models.where("guarded", guarded ? 1.0 : 0.0); of_guard.size() > 0)
      chart.panels.push_back(
          states_panel(rows, of_guard, states, guarded ? "with fold guard" : "without fold guard"));
  return chart;
}

/// "tried from 5 to 485 m/s, ..."
std::string speeds_text(const Table& speeds) {
  if (speeds.size() < 2) return "";
  const double first = speeds.number(0, "speed"), second = speeds.number(1, "speed"),
               last = speeds.number(speeds.size() - 1, "speed");
  return fmt::format("; tried from {:.3g} to {:.3g} m/s, each speed {:g} times the one before", first, last,
                     second / first);
}

struct LandingSeries {
  const char* label;
  int style;
  bool guarded, recovers;  ///< at every speed tried
};

/// `rows`: names of the chart's rows, "MODEL, LANDING" with the model's name without guard.
ChartSeries landing_series(const LandingSeries& kind, const Table& landings, const Table& models,
                           const std::vector<std::string>& rows, const ChartAxis& y) {
  ChartSeries series{.label = kind.label, .style = kind.style, .joined = false};
  const Table of_guard = landings.where("guarded", kind.guarded ? 1.0 : 0.0);
  for (std::size_t r = 0; r < of_guard.size(); ++r) {
    const double failed_at = of_guard.number(r, "lowest_unrecovered");
    if (std::isfinite(failed_at) == kind.recovers) continue;
    const std::string unguarded = models.where("model", of_guard.text(r, "model")).text(0, "unguarded");
    const double row = index_of(rows, unguarded + ", " + of_guard.text(r, "landing"));
    series.points.push_back(
        {kind.recovers ? of_guard.number(r, "highest_recovered") : failed_at, y.ticks[std::size_t(row)]});
  }
  return series;
}

Chart landings_chart(const Table& landings, const Table& models, const Table& speeds) {
  std::vector<std::string> rows;
  for (std::size_t r = 0; r < landings.size(); ++r) {
    const std::string name = models.where("model", landings.text(r, "model")).text(0, "unguarded") + ", " +
                             landings.text(r, "landing");
    if (std::find(rows.begin(), rows.end(), name) == rows.end()) rows.push_back(name);
  }
  Chart chart{
      .title = "Landing speed from which a cube no longer recovers (Fig. 5-4)",
      .subtitle = "cube of 3 x 3 x 3 cells" + speeds_text(speeds),
      .x = {.label = "landing speed [m/s]", .logarithmic = true, .ticks = {5, 10, 20, 50, 100, 200, 500}},
      .y = named_rows(rows)};
  for (const LandingSeries& kind :
       {LandingSeries{"no guard: lowest speed without recovery", 0, false, false},
        LandingSeries{"with fold guard: lowest speed without recovery", 9, true, false},
        LandingSeries{"no guard: recovered at every speed tried", 3, false, true},
        LandingSeries{"with fold guard: recovered at every speed tried", 7, true, true}}) {
    ChartSeries series = landing_series(kind, landings, models, rows, chart.y);
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  }
  return chart;
}

}  // namespace

double recovered_share(const Table& rows) {
  double recovered = 0, trials = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    recovered += rows.number(r, "recovered");
    trials += rows.number(r, "trials");
  }
  return recovered / trials;
}

Drawings draw_recovery(const std::vector<NamedTable>& tables) {
  const Table &rows = find_table(tables, "recovery"), &landings = find_table(tables, "recovery_landing"),
              &models = find_table(tables, "recovery_models"),
              &speeds = find_table(tables, "recovery_speeds");
  return {.charts = {{"recovery", models_chart(rows, models)},
                     {"recovery_landing", landings_chart(landings, models, speeds)}},
          .maps = {{"recovery_states", states_map(rows, models)}}};
}

}  // namespace mss::studies::recovery

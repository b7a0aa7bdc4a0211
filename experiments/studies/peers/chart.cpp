// Charts of `mss peers`, from its tables alone.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "experiments/studies/peers/peers.hpp"

namespace mss::studies::peers {

namespace {

/// Styles of curves, families in turn, that are told apart in grey and on a grid.
constexpr std::array<int, 15> family_styles{0, 1, 2, 15, 4, 5, 6, 7, 8, 14, 10, 11, 12, 13, 16};

/// A family's rows of a scene as points of its time and what `value` says of a row, by time.
ChartSeries curve(const Table& rows, const std::string& family, const std::string& column, double least,
                  double most) {
  ChartSeries series{.label = family};
  const Table own = rows.where("family", family);
  for (std::size_t r = 0; r < own.size(); ++r) {
    const double error = std::abs(own.number(r, column)), time = own.number(r, "cpu_ms_per_frame");
    if (std::isfinite(error) && std::isfinite(time))
      series.points.push_back({time, std::clamp(100 * error, least, most)});
  }
  // A sweep of two numbers is no curve.
  series.joined = own.distinct_numbers("step").size() == 1 || own.distinct_numbers("iterations").size() == 1;
  std::sort(series.points.begin(), series.points.end(),
            [](const ChartPoint& a, const ChartPoint& b) { return a.x < b.x; });
  return series;
}

/// How far to the right WebAssembly may have moved a point: no engine's, and below all of them.
ChartSeries webassembly_scale(double at, double y) {
  return {.label = fmt::format("WebAssembly: up to {} x", most_price_of_webassembly),
          .points = {{at, y}, {most_price_of_webassembly * at, y}},
          .style = 20,
          .marked = false};
}

Chart error_chart(const Table& rows, const std::string& column, const std::string& what) {
  constexpr double least = 0.1, most = 1000;
  Chart chart{
      .title = "Error of a cantilever's " + what + " against the time of a frame",
      .subtitle = fmt::format("{} particles, E = 1 MPa, ν = 0.3; dips: errors of opposite sign cancel; "
                              "beyond the ends drawn there; *: recalibrated",
                              rows.number(0, "particles")),
      .times = true,
      .x = {.label = "processor time of a frame of 1/60 s [ms]", .logarithmic = true},
      .y = {.label = "error, of either sign [%]", .logarithmic = true, .low = least, .high = most}};
  for (const std::string& family : rows.distinct("family"))
    if (ChartSeries series = curve(rows, family, column, least, most); !series.points.empty()) {
      series.style = family_styles[chart.series.size() % family_styles.size()];
      chart.series.push_back(std::move(series));
    }
  if (!chart.series.empty()) chart.series.push_back(webassembly_scale(0.02, 0.13));
  return chart;
}

/// Families as rows; of every scene and setting a marker of `value` of a row.
template <class Value>
void add_markers(Chart& chart, const std::vector<std::string>& families, const Table& rows,
                 const std::string& label, Value&& value) {
  ChartSeries series{.label = label, .joined = false};
  for (std::size_t i = 0; i < families.size(); ++i) {
    const Table own = rows.where("family", families[i]);
    for (std::size_t r = 0; r < own.size(); ++r)
      if (const double x = value(own, r); std::isfinite(x))
        series.points.push_back({x, double(families.size() - i)});
  }
  if (!series.points.empty()) chart.series.push_back(std::move(series));
}

/// Families that have a number, of rows that count.
template <class Value>
std::vector<std::string> families_with(const Table& rows, Value&& value) {
  std::vector<std::string> families;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (std::isfinite(value(rows, r)) &&
        std::count(families.begin(), families.end(), rows.text(r, "family")) == 0)
      families.push_back(rows.text(r, "family"));
  return families;
}

std::string body_of(const std::string& scene) {
  return scene.find("ball") != std::string::npos ? "a ball of 8 cells across" : "a cube of 7 cells an edge";
}

/// Missing of what has no modulus, and of a body that is still in the air: its motion is nearly as far from
/// the true one as that is long.
double squeezed(const Table& rows, std::size_t r) {
  constexpr double in_the_air = 0.4;
  const bool counts =
      rows.text(r, "family") != "Bullet links" && !(rows.number(r, "motion_error") > in_the_air);
  return counts ? rows.number(r, "volume_low") : no_value;
}

Chart volume_chart(const Table& rows) {
  const std::vector<std::string> families = families_with(rows, squeezed);
  Chart chart{.title = "How far a body that lands is squeezed",
              .subtitle =
                  "dropped from 0.5 m; E = 0.1 MPa, ν = 0.3; a marker a setting; *: recalibrated; left out: "
                  "what never "
                  "lands",
              .x = {.label = "smallest volume over that at rest", .low = 0, .high = 1},
              .y = named_rows(families)};
  for (const std::string& scene : rows.distinct("scene"))
    add_markers(chart, families, rows.where("scene", scene), body_of(scene), squeezed);
  return chart;
}

Chart penetration_chart(const Table& rows) {
  const std::vector<std::string> families = rows.distinct("family");
  Chart chart{.title = "How deep a body that lands is in the ground",
              .subtitle =
                  "dropped from 0.5 m; a marker for every step and number of iterations; *: contacts of "
                  "solref 0.004 1",
              .x = {.label = "deepest particle behind the plane [m]", .low = 0},
              .y = named_rows(families)};
  for (const std::string& scene : rows.distinct("scene"))
    add_markers(chart, families, rows.where("scene", scene), body_of(scene),
                [](const Table& own, std::size_t r) { return own.number(r, "penetration"); });
  return chart;
}

Chart spin_chart(const Table& rows) {
  constexpr double least = 1e-10;
  const std::vector<std::string> families = rows.distinct("family");
  Chart chart{
      .title = "Momentum and spin of a cube in a second of free flight",
      .subtitle =
          fmt::format("{} particles, E = 0.1 MPa, 6 rad/s; a marker a setting; below 1e-10 drawn there; "
                      "*: recalibrated",
                      rows.number(0, "particles")),
      .x = {.label = "largest distance from that at the start, relative", .logarithmic = true, .low = least},
      .y = named_rows(families)};
  for (const auto& [column, label] :
       {std::pair{"spin_drift", "angular momentum"}, {"momentum_drift", "momentum"}})
    add_markers(chart, families, rows, label, [&](const Table& own, std::size_t r) {
      const double drift = own.number(r, column);
      return std::isfinite(drift) ? std::max(drift, least) : no_value;
    });
  return chart;
}

std::vector<NamedChart> landing_charts(const Table& rows) {
  return {{"peers_volume", volume_chart(rows), "peers_landing"},
          {"peers_penetration", penetration_chart(rows), "peers_landing"}};
}

}  // namespace

Drawings draw_peers(const std::vector<NamedTable>& tables) {
  Drawings drawings;
  const Table& rows = find_table(tables, "peers");
  const std::vector<std::string> scenes = rows.distinct("scene");
  if (scenes.empty()) return drawings;
  const bool has_finer = std::count(scenes.begin(), scenes.end(), "cantilever_4") > 0;
  const std::string first = has_finer ? "cantilever_4" : scenes[0];
  drawings.charts.push_back({"peers", error_chart(rows.where("scene", first), "tip_error", "tip at rest")});
  for (const std::string& scene : scenes) {
    if (scene != first)
      drawings.charts.push_back(
          {"peers_" + scene, error_chart(rows.where("scene", scene), "tip_error", "tip at rest"), "peers"});
    drawings.charts.push_back({"peers_period_" + scene,
                               error_chart(rows.where("scene", scene), "period_error", "period"), "peers"});
  }
  for (const NamedTable& table : tables) {
    if (table.name == "peers_landing" && table.table.size() > 0)
      for (NamedChart& chart : landing_charts(table.table)) drawings.charts.push_back(std::move(chart));
    if (table.name == "peers_flight" && table.table.size() > 0)
      drawings.charts.push_back({"peers_spin", spin_chart(table.table), table.name});
  }
  std::erase_if(drawings.charts, [](const NamedChart& chart) { return !has_points(chart.chart); });
  return drawings;
}

}  // namespace mss::studies::peers

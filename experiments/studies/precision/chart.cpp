#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "experiments/simulation/model.hpp"
#include "experiments/studies/precision/precision.hpp"

namespace mss::studies::precision {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// Families of the methods in a table, in their order.
std::vector<std::string> families(const Table& rows) {
  std::vector<std::string> all;
  for (const std::string& integrator : rows.distinct("integrator"))
    if (std::find(all.begin(), all.end(), family_of(integrator)) == all.end())
      all.push_back(family_of(integrator));
  return all;
}

std::vector<std::string> members_of(const Table& rows, const std::string& family) {
  std::vector<std::string> members;
  for (const std::string& integrator : rows.distinct("integrator"))
    if (family_of(integrator) == family) members.push_back(integrator);
  return members;
}

/// A member's name where there is only one, else as in "vbd, best of 1, 5, 20"; "all" is to the tolerance.
std::string family_label(const std::string& family, const std::vector<std::string>& members) {
  if (members.size() == 1) return members[0];
  std::vector<std::string> counts;
  counts.reserve(members.size());
  for (const std::string& member : members)
    counts.push_back(member != family                   ? member.substr(family.size() + 1)
                     : find_integrator(family).implicit ? "all"
                                                        : "1");
  return fmt::format("{}, best of {}", family, fmt::join(counts, ", "));
}

/// Of points of several members of a family those that no other beats in both error and cost.
std::vector<ChartPoint> envelope(std::vector<ChartPoint> points) {
  std::sort(points.begin(), points.end(), [](const ChartPoint& a, const ChartPoint& b) { return a.x < b.x; });
  std::vector<ChartPoint> best;
  for (const ChartPoint& point : points)
    if (std::isfinite(point.y) && (best.empty() || point.y < best.back().y)) best.push_back(point);
  return best;
}

/// The cheapest run of a family that meets an error.
struct Cheapest {
  std::string integrator;  ///< of the family
  double seconds = infinity;
  double value = none;  ///< its step [s] or tolerance
};
Cheapest cheapest(const Table& runs, const std::string& family, double error) {
  Cheapest best{family};
  for (std::size_t r = 0; r < runs.size(); ++r)
    if (family_of(runs.text(r, "integrator")) == family && runs.number(r, "error") <= error &&
        runs.number(r, "seconds") < best.seconds)
      best = {runs.text(r, "integrator"), runs.number(r, "seconds"), runs.number(r, "value")};
  return best;
}

/// Of all families that meet an error in the runs of one scene, cheapest first.
std::vector<Cheapest> ranking(const Table& runs, double error) {
  std::vector<Cheapest> all;
  for (const std::string& family : families(runs))
    if (const Cheapest c = cheapest(runs, family, error); std::isfinite(c.seconds)) all.push_back(c);
  std::sort(all.begin(), all.end(),
            [](const Cheapest& a, const Cheapest& b) { return a.seconds < b.seconds; });
  return all;
}

double geometric_mean(const std::vector<double>& numbers) {
  double sum = 0;
  for (const double x : numbers) sum += std::log(x);
  return std::exp(sum / double(numbers.size()));
}

double power_of_ten(double value, bool up) {
  const double exponent = std::log10(value);
  return std::pow(10, up ? std::ceil(exponent + 1e-9) : std::floor(exponent - 1e-9));
}

const char* column_of(Cost cost) { return cost == Cost::wall_time ? "seconds" : "force_evaluations"; }

/// A line at ten uncertainties of the reference: smaller errors are not significant. Returns its place, or
/// infinity if there is no reference.
double add_uncertainty(Chart& chart, const Table& reference) {
  if (reference.size() == 0 || reference.text(0, "status") != "ok") return infinity;
  const double floor = 10 * reference.number(0, "uncertainty");
  chart.lines.push_back(
      {ReferenceLine::Direction::horizontal, floor, "ten times the uncertainty of the reference"});
  return floor;
}

/// A series for each reason of failure, its markers on the upper edge.
void add_failures(Chart& chart, const Table& runs, Cost cost) {
  std::map<std::string, ChartSeries> failed;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const std::string& status = runs.text(r, "status");
    if (status == "ok") continue;
    ChartSeries& series = failed[status];
    series.label = "failed: " + status;
    series.lines = false;
    series.points.push_back({runs.number(r, column_of(cost)), precision_worst});
  }
  for (auto& [status, series] : failed) chart.series.push_back(std::move(series));
}

}  // namespace

Table precision_summary(const Table& rows) {
  Table summary({{"scene"},
                 {"error"},
                 {"integrator"},
                 {"value"},
                 {"seconds", "s"},
                 {"runner_up"},
                 {"cost_ratio"},
                 {"comparison"},
                 {"status"}});
  for (const std::string& scene : rows.distinct("scene"))
    for (const double error : {1e-2, 1e-3, 1e-6}) {
      const std::vector<Cheapest> all = ranking(rows.where("scene", scene), error);
      if (all.empty()) {
        summary.add({scene, error, std::string("none"), none, none, std::string(), none,
                     std::string("no method reached it in the time allowed"), std::string("not reached")});
        continue;
      }
      const bool alone = all.size() == 1;
      const double ratio = alone ? none : all[1].seconds / all[0].seconds;
      summary.add({scene, error, all[0].integrator, all[0].value, all[0].seconds,
                   alone ? std::string() : all[1].integrator, ratio,
                   alone ? std::string("no other reached it")
                         : fmt::format("next: {}, {:.2g} times the cost", all[1].integrator, ratio),
                   std::string(alone ? "no runner-up" : "ok")});
    }
  return summary;
}

Chart precision_chart(const Table& rows, const Table& references, const std::string& scene, Cost cost) {
  const bool time = cost == Cost::wall_time;
  const Table reference = references.where("scene", scene), runs = rows.where("scene", scene);
  Chart chart{.title = time ? "Error against wall time" : "Error against force evaluations",
              .subtitle = reference.size() > 0 ? reference.text(0, "description") : scene,
              .x = {.label = time ? "wall time of the run" : "force evaluations of the run",
                    .logarithmic = true,
                    .unit = time ? "s" : ""},
              .y = {.label = "error of positions / displacement", .logarithmic = true}};
  double left = infinity, right = 0, lowest = 1;
  for (const std::string& family : families(rows)) {
    const std::vector<std::string> members = members_of(rows, family);
    ChartSeries series{.label = family_label(family, members)};
    for (std::size_t r = 0; r < runs.size(); ++r) {
      if (family_of(runs.text(r, "integrator")) != family) continue;
      const double x = runs.number(r, column_of(cost)), error = runs.number(r, "error");
      left = std::min(left, x);
      right = std::max(right, x);
      if (runs.text(r, "status") == "ok") series.points.push_back({x, error});
      if (std::isfinite(error)) lowest = std::min(lowest, error);
    }
    if (members.size() > 1) series.points = envelope(std::move(series.points));
    chart.series.push_back(std::move(series));
  }
  add_failures(chart, runs, cost);
  lowest = std::min(lowest, add_uncertainty(chart, reference));
  chart.x.low = power_of_ten(left, false);
  chart.x.high = power_of_ten(right, true);
  chart.y.low = power_of_ten(lowest, false);
  chart.y.high = 2 * precision_worst;
  return chart;
}

Chart precision_overview(const Table& rows) {
  Chart chart{.title = "Cost of each method for a required accuracy",
              .subtitle =
                  "wall time over that of the cheapest method; geometric mean over scenes, where all "
                  "are solved to that error",
              .x = {.label = "required error of positions / displacement", .logarithmic = true},
              .y = {.label = "wall time / that of the cheapest method", .logarithmic = true}};
  std::vector<Table> scenes;
  for (const std::string& scene : rows.distinct("scene")) scenes.push_back(rows.where("scene", scene));
  const std::vector<std::string> names = families(rows);
  for (const std::string& family : names)
    chart.series.push_back({.label = family_label(family, members_of(rows, family))});
  double highest = 10;
  for (int half_decade = -18; half_decade <= -2; ++half_decade) {
    const double error = std::pow(10, half_decade / 2.0);
    std::map<std::string, std::vector<double>> ratios;  // by family, of the scenes where it reaches the error
    for (const Table& runs : scenes) {
      const std::vector<Cheapest> all = ranking(runs, error);
      for (const Cheapest& c : all)
        ratios[family_of(c.integrator)].push_back(c.seconds / all.front().seconds);
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (ratios[names[i]].size() < scenes.size()) continue;
      const double ratio = geometric_mean(ratios[names[i]]);
      chart.series[i].points.push_back({error, ratio});
      highest = std::max(highest, ratio);
    }
  }
  chart.x.low = 5e-10;
  chart.x.high = 0.2;
  chart.y.low = 0.9;
  chart.y.high = power_of_ten(highest, true);
  return chart;
}

Drawings draw_precision(const std::vector<NamedTable>& tables) {
  const Table& rows = find_table(tables, "precision");
  const Table& references = find_table(tables, "precision_references");
  Drawings drawings;
  if (rows.size() == 0) return drawings;
  drawings.charts.push_back({"precision", precision_overview(rows)});
  for (const std::string& scene : rows.distinct("scene"))
    for (const Cost cost : {Cost::wall_time, Cost::force_evaluations})
      drawings.charts.push_back({fmt::format("precision_{}_{}", scene, column_of(cost)),
                                 precision_chart(rows, references, scene, cost)});
  for (NamedChart& chart : drawings.charts) add_model_to_subtitle(chart.chart, references.text(0, "model"));
  return drawings;
}

}  // namespace mss::studies::precision

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "experiments/harness/table.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/studies/precision/precision.hpp"

namespace mss::studies::precision {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
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
  double seconds = infinity, q1 = no_value, q3 = no_value;
  double value = no_value;  ///< its step [s] or tolerance
};
Cheapest cheapest(const Table& runs, const std::string& family, double error) {
  Cheapest best{family};
  for (std::size_t r = 0; r < runs.size(); ++r)
    if (family_of(runs.text(r, "integrator")) == family && runs.number(r, "error") <= error &&
        runs.number(r, "seconds") < best.seconds)
      best = {runs.text(r, "integrator"), runs.number(r, "seconds"), runs.number(r, "q1"),
              runs.number(r, "q3"), runs.number(r, "value")};
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

bool is_tie(const Cheapest& first, const Cheapest& next) {
  constexpr double noise = 1.1;
  return next.q1 <= first.q3 || next.seconds <= noise * first.seconds;
}

std::string comparison(const Cheapest& first, const Cheapest& next) {
  return is_tie(first, next)
             ? fmt::format("tie with {}", next.integrator)
             : fmt::format("next: {}, {:.2g} times the cost", next.integrator, next.seconds / first.seconds);
}

bool is_explicit(const std::string& integrator) {
  const IntegratorInfo& info = find_integrator(integrator);
  return !info.implicit && (info.limit || info.stepping == Stepping::adaptive);
}

/// Errors at which methods are compared, half a decade apart.
std::vector<double> compared_errors() {
  std::vector<double> errors;
  for (int half_decade = -18; half_decade <= -2; ++half_decade)
    errors.push_back(std::pow(10, half_decade / 2.0));
  return errors;
}

/// Families that take at most ten times the least time at one of these errors, and those that always fail.
std::vector<std::string> competitive_families(const Table& runs) {
  constexpr double most = 10;
  std::set<std::string> near;
  for (const double error : compared_errors()) {
    const std::vector<Cheapest> all = ranking(runs, error);
    for (const Cheapest& c : all)
      if (c.seconds <= most * all.front().seconds) near.insert(family_of(c.integrator));
  }
  for (const std::string& family : families(runs))
    if (!std::isfinite(cheapest(runs, family, precision_worst).seconds)) near.insert(family);
  std::vector<std::string> ordered = families(runs);
  std::erase_if(ordered, [&](const std::string& family) { return near.count(family) == 0; });
  return ordered;
}

/// The smallest error that the reference of a scene is certain enough to judge; 0 if nothing is known of it.
double judged_from(const Table& references, const std::string& scene) {
  const Table reference = references.where("scene", scene);
  if (reference.size() == 0 || reference.text(0, "status") != "ok") return 0;
  return precision_certainty * reference.number(0, "uncertainty");
}

double power_of_ten(double value, bool up) {
  const double exponent = std::log10(value);
  return std::pow(10, up ? std::ceil(exponent + 1e-9) : std::floor(exponent - 1e-9));
}

/// A line at ten uncertainties of the reference: smaller errors are not significant. Returns its place, or
/// infinity if there is no reference.
double add_uncertainty(Chart& chart, const Table& reference) {
  if (reference.size() == 0 || reference.text(0, "status") != "ok") return infinity;
  const double floor = precision_certainty * reference.number(0, "uncertainty");
  chart.lines.push_back(
      {ReferenceLine::Direction::horizontal, floor, "ten times the uncertainty of the reference"});
  return floor;
}

/// A line for each reason of failure, above all errors, with the markers of the methods that failed.
void add_failures(Chart& chart, const Table& runs, const std::vector<std::string>& drawn) {
  double height = precision_worst;
  for (const std::string& status : runs.distinct("status")) {
    if (status == "ok") continue;
    const Table failed = runs.where("status", status);
    std::vector<ChartSeries> added;
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      ChartSeries series{.style = int(i), .joined = false};
      for (std::size_t r = 0; r < failed.size(); ++r)
        if (family_of(failed.text(r, "integrator")) == drawn[i])
          series.points.push_back({failed.number(r, "seconds"), height});
      if (!series.points.empty()) added.push_back(std::move(series));
    }
    if (added.empty()) continue;
    chart.lines.push_back({ReferenceLine::Direction::horizontal, height, "failed: " + status});
    chart.series.insert(chart.series.end(), added.begin(), added.end());
    height *= 10;
  }
  chart.y.high = height;
}

}  // namespace

Table precision_summary(const Table& rows, const Table& references) {
  Table summary({{"scene"},
                 {"error"},
                 {"integrator"},
                 {"value"},
                 {"seconds", "s"},
                 {"runner_up"},
                 {"cost_ratio"},
                 {"tie"},
                 {"comparison"},
                 {"status"}});
  for (const std::string& scene : rows.distinct("scene"))
    for (const double error : {1e-2, 1e-3, 1e-6}) {
      const bool certain = error >= judged_from(references, scene);
      const std::vector<Cheapest> all =
          certain ? ranking(rows.where("scene", scene), error) : std::vector<Cheapest>();
      if (all.empty()) {
        summary.add({scene, error, std::string("none"), no_value, no_value, std::string(), no_value, 0,
                     std::string(certain ? "no method reached it in the time allowed"
                                         : "the reference is not ten times as certain"),
                     std::string(certain ? "not reached" : "not certain")});
        continue;
      }
      const bool alone = all.size() == 1;
      const double ratio = alone ? no_value : all[1].seconds / all[0].seconds;
      summary.add({scene, error, all[0].integrator, all[0].value, all[0].seconds,
                   alone ? std::string() : all[1].integrator, ratio, !alone && is_tie(all[0], all[1]) ? 1 : 0,
                   alone ? std::string("no other reached it") : comparison(all[0], all[1]),
                   std::string(alone ? "no runner-up" : "ok")});
    }
  return summary;
}

Chart precision_chart(const Table& rows, const Table& references, const std::string& scene) {
  const Table reference = references.where("scene", scene), runs = rows.where("scene", scene);
  Chart chart{.title = "Error against wall time",
              .subtitle = reference.size() > 0 ? reference.text(0, "description") : scene,
              .x = {.label = "wall time of the run", .logarithmic = true, .unit = "s"},
              .y = {.label = "error of positions / displacement", .logarithmic = true}};
  const std::vector<std::string> drawn = competitive_families(runs);
  double left = infinity, right = 0, lowest = 1;
  for (const std::string& family : drawn) {
    const std::vector<std::string> members = members_of(rows, family);
    ChartSeries series{.label = family_label(family, members)};
    for (std::size_t r = 0; r < runs.size(); ++r) {
      if (family_of(runs.text(r, "integrator")) != family) continue;
      const double x = runs.number(r, "seconds"), error = runs.number(r, "error");
      left = std::min(left, x);
      right = std::max(right, x);
      if (runs.text(r, "status") == "ok") series.points.push_back({x, error});
      if (std::isfinite(error)) lowest = std::min(lowest, error);
    }
    if (members.size() > 1) series.points = envelope(std::move(series.points));
    chart.series.push_back(std::move(series));
  }
  lowest = std::min(lowest, add_uncertainty(chart, reference));
  add_failures(chart, runs, drawn);
  chart.x.low = power_of_ten(left, false);
  chart.x.high = power_of_ten(right, true);
  chart.y.low = power_of_ten(lowest, false);
  return chart;
}

Chart precision_overview(const Table& rows, const Table& references) {
  Chart chart{.title = "When is an implicit method worth its cost?",
              .subtitle =
                  "time of the cheapest method without a stability limit over that of the cheapest explicit "
                  "one; below 1 explicit loses",
              .x = {.label = "required error of positions / displacement",
                    .logarithmic = true,
                    .low = 5e-10,
                    .high = 0.2},
              .y = {.label = "time without a stability limit / explicit", .logarithmic = true}};
  double highest = 1;
  for (const std::string& scene : rows.distinct("scene")) {
    const Table runs = rows.where("scene", scene);
    ChartSeries series{.label = scene};
    for (const double error : compared_errors()) {
      if (error < judged_from(references, scene)) continue;
      double of_explicit = infinity, of_others = infinity;
      for (const Cheapest& c : ranking(runs, error)) {
        double& least = is_explicit(c.integrator) ? of_explicit : of_others;
        least = std::min(least, c.seconds);
      }
      if (!std::isfinite(of_explicit) || !std::isfinite(of_others)) continue;
      series.points.push_back({error, of_others / of_explicit});
      highest = std::max(highest, of_others / of_explicit);
    }
    chart.series.push_back(std::move(series));
  }
  chart.y.high = 2 * highest;
  chart.lines.push_back({ReferenceLine::Direction::horizontal, 1, "as cheap"});
  return chart;
}

/// Whether some method has more than one point in the runs of a scene.
bool has_curves(const Table& runs) {
  const std::vector<std::string> all = families(runs);
  return std::any_of(all.begin(), all.end(), [&](const std::string& family) {
    std::size_t points = 0;
    for (std::size_t r = 0; r < runs.size(); ++r)
      if (family_of(runs.text(r, "integrator")) == family && runs.text(r, "status") == "ok") ++points;
    return points > 1;
  });
}

Drawings draw_precision(const std::vector<NamedTable>& tables) {
  const Table& rows = find_table(tables, "precision");
  const Table& references = find_table(tables, "precision_references");
  Drawings drawings;
  if (rows.size() == 0) return drawings;
  drawings.charts.push_back({"precision", precision_overview(rows, references)});
  for (const std::string& scene : rows.distinct("scene"))
    if (has_curves(rows.where("scene", scene)))
      drawings.charts.push_back({"precision_" + scene, precision_chart(rows, references, scene)});
  for (NamedChart& chart : drawings.charts) add_model_to_subtitle(chart.chart, references.text(0, "model"));
  return drawings;
}

}  // namespace mss::studies::precision

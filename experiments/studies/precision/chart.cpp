#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "experiments/studies/precision/precision.hpp"

namespace mss::studies::precision {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// The cheapest run of a method on a scene with at most that error.
struct Cheapest {
  std::string integrator;
  double seconds = infinity;
  double value = none;
};
Cheapest cheapest(const Table& rows, const std::string& scene, const std::string& integrator, double error) {
  Cheapest best{integrator};
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.text(r, "scene") == scene && rows.text(r, "integrator") == integrator &&
        rows.number(r, "error") <= error && rows.number(r, "seconds") < best.seconds)
      best = {integrator, rows.number(r, "seconds"), rows.number(r, "value")};
  return best;
}

/// All methods that reach an error on a scene, cheapest first.
std::vector<Cheapest> ranking(const Table& rows, const std::string& scene, double error) {
  std::vector<Cheapest> all;
  for (const std::string& integrator : rows.distinct("integrator"))
    if (const Cheapest c = cheapest(rows, scene, integrator, error); std::isfinite(c.seconds))
      all.push_back(c);
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

}  // namespace

Table precision_summary(const Table& rows) {
  Table summary({{"scene"},
                 {"error"},
                 {"integrator"},
                 {"value"},
                 {"seconds", "s"},
                 {"runner_up"},
                 {"times_dearer"},
                 {"comparison"},
                 {"status"}});
  for (const std::string& scene : rows.distinct("scene"))
    for (const double error : {1e-2, 1e-3, 1e-6}) {
      const std::vector<Cheapest> all = ranking(rows, scene, error);
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
                         : fmt::format("then {}, {:.2g} times", all[1].integrator, ratio),
                   std::string(alone ? "no runner-up" : "ok")});
    }
  return summary;
}

Chart precision_chart(const Table& rows, const Table& references, const PrecisionScene& scene,
                      const std::string& cost) {
  const bool time = cost == "seconds";
  Chart chart{.title = time ? "Error against wall time" : "Error against force evaluations",
              .subtitle = scene.description,
              .x = {.label = time ? "wall time of the run" : "force evaluations of the run",
                    .logarithmic = true,
                    .unit = time ? "s" : ""},
              .y = {.label = "error of positions / displacement", .logarithmic = true}};
  double left = infinity, right = 0, lowest = 1;
  std::map<std::string, std::vector<double>> failed;
  for (const std::string& integrator : rows.distinct("integrator")) {
    ChartSeries series{.label = integrator};
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (rows.text(r, "scene") != scene.name || rows.text(r, "integrator") != integrator) continue;
      const double x = rows.number(r, cost), error = rows.number(r, "error");
      left = std::min(left, x);
      right = std::max(right, x);
      if (rows.text(r, "status") != "ok")
        failed[rows.text(r, "status")].push_back(x);
      else
        series.points.push_back({x, error});
      if (std::isfinite(error)) lowest = std::min(lowest, error);
    }
    chart.series.push_back(std::move(series));
  }
  for (const auto& [reason, xs] : failed) {
    ChartSeries series{.label = "failed: " + reason, .lines = false};
    for (const double x : xs) series.points.push_back({x, precision_worst});
    chart.series.push_back(std::move(series));
  }
  for (std::size_t r = 0; r < references.size(); ++r)
    if (references.text(r, "scene") == scene.name && references.text(r, "status") == "ok") {
      const double floor = 10 * references.number(r, "uncertainty");
      chart.lines.push_back(
          {ReferenceLine::Direction::horizontal, floor, "ten times the reference's uncertainty"});
      lowest = std::min(lowest, floor);
    }
  chart.x.low = power_of_ten(left, false);
  chart.x.high = power_of_ten(right, true);
  chart.y.low = power_of_ten(lowest, false);
  chart.y.high = 2 * precision_worst;
  return chart;
}

Chart precision_overview(const Table& rows) {
  Chart chart{
      .title = "Which method is cheapest for the accuracy asked",
      .subtitle =
          "wall time over that of the cheapest method; geometric mean over scenes, if all reach the error",
      .x = {.label = "error asked for: of positions / displacement", .logarithmic = true},
      .y = {.label = "times dearer than the cheapest", .logarithmic = true}};
  const std::vector<std::string> scenes = rows.distinct("scene");
  for (const std::string& integrator : rows.distinct("integrator"))
    chart.series.push_back({.label = integrator});
  double dearest = 10;
  for (int half_decade = -18; half_decade <= -2; ++half_decade) {
    const double error = std::pow(10, half_decade / 2.0);
    std::map<std::string, std::vector<double>> ratios;  // by method, of the scenes where it reaches the error
    for (const std::string& scene : scenes) {
      const std::vector<Cheapest> all = ranking(rows, scene, error);
      for (const Cheapest& c : all) ratios[c.integrator].push_back(c.seconds / all.front().seconds);
    }
    for (ChartSeries& series : chart.series) {
      if (ratios[series.label].size() < scenes.size()) continue;
      const double ratio = geometric_mean(ratios[series.label]);
      series.points.push_back({error, ratio});
      dearest = std::max(dearest, ratio);
    }
  }
  chart.x.low = 5e-10;
  chart.x.high = 0.2;
  chart.y.low = 0.9;
  chart.y.high = power_of_ten(dearest, true);
  return chart;
}

}  // namespace mss::studies::precision

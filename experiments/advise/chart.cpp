#include "experiments/advise/chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "experiments/advise/advise.hpp"

namespace mss::advise {

namespace {

/// What a chart tells apart: there are too many methods for a marker each.
std::string family_in_chart(const Table& trials, std::size_t row) {
  if (!has_springs(trials.text(row, "model"))) return "finite elements";
  const IntegratorInfo& method = find_integrator(trials.text(row, "integrator"));
  if (method.stepping == Stepping::adaptive) return "adaptive";
  if (!method.nonlinear_solver.empty()) return "quasi-Newton";
  if (method.implicit) return "implicit";
  return method.limit ? "explicit" : family_of(method.name);
}

/// Whether a row ran to its end, but is no way to compute the scene.
bool is_rejected(const Table& trials, std::size_t row) {
  const std::string& status = trials.text(row, "status");
  return status.starts_with("folds") || status.starts_with("nearly folds") || status.starts_with("a fluke") ||
         status.starts_with("as mss run");
}

bool is_drawn(const Table& trials, std::size_t row) {
  return trials.number(row, "share_run") > 0.999 && trials.number(row, "error") > 0 &&
         trials.number(row, "cost") > 0;
}

/// Those that no other one beats in cost and error, by cost: of thousands of candidates what a chart can
/// show.
std::vector<ChartPoint> best_of(std::vector<ChartPoint> points) {
  std::sort(points.begin(), points.end(), [](const ChartPoint& a, const ChartPoint& b) {
    return std::pair(a.x, a.y) < std::pair(b.x, b.y);
  });
  std::vector<ChartPoint> best;
  for (const ChartPoint& point : points)
    if (best.empty() || point.y < best.back().y) best.push_back(point);
  return best;
}

/// A series per family, of the best of the rows that ran to their end.
std::vector<ChartSeries> series_of(const Table& trials, double least) {
  std::vector<ChartSeries> all;
  for (const char* family : {"explicit", "implicit", "quasi-Newton", "xpbd", "vbd", "adaptive",
                             "finite elements", "folds, gains energy, or by luck"}) {
    ChartSeries series{.label = family, .style = int(all.size())};
    const bool rejected = series.label.starts_with("folds");
    series.lines = !rejected;
    for (std::size_t row = 0; row < trials.size(); ++row)
      if (is_drawn(trials, row) && is_rejected(trials, row) == rejected &&
          (rejected || family_in_chart(trials, row) == family))
        series.points.push_back(
            {trials.number(row, "cost") * to_frame, std::max(trials.number(row, "error"), least)});
    series.points = best_of(std::move(series.points));
    all.push_back(series);
  }
  std::erase_if(all, [](const ChartSeries& series) { return series.points.empty(); });
  return all;
}

/// What is advised, in words.
std::string chosen(const Table& trials, std::size_t row) {
  const double dt = trials.number(row, "dt");
  return fmt::format("{}{}, cells of {:.3g} m", trials.text(row, "integrator"),
                     dt > 0 ? fmt::format(", {:.3g} steps a frame", frame / dt) : std::string(),
                     trials.number(row, "cell_size"));
}

/// Marks it over the others, with its place in the legend and its name above it: beside the point a label
/// would stand among others.
void mark_chosen(const Table& trials, std::size_t row, double least, const std::string& label, Chart& chart) {
  const ChartPoint point{trials.number(row, "cost") * to_frame, std::max(trials.number(row, "error"), least)};
  chart.series.push_back({.label = label, .points = {point}, .lines = false});
  chart.marks.push_back({.point = point, .label = ""});
  chart.legend_title = fmt::format("{}: {}", label, chosen(trials, row));
}

bool any_below(const Table& trials, double least) {
  for (std::size_t row = 0; row < trials.size(); ++row)
    if (trials.number(row, "share_run") > 0.999 && trials.number(row, "error") < least) return true;
  return false;
}

/// Decades that contain all points and the requested error.
void set_ranges(Chart& chart, double requested) {
  double lowest = requested > 0 ? requested : 1, highest = requested > 0 ? requested : 1e-9,
         cheapest = std::numeric_limits<double>::infinity();
  for (const ChartSeries& series : chart.series)
    for (const ChartPoint& point : series.points) {
      lowest = std::min(lowest, point.y);
      highest = std::max(highest, point.y);
      cheapest = std::min(cheapest, point.x);
    }
  const auto decade = [](double value) { return std::pow(10, std::floor(std::log10(value))); };
  chart.y.low = decade(lowest);
  chart.y.high = 10 * decade(highest);
  if (std::isfinite(cheapest)) chart.x.low = decade(cheapest);
}

}  // namespace

Drawings draw(const std::vector<NamedTable>& tables) {
  const Table &trials = find_table(tables, "advise"), &request = find_table(tables, "advise_request");
  if (trials.size() == 0) return {};
  const double error = request.number(0, "error"), budget = request.number(0, "budget");
  const double least = 1e-4 * (error > 0 ? error : 1);  // smaller ones are drawn as that
  Chart chart{.title = "Error against cost: " + request.text(0, "scene"),
              .subtitle = fmt::format(
                  "error of {}; of each family the candidates that no other of it beats in error and cost",
                  request.text(0, "of")),
              .x = {.label = "cost of 1/60 s [ms], this machine", .logarithmic = true},
              .y = {.label = "error", .logarithmic = true},
              .series = series_of(trials, least)};
  if (any_below(trials, least)) chart.y.label = fmt::format("error ({:.2g}: that or less)", least);
  set_ranges(chart, error);
  if (error > 0) chart.lines.push_back({ReferenceLine::Direction::horizontal, error, "requested"});
  if (budget > 0) chart.lines.push_back({ReferenceLine::Direction::vertical, budget * to_frame, "budget"});
  if (const auto best = std::size_t(request.number(0, "best")); best > 0)
    mark_chosen(trials, best - 1, least,
                request.number(0, "within_budget") > 0 ? "advised" : "cheapest that meets it", chart);
  return {.charts = {{"advise", std::move(chart)}}};
}

}  // namespace mss::advise

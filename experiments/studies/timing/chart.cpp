// Evaluation of the rows of the timing experiment: fits, the largest body within a frame, the charts.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>

#include "experiments/harness/statistics.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/studies/timing/timing.hpp"

namespace mss::studies::timing {

namespace {

constexpr int fit_from = 20;  // smaller cubes are mostly surface and overhead
/// The measured curve of one method.
struct Curve {
  std::string method, integrator, precision;
  int threads = 1;
  std::vector<double> cells = {}, seconds = {}, low = {}, high = {};
  double ns_per_spring = no_value;  ///< of the largest body
};

/// Curves in the order their methods first appear; rows that failed or were skipped give no point.
std::vector<Curve> curves(const Table& rows) {
  std::vector<Curve> all;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::string &method = rows.text(r, "method"), &precision = rows.text(r, "precision");
    const int threads = int(rows.number(r, "threads"));
    auto curve = std::find_if(all.begin(), all.end(), [&](const Curve& c) {
      return c.method == method && c.precision == precision && c.threads == threads;
    });
    if (curve == all.end())
      curve = all.insert(all.end(), {.method = method,
                                     .integrator = rows.text(r, "integrator"),
                                     .precision = precision,
                                     .threads = threads});
    if (rows.text(r, "status") != "ok") continue;
    curve->cells.push_back(rows.number(r, "cells"));
    curve->seconds.push_back(rows.number(r, "seconds_per_step"));
    curve->low.push_back(rows.number(r, "q1"));
    curve->high.push_back(rows.number(r, "q3"));
    curve->ns_per_spring = rows.number(r, "ns_per_spring");
  }
  return all;
}

struct Fit {
  PowerLaw law;
  double first, last;
  int points;
};

std::optional<Fit> fit(const Curve& curve) {
  std::vector<double> x, y;
  for (std::size_t i = 0; i < curve.cells.size(); ++i) {
    if (curve.cells[i] < fit_from) continue;
    x.push_back(curve.cells[i]);
    y.push_back(curve.seconds[i]);
  }
  if (x.size() < 2) return std::nullopt;
  return Fit{fit_power_law(x, y), x.front(), x.back(), int(x.size())};
}

struct Largest {
  double cells = no_value;
  std::string how = "unknown";
};

/// The largest n whose update takes at most `budget` seconds: on the straight line (log-log) between the last
/// measured size that does and the next one. If all sizes do, by the fit, up to five times the largest
/// size.
Largest largest_under(const Curve& curve, const std::optional<Fit>& law, double budget) {
  std::size_t above = curve.cells.size();
  while (above > 0 && curve.seconds[above - 1] > budget) --above;
  if (above == 0) return {};
  if (above < curve.cells.size()) {
    const PowerLaw between = fit_power_law({curve.cells[above - 1], curve.cells[above]},
                                           {curve.seconds[above - 1], curve.seconds[above]});
    return {std::floor(between.inverse(budget)), "interpolated"};
  }
  const double n = law ? std::max(curve.cells.back(), std::floor(law->law.inverse(budget))) : no_value;
  return n <= 5 * curve.cells.back() ? Largest{n, "extrapolated"} : Largest{};
}

std::string plural(int threads) { return fmt::format("{} thread{}", threads, threads == 1 ? "" : "s"); }

std::string label(const std::string& method, const std::string& precision, int threads) {
  const std::map<std::string, std::string> names{{"algorithm_1", "Algorithm 1"},
                                                 {"plain_loop", "plain loop"},
                                                 {"structured_sweep", "sweep"},
                                                 {"algorithm_1_debug", "Algorithm 1, debug"},
                                                 {"plain_loop_debug", "plain loop, debug"}};
  const auto name = names.find(method);
  const std::string shown = name == names.end() ? method : name->second;
  const bool says_precision = method == "structured_sweep" || precision == "single";
  return fmt::format("{}{}, {}", shown, says_precision ? " in " + precision : "", plural(threads));
}

/// Of the thesis's two loops the chart shows those that explain its time; the table has all.
bool is_charted(const Curve& c, const std::vector<Curve>& all) {
  if (c.method == "plain_loop") return c.precision == "double" && c.threads == 1;
  if (c.method != "algorithm_1_debug") return true;
  return std::none_of(all.begin(), all.end(), [&](const Curve& other) {
    return other.method == c.method && other.threads > c.threads;
  });
}

/// The shortest time any thread count of a method reached on bodies of n cells per edge; NaN if none was
/// measured.
double best(const Table& rows, const std::string& method, const std::string& precision, int n) {
  double seconds = no_value;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.text(r, "method") == method && rows.text(r, "precision") == precision &&
        rows.number(r, "cells") == n && rows.text(r, "status") == "ok")
      seconds = std::fmin(seconds, rows.number(r, "seconds_per_step"));
  return seconds;
}

std::string comparison(const Table& rows) {
  std::string out;
  for (const int n : {7, 20, 50, 100}) {
    const double dbl = best(rows, "structured_sweep", "double", n),
                 single = best(rows, "structured_sweep", "single", n);
    const double algorithm1 = best(rows, "algorithm_1", "double", n),
                 plain = best(rows, "plain_loop", "double", n);
    if (std::isnan(dbl) || std::isnan(algorithm1)) continue;
    out += fmt::format(
        "n = {}: the structured sweep in double is {:.0f} times as fast as Algorithm 1 and {:.0f} times as "
        "fast as the plain loop; single is {:.2f} times as fast as double\n",
        n, algorithm1 / dbl, plain / dbl, dbl / single);
  }
  return out.empty() ? out : "\nEach with its best number of threads:\n" + out;
}

/// Updates of the thesis's cube in a debug build beside the published time.
std::string debug_text(const Table& rows) {
  std::string out;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::string& method = rows.text(r, "method");
    if (!method.ends_with("_debug") || rows.number(r, "cells") != 7 || rows.text(r, "status") != "ok")
      continue;
    const double seconds = rows.number(r, "seconds_per_step");
    out += fmt::format("n = 7: {}: {:.1f} ms an update, {:.1f} updates in the thesis's 40 ms\n",
                       label(method, rows.text(r, "precision"), int(rows.number(r, "threads"))),
                       1e3 * seconds, thesis_frame_seconds / seconds);
  }
  return out.empty() ? out : "\n" + out;
}

std::string shown(double value, int digits) {
  return std::isnan(value) ? "-" : fmt::format("{:.{}f}", value, digits);
}

}  // namespace

Table timing_summary(const Table& rows) {
  Table summary({{"method"},
                 {"integrator"},
                 {"precision"},
                 {"threads"},
                 {"exponent"},
                 {"fit_from"},
                 {"fit_to"},
                 {"fit_points"},
                 {"largest_cells_40ms"},
                 {"how"},
                 {"ns_per_spring", "ns"},
                 {"status"}});
  for (const Curve& curve : curves(rows)) {
    const std::optional<Fit> law = fit(curve);
    const Largest largest = largest_under(curve, law, thesis_frame_seconds);
    std::string status = "ok";
    if (std::isnan(largest.cells)) status = "no size under 40 ms measured or fitted";
    if (!law) status = fmt::format("no fit: fewer than two sizes of {} or more", fit_from);
    if (curve.cells.empty()) status = "no size measured";
    summary.add({curve.method, curve.integrator, curve.precision, std::int64_t(curve.threads),
                 law ? law->law.exponent : no_value, law ? law->first : no_value, law ? law->last : no_value,
                 std::int64_t(law ? law->points : 0), largest.cells, largest.how, curve.ns_per_spring,
                 status});
  }
  return summary;
}

Chart timing_chart(const Table& rows, const Table& summary) {
  Chart chart{
      .title = "Time of one update of a mass-spring cube",
      .subtitle =
          "full cube of edge 1 m; E = 100 kPa, ν = 0.3 held fixed while n grows; semi-implicit Euler; "
          "medians, bars are quartiles",
      .x = {.label = "cells per edge n", .logarithmic = true},
      .y = {.label = "time per update", .logarithmic = true, .unit = "s"}};
  const std::vector<Curve> all = curves(rows);
  double first = 7, last = 7;  // the thesis's point is always on the chart
  double fastest = 1e-5, slowest = 0.1;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Curve& c = all[i];
    if (!is_charted(c, all)) continue;
    const double exponent = summary.number(i, "exponent"), largest = summary.number(i, "largest_cells_40ms");
    const char* about = summary.text(i, "how") == "extrapolated" ? "≈ " : "";
    ChartSeries series{.label = fmt::format("{}: {}, {}{}", label(c.method, c.precision, c.threads),
                                            shown(exponent, 2), about, shown(largest, 0))};
    for (std::size_t p = 0; p < c.cells.size(); ++p) {
      series.points.push_back({c.cells[p], c.seconds[p], c.low[p], c.high[p]});
      fastest = std::min(fastest, c.low[p]);
      slowest = std::max(slowest, c.high[p]);
      first = std::min(first, c.cells[p]);
      last = std::max(last, c.cells[p]);
    }
    chart.series.push_back(std::move(series));
  }
  chart.legend_title = "method: exponent of time in n, largest n under 40 ms (≈: by the fit)";
  chart.x.low = 0.9 * first;
  chart.x.high = 1.2 * last;
  chart.y.low = std::pow(10, std::floor(std::log10(fastest)));
  chart.y.high = std::pow(10, std::ceil(std::log10(slowest) + 0.1));
  for (const double tick : {1, 2, 3, 4, 5, 7, 10, 15, 20, 30, 50, 100, 200})
    if (tick >= chart.x.low && tick <= chart.x.high) chart.x.ticks.push_back(tick);
  chart.lines = {{ReferenceLine::Direction::horizontal, 1 / frame_rate, "24 frames per second"}};
  chart.marks = {{.point = {7, thesis_frame_seconds}, .label = "thesis: 40 ms", .left = true},
                 {.point = {7, no_value, thesis_frame_seconds / 5, thesis_frame_seconds / 3},
                  .label = "or 3 to 5 steps in 40 ms"}};
  return chart;
}

Drawings draw_timing(const std::vector<NamedTable>& tables) {
  const Table& rows = find_table(tables, "timing");
  const Table& features = find_table(tables, "timing_features");
  Drawings drawings;
  if (rows.size() > 0)
    drawings.charts.push_back({"timing", timing_chart(rows, find_table(tables, "timing_summary"))});
  if (features.size() > 0) drawings.charts.push_back({"timing_features", features_chart(features)});
  for (const auto& [name, table] : tables) {  // results of earlier versions have none of these
    if (table.size() == 0) continue;
    if (name == "timing_shapes") drawings.charts.push_back({name, shapes_chart(table)});
    if (name == "timing_methods") drawings.charts.push_back({name, methods_chart(table)});
  }
  return drawings;
}

std::string timing_text(const Table& rows, const Table& summary) {
  std::string out = fmt::format("{:<36} {:>9} {:>22} {:>15}\n", "method", "exponent", "largest n under 40 ms",
                                "ns per spring");
  for (std::size_t r = 0; r < summary.size(); ++r) {
    const std::string how = summary.text(r, "how") == "extrapolated" ? " (fit)" : "";
    out += fmt::format(
        "{:<36} {:>9} {:>22} {:>15}\n",
        label(summary.text(r, "method"), summary.text(r, "precision"), int(summary.number(r, "threads"))),
        shown(summary.number(r, "exponent"), 2), shown(summary.number(r, "largest_cells_40ms"), 0) + how,
        shown(summary.number(r, "ns_per_spring"), 2));
  }
  return out + comparison(rows) + debug_text(rows);
}

}  // namespace mss::studies::timing

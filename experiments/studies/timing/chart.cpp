// Evaluation of the rows of the timing experiment: fits, the largest body within a frame, the charts.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>

#include "experiments/harness/statistics.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/studies/timing/devices.hpp"
#include "experiments/studies/timing/timing.hpp"
#include "reference/published_rates.hpp"

namespace mss::studies::timing {

namespace {

constexpr int fit_from = 20;  // smaller cubes are mostly surface and overhead
/// The measured curve of one method.
struct Curve {
  std::string method, integrator, precision;
  int threads = 1;
  std::vector<double> cells = {}, springs = {}, seconds = {}, low = {}, high = {};
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
    curve->springs.push_back(rows.number(r, "springs"));
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
  double low, high;  ///< exponents of the flattest and the steepest law through quartiles
  bool is_sound() const { return high - low <= widest_exponent_range; }
};

std::optional<Fit> fit(const Curve& curve) {
  std::vector<double> x, y, q1, q3;
  double middle = 0;  // of log x, sum
  for (std::size_t i = 0; i < curve.cells.size(); ++i) {
    if (curve.cells[i] < fit_from) continue;
    x.push_back(curve.cells[i]);
    y.push_back(curve.seconds[i]);
    q1.push_back(curve.low[i]);
    q3.push_back(curve.high[i]);
    middle += std::log(curve.cells[i]);
  }
  if (x.size() < 2) return std::nullopt;
  middle /= double(x.size());
  std::vector<double> flat, steep;  // a slower small body makes a law flatter, a slower large one steeper
  for (std::size_t i = 0; i < x.size(); ++i) {
    const bool small = std::log(x[i]) < middle;
    flat.push_back(small ? q3[i] : q1[i]);
    steep.push_back(small ? q1[i] : q3[i]);
  }
  return Fit{.law = fit_power_law(x, y),
             .first = x.front(),
             .last = x.back(),
             .points = int(x.size()),
             .low = fit_power_law(x, flat).exponent,
             .high = fit_power_law(x, steep).exponent};
}

constexpr const char* withheld = "withheld";

struct Largest {
  double cells = no_value;
  std::string how = "unknown";
  std::string reason = {};  ///< why it is withheld
};

/// That it is withheld: by the quartiles of the two sizes it lies between.
Largest withheld_between(const Curve& curve, std::size_t above) {
  const auto spread = [&](std::size_t i) { return curve.high[i] / curve.low[i]; };
  const std::size_t worst = spread(above) > spread(above - 1) ? above : above - 1;
  if (spread(worst) <= widest_quartiles) return {};
  return {.how = withheld,
          .reason = fmt::format("{} at n = {}", spread_text(spread(worst)), curve.cells[worst])};
}

/// The largest n whose update takes at most `budget` seconds: on the straight line (log-log) between the last
/// measured size that does and the next one. If all sizes do, by the fit, up to five times the largest
/// size. Withheld where quartiles are too wide to say.
Largest largest_under(const Curve& curve, const std::optional<Fit>& law, double budget) {
  std::size_t above = curve.cells.size();
  while (above > 0 && curve.seconds[above - 1] > budget) --above;
  if (above == 0) return {};
  if (above < curve.cells.size()) {
    if (Largest unknown = withheld_between(curve, above); unknown.how == withheld) return unknown;
    const PowerLaw between = fit_power_law({curve.cells[above - 1], curve.cells[above]},
                                           {curve.seconds[above - 1], curve.seconds[above]});
    return {.cells = std::floor(between.inverse(budget)), .how = "interpolated"};
  }
  if (law && !law->is_sound()) return {.how = withheld, .reason = "it is by the fit"};
  const double n = law ? std::max(curve.cells.back(), std::floor(law->law.inverse(budget))) : no_value;
  return n <= 5 * curve.cells.back() ? Largest{.cells = n, .how = "extrapolated"} : Largest{};
}

std::string plural(int threads) { return fmt::format("{} thread{}", threads, threads == 1 ? "" : "s"); }

std::string label(const std::string& method, const std::string& precision, int threads) {
  const bool is_device = threads == 0;
  const bool says_precision = is_device || method == "structured_sweep" || precision == "single";
  return fmt::format("{}{}{}", method_name(method), says_precision ? " in " + precision : "",
                     is_device ? "" : ", " + plural(threads));
}

/// Of the thesis's two loops the chart shows those that explain its time; the table has all.
bool is_charted(const Curve& c, const std::vector<Curve>& all) {
  if (c.method == "plain_loop") return c.precision == "double" && c.threads == 1;
  if (c.method != "algorithm_1_debug") return true;
  return std::none_of(all.begin(), all.end(), [&](const Curve& other) {
    return other.method == c.method && other.threads > c.threads;
  });
}

/// The shortest time any thread count of a method reached on bodies of n cells per edge, and how far its
/// quartiles are apart; NaN if none was measured.
struct Best {
  double seconds = no_value, spread = no_value;
};
Best best(const Table& rows, const std::string& method, const std::string& precision, int n) {
  Best shortest;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.text(r, "method") == method && rows.text(r, "precision") == precision &&
        rows.number(r, "cells") == n && rows.text(r, "status") == "ok" &&
        !(rows.number(r, "seconds_per_step") >= shortest.seconds))
      shortest = {rows.number(r, "seconds_per_step"), spread_of(rows, r)};
  return shortest;
}

std::string comparison(const Table& rows) {
  std::string out;
  for (const int n : {7, 20, 50, 100}) {
    const Best dbl = best(rows, "structured_sweep", "double", n),
               single = best(rows, "structured_sweep", "single", n);
    const Best algorithm1 = best(rows, "algorithm_1", "double", n),
               plain = best(rows, "plain_loop", "double", n);
    if (std::isnan(dbl.seconds) || std::isnan(algorithm1.seconds)) continue;
    const double spread = std::max({dbl.spread, single.spread, algorithm1.spread, plain.spread});
    if (spread > widest_quartiles) {
      out += fmt::format("n = {}: withheld: {}\n", n, spread_text(spread));
      continue;
    }
    out += fmt::format(
        "n = {}: the structured sweep in double is {:.0f} times as fast as Algorithm 1 and {:.0f} times as "
        "fast as the plain loop; single is {:.2f} times as fast as double\n",
        n, algorithm1.seconds / dbl.seconds, plain.seconds / dbl.seconds, dbl.seconds / single.seconds);
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
    const double seconds = rows.number(r, "seconds_per_step"), spread = spread_of(rows, r);
    if (spread > widest_quartiles) {
      out += fmt::format("n = 7: {}: withheld: {}\n",
                         label(method, rows.text(r, "precision"), int(rows.number(r, "threads"))),
                         spread_text(spread));
      continue;
    }
    out += fmt::format("n = 7: {}: {:.1f} ms an update, {:.1f} updates in the thesis's 40 ms\n",
                       label(method, rows.text(r, "precision"), int(rows.number(r, "threads"))),
                       1e3 * seconds, thesis_frame_seconds / seconds);
  }
  return out.empty() ? out : "\n" + out;
}

std::string shown(double value, int digits) {
  return std::isnan(value) ? "-" : fmt::format("{:.{}f}", value, digits);
}

/// Whether a row of the summary has a fit whose exponent is withheld, and whether its largest n is.
bool withholds_exponent(const Table& summary, std::size_t r) {
  return std::isnan(summary.number(r, "exponent")) && summary.number(r, "fit_points") > 0;
}
bool withholds_largest(const Table& summary, std::size_t r) { return summary.text(r, "how") == withheld; }

std::string exponent_text(const Table& summary, std::size_t r) {
  return withholds_exponent(summary, r) ? withheld : shown(summary.number(r, "exponent"), 2);
}
std::string largest_text(const Table& summary, std::size_t r) {
  return withholds_largest(summary, r) ? withheld : shown(summary.number(r, "largest_cells_40ms"), 0);
}

/// As "2.99, ≈ 43": exponent and largest n of a row.
std::string legend_text(const Table& summary, std::size_t r) {
  if (withholds_exponent(summary, r) && withholds_largest(summary, r)) return withheld;
  const char* about = summary.text(r, "how") == "extrapolated" ? "≈ " : "";
  return fmt::format("{}, {}{}", exponent_text(summary, r), about, largest_text(summary, r));
}

/// Why a row of the summary lacks something.
std::string summary_status(const Curve& curve, const std::optional<Fit>& law, const Largest& largest,
                           double other_work) {
  if (curve.cells.empty()) return "no size measured";
  std::vector<std::string> reasons;
  if (!law) reasons.push_back(fmt::format("no fit: fewer than two sizes of {} or more", fit_from));
  if (law && other_work >= spoiling_share)
    reasons.push_back("fit withheld: " + beside_text(other_work));
  else if (law && !law->is_sound())
    reasons.push_back(
        fmt::format("fit withheld: by the quartiles the exponent is {:.2f} to {:.2f}", law->low, law->high));
  if (largest.how == withheld)
    reasons.push_back("largest size withheld: " + largest.reason);
  else if (law && std::isnan(largest.cells))
    reasons.emplace_back("no size under 40 ms measured or fitted");
  return reasons.empty() ? "ok" : fmt::format("{}", fmt::join(reasons, "; "));
}

/// How many charted methods something is withheld of.
std::string withheld_notice(int methods, int of, double spread) {
  if (methods == 0) return {};
  return fmt::format("Fits withheld for {} of {} methods{}", methods, of,
                     spread > widest_quartiles ? ": " + spread_text(spread) : "");
}

/// A rate that others published, as a line across the chart that only the legend names: its name on the line
/// would stand in the way of curves.
ChartSeries published_line(const reference::PublishedRate& published, const ChartAxis& x, int style) {
  return {.label = fmt::format("{}, {}: published, on a GPU", published.program, published.year),
          .points = {{x.low, published.rate}, {x.high, published.rate}},
          .style = style,
          .marked = false};
}

}  // namespace

std::string method_name(const std::string& method) {
  static const std::map<std::string, std::string> names{{"algorithm_1", "Algorithm 1"},
                                                        {"plain_loop", "plain loop"},
                                                        {"structured_sweep", "sweep"},
                                                        {"algorithm_1_debug", "Algorithm 1, debug"},
                                                        {"plain_loop_debug", "plain loop, debug"},
                                                        {"xpbd", "XPBD"},
                                                        {"vbd", "VBD"},
                                                        {"backward_euler/lbfgs", "L-BFGS"},
                                                        {"shape_matching", "shape matching"},
                                                        {"Bullet", "Bullet's links"}};
  const auto name = names.find(method);
  return name == names.end() ? method : name->second;
}

ChartAxis cells_axis(double first, double last) {
  ChartAxis axis{.label = "cells per edge n", .logarithmic = true, .low = 0.9 * first, .high = 1.2 * last};
  for (const double tick : {1, 2, 3, 4, 5, 7, 10, 15, 20, 30, 50, 100, 200, 400, 800})
    if (tick >= axis.low && tick <= axis.high) axis.ticks.push_back(tick);
  return axis;
}

double spread_of(const Table& rows, std::size_t row, const char* q1, const char* q3) {
  return rows.number(row, q3) / rows.number(row, q1);
}

std::string beside_text(double other_work) {
  return fmt::format("other work took {:.0f} % of the cores", 100 * other_work);
}

std::string spread_text(double spread) {
  constexpr double large = 10;
  return fmt::format("quartiles a factor of {:.{}f} apart", spread, spread < large ? 1 : 0);
}

std::string spread_notice(const Table& rows, const char* q1, const char* q3) {
  int wide = 0;
  double widest = widest_quartiles;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const double spread = spread_of(rows, r, q1, q3);
    if (spread > widest_quartiles) ++wide;
    widest = std::fmax(widest, spread);
  }
  if (wide == 0) return {};
  return fmt::format("Too disturbed to compare: {} of {} points; one has {}", wide, rows.size(),
                     spread_text(widest));
}

Table timing_summary(const Table& rows, double other_work) {
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
                 {"status"},
                 {"exponent_low"},
                 {"exponent_high"}});
  for (const Curve& curve : curves(rows)) {
    const std::optional<Fit> law = fit(curve);
    const bool spoiled = other_work >= spoiling_share;
    const Largest largest = spoiled && !curve.cells.empty()
                                ? Largest{.how = withheld, .reason = beside_text(other_work)}
                                : largest_under(curve, law, thesis_frame_seconds);
    summary.add({curve.method, curve.integrator, curve.precision, std::int64_t(curve.threads),
                 law && law->is_sound() && !spoiled ? law->law.exponent : no_value,
                 law ? law->first : no_value, law ? law->last : no_value, std::int64_t(law ? law->points : 0),
                 largest.cells, largest.how, curve.ns_per_spring,
                 summary_status(curve, law, largest, other_work), law ? law->low : no_value,
                 law ? law->high : no_value});
  }
  return summary;
}

Chart timing_chart(const Table& rows, const Table& summary) {
  Chart chart{
      .title = "Time of one update of a mass-spring cube",
      .subtitle =
          "full cube of edge 1 m; E = 100 kPa, ν = 0.3 held fixed while n grows; semi-implicit Euler; "
          "medians, bars are quartiles",
      .x = {},
      .y = {.label = "time per update", .logarithmic = true, .unit = "s"}};
  const std::vector<Curve> all = curves(rows);
  double first = 7, last = 7;  // the thesis's point is always on the chart
  double fastest = 1e-5, slowest = 0.1, widest = 1;
  int methods = 0, methods_withheld = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Curve& c = all[i];
    if (!is_charted(c, all)) continue;
    ++methods;
    if (withholds_exponent(summary, i) || withholds_largest(summary, i)) ++methods_withheld;
    ChartSeries series{
        .label = fmt::format("{}: {}", label(c.method, c.precision, c.threads), legend_text(summary, i))};
    for (std::size_t p = 0; p < c.cells.size(); ++p) {
      series.points.push_back({c.cells[p], c.seconds[p], c.low[p], c.high[p]});
      widest = std::max(widest, c.high[p] / c.low[p]);
      fastest = std::min(fastest, c.low[p]);
      slowest = std::max(slowest, c.high[p]);
      first = std::min(first, c.cells[p]);
      last = std::max(last, c.cells[p]);
    }
    chart.series.push_back(std::move(series));
  }
  chart.legend_title = "method: exponent of time in n, largest n under 40 ms (≈: by the fit)";
  chart.times = true;
  chart.notice = withheld_notice(methods_withheld, methods, widest);
  chart.x = cells_axis(first, last);
  chart.y.low = std::pow(10, std::floor(std::log10(fastest)));
  chart.y.high = std::pow(10, std::ceil(std::log10(slowest) + 0.1));
  chart.lines = {{ReferenceLine::Direction::horizontal, 1 / frame_rate, "24 frames per second"}};
  chart.marks = {{.point = {7, thesis_frame_seconds}, .label = "thesis: 40 ms", .left = true},
                 {.point = {7, no_value, thesis_frame_seconds / 5, thesis_frame_seconds / 3},
                  .label = "or 3 to 5 steps in 40 ms"}};
  return chart;
}

Chart rates_chart(const Table& rows) {
  Chart chart{
      .title = "Springs updated in a second",
      .subtitle =
          "full cube of edge 1 m, with volume forces; semi-implicit Euler; medians, bars are quartiles",
      .x = {},
      .y = {.label = "springs a second", .logarithmic = true}};
  const std::vector<Curve> all = curves(rows);
  double first = no_value, last = no_value;
  for (const Curve& c : all) {
    if (c.method.ends_with("_debug") || !is_charted(c, all)) continue;
    ChartSeries series{.label = label(c.method, c.precision, c.threads)};
    for (std::size_t p = 0; p < c.cells.size(); ++p) {
      series.points.push_back(
          {c.cells[p], c.springs[p] / c.seconds[p], c.springs[p] / c.high[p], c.springs[p] / c.low[p]});
      first = std::fmin(first, c.cells[p]);
      last = std::fmax(last, c.cells[p]);
    }
    chart.series.push_back(std::move(series));
  }
  if (std::isnan(first)) return chart;
  chart.x = cells_axis(first, last);
  chart.times = true;
  chart.legend_title = "lines without marks: as their authors published them, for GPUs; not measured here";
  int style = 24;  // dark, dashed, then solid: unlike the lines of methods
  for (const reference::PublishedRate& published : reference::published_rates())
    chart.series.push_back(published_line(published, chart.x, style--));
  return chart;
}

Drawings draw_timing(const std::vector<NamedTable>& tables) {
  if (!tables.empty() && tables.front().name == "devices")
    return draw_devices(tables.front().table, find_table(tables, "devices_time"));
  const Table& rows = find_table(tables, "timing");
  const Table& features = find_table(tables, "timing_features");
  Drawings drawings;
  if (rows.size() > 0) {
    drawings.charts.push_back({"timing", timing_chart(rows, find_table(tables, "timing_summary"))});
    const auto stored = std::find_if(tables.begin(), tables.end(),
                                     [](const NamedTable& t) { return t.name == "timing_seconds"; });
    // results of earlier versions lack it, but not what it is computed from
    const Table seconds = stored == tables.end() ? timing_seconds(tables) : stored->table;
    drawings.charts.push_back({"timing_seconds", seconds_chart(seconds)});
    drawings.charts.push_back({"timing_rates", rates_chart(rows)});
  }
  if (features.size() > 0) drawings.charts.push_back({"timing_features", features_chart(features)});
  for (const auto& [name, table] : tables) {  // results of earlier versions have none of these
    if (table.size() == 0) continue;
    if (name == "timing_shapes") drawings.charts.push_back({name, shapes_chart(table)});
    if (name == "timing_methods") drawings.charts.push_back({name, methods_chart(table)});
  }
  return drawings;
}

namespace {

/// Of the thesis's figure, if it was measured; else the largest.
double size_in_text(const std::vector<Curve>& all) {
  constexpr double of_thesis = 7;
  double largest = 0;
  for (const Curve& curve : all)
    for (const double n : curve.cells) {
      if (n == of_thesis) return n;
      largest = std::fmax(largest, n);
    }
  return largest;
}

/// The median time of an update with so many cells an edge, by the method of a row of the summary.
std::string milliseconds_at(const std::vector<Curve>& all, double cells, const Table& summary,
                            std::size_t row) {
  for (const Curve& curve : all) {
    if (curve.method != summary.text(row, "method") || curve.precision != summary.text(row, "precision") ||
        curve.threads != int(summary.number(row, "threads")))
      continue;
    const auto at = std::find(curve.cells.begin(), curve.cells.end(), cells);
    if (at != curve.cells.end())
      return fmt::format("{:.3g}", 1e3 * curve.seconds[std::size_t(at - curve.cells.begin())]);
  }
  return "-";
}

}  // namespace

std::string timing_text(const Table& rows, const Table& summary, double other_work) {
  const std::vector<Curve> all = curves(rows);
  const double cells = size_in_text(all);
  std::string out = fmt::format("{:<36} {:>9} {:>22} {:>15} {:>15}\n", "method", "exponent",
                                "largest n under 40 ms", "ns per spring", fmt::format("ms at n = {}", cells));
  bool any_withheld = false;
  for (std::size_t r = 0; r < summary.size(); ++r) {
    const std::string how = summary.text(r, "how") == "extrapolated" ? " (fit)" : "";
    out += fmt::format(
        "{:<36} {:>9} {:>22} {:>15} {:>15}\n",
        label(summary.text(r, "method"), summary.text(r, "precision"), int(summary.number(r, "threads"))),
        exponent_text(summary, r), largest_text(summary, r) + how,
        shown(summary.number(r, "ns_per_spring"), 2), milliseconds_at(all, cells, summary, r));
    any_withheld = any_withheld || withholds_exponent(summary, r) || withholds_largest(summary, r);
  }
  if (other_work >= spoiling_share)
    return out +
           fmt::format(
               "withheld, and ratios of times too: {}; times are as measured, so too long; measure again "
               "on a quiet machine\n",
               beside_text(other_work));
  if (any_withheld)
    out += fmt::format(
        "withheld: quartiles are more than a factor of {} apart, or leave the exponent a range wider than "
        "{}; "
        "measure again on a quiet machine\n",
        widest_quartiles, widest_exponent_range);
  return out + comparison(rows) + debug_text(rows);
}

}  // namespace mss::studies::timing

// What a simulated second costs on one thread: the time of a step over the step that the method takes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/body/spectral_bound.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/studies/timing/timing.hpp"
#include "integrators/analysis/stable_step.hpp"

namespace mss::studies::timing {

namespace {

constexpr const char* explicit_method = "semi_implicit_euler";
constexpr const char* safe = "safe";

/// The step that a method takes.
struct StepTaken {
  std::string size;  ///< in words
  double dt;         ///< [s]
  double iterations;
};

StepTaken timed_step(double dt, double iterations) {
  return {std::isnan(dt) ? "unknown" : fmt::format("1/{:.0f} s", 1 / dt), dt, iterations};
}

/// Adds a method of `from`, whose row has its time for one iteration, or for a step where that is one.
void add_row(const std::string& method, const StepTaken& step, const Table& from, std::size_t r,
             const char* time, Table& table) {
  const double per_second = 1 / step.dt, scale = step.iterations * per_second;
  const bool unknown = std::isnan(step.dt) && from.text(r, "status") == "ok";
  table.add({method, from.text(r, "precision"), 1, std::int64_t(from.number(r, "cells")), step.size, step.dt,
             std::int64_t(step.iterations), per_second, step.iterations * from.number(r, time),
             scale * from.number(r, time), scale * from.number(r, "q1"), scale * from.number(r, "q3"),
             unknown ? "step not known" : from.text(r, "status")});
}

const Table* table_of_name(const std::vector<NamedTable>& tables, std::string_view name) {
  const auto found =
      std::find_if(tables.begin(), tables.end(), [&](const NamedTable& t) { return t.name == name; });
  return found == tables.end() || found->table.size() == 0 ? nullptr : &found->table;
}

/// As in "sweep in double: safe step" or "VBD in single: 1/60 s, 10 it.".
std::string label_at_step(const Table& seconds, std::size_t r) {
  const std::string& step = seconds.text(r, "step");
  const double iterations = seconds.number(r, "iterations");
  return fmt::format("{} in {}: {}", method_name(seconds.text(r, "method")), seconds.text(r, "precision"),
                     step == safe ? "safe step" : fmt::format("{}, {} it.", step, iterations));
}

/// Of the thesis's two loops those in double precision, optimised; of the sweep both precisions; of what
/// games use single where it has it.
bool is_shown(const Table& seconds, std::size_t r) {
  const std::string& method = seconds.text(r, "method");
  if (seconds.text(r, "status") != "ok" || method.ends_with("_debug")) return false;
  if (method == "structured_sweep" || seconds.text(r, "precision") == "single") return method != "plain_loop";
  return seconds.text(r, "step") == safe ||
         seconds.where("method", method).where("precision", "single").size() == 0;
}

}  // namespace

double safe_step(int n) {
  BodyConfig config = timing_cube(n);
  const int enough =
      std::min(n, 4);  // the bound is of a particle's neighbourhoods, and these have all of them
  config.voxels = VoxelGrid::box(enough, enough, enough);
  return safe_share * stable_step(find_integrator(explicit_method), spectral_bound(Body(config)));
}

Table timing_seconds(const std::vector<NamedTable>& tables) {
  Table seconds({{"method"},
                 {"precision"},
                 {"threads"},
                 {"cells"},
                 {"step"},
                 {"dt", "s"},
                 {"iterations"},
                 {"steps_per_second", "1/s"},
                 {"seconds_per_step", "s"},
                 {"seconds_per_second"},
                 {"q1"},
                 {"q3"},
                 {"status"}});
  const Table loops = find_table(tables, "timing").where("threads", 1);
  for (std::size_t r = 0; r < loops.size(); ++r)
    add_row(loops.text(r, "method"), {safe, safe_step(int(loops.number(r, "cells"))), 1}, loops, r,
            "seconds_per_step", seconds);
  if (const Table* all = table_of_name(tables, "timing_methods")) {
    const Table methods = all->where("threads", 1);
    for (std::size_t r = 0; r < methods.size(); ++r) {
      const std::string& method = methods.text(r, "method");
      if (method == explicit_method) continue;  // the sweep's
      add_row(method, timed_step(step_of_method(method), methods.number(r, "iterations")), methods, r,
              "seconds_per_iteration", seconds);
    }
  }
  if (const Table* all = table_of_name(tables, "timing_peers")) {
    const Table peers = all->where("our_precision", "single");  // a row for each of ours, the peer's the same
    for (std::size_t r = 0; r < peers.size(); ++r)
      add_row(peers.text(r, "program"), timed_step(peer_step, 1), peers, r, "seconds_per_step", seconds);
  }
  return seconds;
}

Chart seconds_chart(const Table& seconds) {
  Chart chart{.title = "Computing time of a simulated second, on one thread",
              .subtitle =
                  "full cube of edge 1 m; E = 100 kPa, ν = 0.3; each method at its own step, not equally "
                  "accurate; bars: quartiles",
              .x = {},
              .y = {.label = "computing time / simulated time", .logarithmic = true}};
  double first = no_value, last = no_value;
  for (std::size_t r = 0; r < seconds.size(); ++r) {
    if (!is_shown(seconds, r)) continue;
    const std::string label = label_at_step(seconds, r);
    auto series = std::find_if(chart.series.begin(), chart.series.end(),
                               [&](const ChartSeries& s) { return s.label == label; });
    if (series == chart.series.end()) series = chart.series.insert(series, ChartSeries{.label = label});
    const double n = seconds.number(r, "cells");
    series->points.push_back(
        {n, seconds.number(r, "seconds_per_second"), seconds.number(r, "q1"), seconds.number(r, "q3")});
    first = std::fmin(first, n);
    last = std::fmax(last, n);
  }
  if (std::isnan(first)) return chart;
  chart.x = cells_axis(first, last);
  chart.times = true;
  chart.legend_title = "method: its step, and its iterations (it.) in one";
  chart.lines = {{ReferenceLine::Direction::horizontal, 1, "real time"}};
  return chart;
}

std::string seconds_text(const Table& seconds) {
  std::string text;
  for (const double n : {7.0, 20.0, 50.0, 100.0}) {
    const Table rows = seconds.where("cells", n);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (!is_shown(rows, r)) continue;
      const double spread = spread_of(rows, r);
      text += fmt::format(
          "n = {}, {}: {:.4g} steps, {}\n", n, label_at_step(rows, r), rows.number(r, "steps_per_second"),
          spread > widest_quartiles ? "time withheld: " + spread_text(spread)
                                    : fmt::format("{:.3g} s", rows.number(r, "seconds_per_second")));
    }
  }
  return text.empty() ? text : "\nA simulated second on one thread, each method at its step:\n" + text;
}

}  // namespace mss::studies::timing

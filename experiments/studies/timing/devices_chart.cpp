// What rows of `mss timing --devices` show: highest rates, the size from which a device is faster, charts.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "experiments/harness/statistics.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/studies/timing/devices.hpp"
#include "experiments/studies/timing/timing.hpp"

namespace mss::studies::timing {

namespace {

constexpr const char* compared_method = "semi_implicit_euler";
constexpr int compared_threads = 2;

/// The cells per edge and times of one device or number of threads in one precision, ascending.
struct DeviceCurve {
  std::string choice, name, precision;
  int threads;  ///< 0: of a device
  std::vector<double> cells{}, springs{}, seconds{}, low{}, high{};

  std::string label() const {
    if (threads == 0) return fmt::format("{}, {}", name, precision);
    return fmt::format("{}, {} thread{}, {}", name, threads, threads == 1 ? "" : "s", precision);
  }
  /// At a measured size; NaN at others.
  double seconds_at(double n) const {
    const auto found = std::find(cells.begin(), cells.end(), n);
    return found == cells.end() ? no_value : seconds[std::size_t(found - cells.begin())];
  }
};

/// Of semi-implicit Euler; rows without a time give no point.
std::vector<DeviceCurve> device_curves(const Table& all) {
  const Table rows = all.where("method", compared_method);
  std::vector<DeviceCurve> curves;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const std::string &choice = rows.text(r, "solve_device"), &precision = rows.text(r, "precision");
    const int threads = int(rows.number(r, "threads"));
    auto curve = std::find_if(curves.begin(), curves.end(), [&](const DeviceCurve& c) {
      return c.choice == choice && c.precision == precision && c.threads == threads;
    });
    if (curve == curves.end())
      curve = curves.insert(curves.end(), {choice, rows.text(r, "device"), precision, threads});
    if (rows.text(r, "status") != "ok") continue;
    curve->cells.push_back(rows.number(r, "cells"));
    curve->springs.push_back(rows.number(r, "springs"));
    curve->seconds.push_back(rows.number(r, "seconds_per_step"));
    curve->low.push_back(rows.number(r, "q1"));
    curve->high.push_back(rows.number(r, "q3"));
  }
  return curves;
}

struct FasterFrom {
  double cells;
  std::string how;
};

/// From which size on `device` takes less time than `processor`, of the sizes that both were timed at.
FasterFrom faster_from(const DeviceCurve& device, const DeviceCurve* processor) {
  if (!processor) return {no_value, "two threads were not timed"};
  std::vector<double> cells, ratio;  // of times: above 1 the device is slower
  for (std::size_t i = 0; i < device.cells.size(); ++i) {
    const double other = processor->seconds_at(device.cells[i]);
    if (std::isnan(other)) continue;
    cells.push_back(device.cells[i]);
    ratio.push_back(device.seconds[i] / other);
  }
  if (cells.empty()) return {no_value, "no size was timed on both"};
  if (ratio.back() >= 1) return {no_value, "not at the largest size timed on both"};
  std::size_t first = ratio.size() - 1;
  while (first > 0 && ratio[first - 1] < 1) --first;
  if (first == 0) return {cells.front(), "every size"};
  const PowerLaw between = fit_power_law({cells[first - 1], cells[first]}, {ratio[first - 1], ratio[first]});
  return {between.inverse(1), "interpolated"};
}

/// As `timing` has them: a device is a method without threads.
Table rows_of_updates(const std::vector<DeviceCurve>& curves) {
  Table rows({{"method"},
              {"integrator"},
              {"precision"},
              {"threads"},
              {"cells"},
              {"springs"},
              {"seconds_per_step", "s"},
              {"q1", "s"},
              {"q3", "s"},
              {"status"},
              {"ns_per_spring", "ns"}});
  for (const DeviceCurve& c : curves)
    for (std::size_t i = 0; i < c.cells.size(); ++i)
      rows.add({c.threads == 0 ? c.name : "structured_sweep", compared_method, c.precision, c.threads,
                std::int64_t(c.cells[i]), std::int64_t(c.springs[i]), c.seconds[i], c.low[i], c.high[i], "ok",
                1e9 * c.seconds[i] / c.springs[i]});
  return rows;
}

double largest_cells(const std::vector<DeviceCurve>& curves) {
  double largest = 7;  // the thesis's
  for (const DeviceCurve& c : curves)
    if (!c.cells.empty()) largest = std::max(largest, c.cells.back());
  return largest;
}

std::string names_of_devices(const std::vector<DeviceCurve>& curves) {
  std::vector<std::string> names;
  for (const DeviceCurve& c : curves)
    if (c.threads == 0 && std::find(names.begin(), names.end(), c.name) == names.end())
      names.push_back(c.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

Chart devices_chart(const std::vector<DeviceCurve>& curves) {
  Chart chart{
      .title = "Springs a second on " + names_of_devices(curves),
      .subtitle =
          "full cube of edge 1 m, with volume forces; semi-implicit Euler; medians, bars are quartiles",
      .times = true,
      .x = {},
      .y = {.label = "springs a second", .logarithmic = true}};
  double first = no_value, last = no_value;
  for (const DeviceCurve& c : curves) {
    ChartSeries series{.label = c.label()};
    for (std::size_t i = 0; i < c.cells.size(); ++i) {
      series.points.push_back(
          {c.cells[i], c.springs[i] / c.seconds[i], c.springs[i] / c.high[i], c.springs[i] / c.low[i]});
      first = std::fmin(first, c.cells[i]);
      last = std::fmax(last, c.cells[i]);
    }
    chart.series.push_back(std::move(series));
  }
  if (!std::isnan(first)) chart.x = cells_axis(first, last);
  return chart;
}

}  // namespace

Table devices_summary(const Table& rows, double other_work) {
  Table summary({{"device"},
                 {"solve_device"},
                 {"precision"},
                 {"springs_per_second", "1/s"},
                 {"at_cells"},
                 {"faster_from_cells"},
                 {"how"},
                 {"status"}});
  const std::vector<DeviceCurve> curves = device_curves(rows);
  for (const DeviceCurve& device : curves) {
    if (device.threads != 0) continue;
    const auto processor = std::find_if(curves.begin(), curves.end(), [&](const DeviceCurve& c) {
      return c.threads == compared_threads && c.precision == device.precision;
    });
    const FasterFrom from = other_work >= spoiling_share
                                ? FasterFrom{no_value, "withheld: " + beside_text(other_work)}
                                : faster_from(device, processor == curves.end() ? nullptr : &*processor);
    double best = no_value, at = no_value;
    for (std::size_t i = 0; i < device.cells.size(); ++i) {
      const double rate = device.springs[i] / device.seconds[i];
      if (!(rate <= best)) best = rate, at = device.cells[i];
    }
    summary.add({device.name, device.choice, device.precision, best, at, from.cells, from.how,
                 std::isnan(from.cells) ? from.how : "ok"});
  }
  return summary;
}

std::string devices_text(const Table& rows, const Table& summary) {
  std::string text;
  for (std::size_t r = 0; r < summary.size(); ++r) {
    const double best = summary.number(r, "springs_per_second"),
                 from = summary.number(r, "faster_from_cells");
    text += fmt::format("{} ({}), {}: ", summary.text(r, "device"), summary.text(r, "solve_device"),
                        summary.text(r, "precision"));
    text += std::isnan(best)
                ? "no time"
                : fmt::format("{:.3g} springs a second at n = {}", best, summary.number(r, "at_cells"));
    const std::string& how = summary.text(r, "how");
    text += std::isnan(from) ? fmt::format("; faster than two threads: {}\n", how)
            : how == "every size"
                ? fmt::format("; faster than two threads at every size, from n = {}\n", from)
                : fmt::format("; faster than two threads from n = {:.0f}\n", std::ceil(from));
  }
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.text(r, "status") != "ok")
      text += fmt::format("{}, {}, {}, n = {}: {}, so it has no time\n", rows.text(r, "device"),
                          rows.text(r, "precision"), rows.text(r, "method"), rows.number(r, "cells"),
                          rows.text(r, "status"));
  return text;
}

Table devices_time(const Table& rows, double other_work) {
  return timing_summary(rows_of_updates(device_curves(rows)), other_work);
}

Drawings draw_devices(const Table& rows, const Table& time) {
  const std::vector<DeviceCurve> curves = device_curves(rows);
  Drawings drawings;
  if (time.size() == 0) return drawings;
  drawings.charts.push_back({"devices", devices_chart(curves)});
  Chart updates = timing_chart(rows_of_updates(curves), time);
  updates.x = cells_axis(4, largest_cells(curves));  // room left of the thesis's point for its name
  drawings.charts.push_back({"devices_time", std::move(updates)});
  return drawings;
}

}  // namespace mss::studies::timing

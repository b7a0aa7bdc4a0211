// Bodies that hit each other: what a reader sees.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/studies/contact/collision.hpp"

namespace mss::studies::contact {

Chart bars_chart(const Table& rows) {
  Chart chart{.title = "Two equal bars collide: how long they touch",
              .subtitle = "lateral motion held, one cell across; exact: 2 L / c",
              .x = {.label = "speed / c",
                    .logarithmic = true,
                    .low = 8e-4,
                    .high = 0.025,
                    .ticks = {0.001, 0.002, 0.005, 0.01, 0.02},
                    .names = {"0.001", "0.002", "0.005", "0.01", "0.02"}},
              .y = {.label = "duration / exact - 1 [%]"},
              .lines = {{ReferenceLine::Direction::horizontal, 0, "exact", true}}};
  const Table shown = rows.where("across", 1.0);
  for (const double cells : shown.distinct_numbers("cells"))
    for (const double stiffness : shown.distinct_numbers("stiffness")) {
      const Table runs = shown.where("cells", cells).where("stiffness", stiffness);
      ChartSeries series{.label = fmt::format("{:g} cells, stiffness {:g}", cells, stiffness)};
      for (std::size_t r = 0; r < runs.size(); ++r)
        series.points.push_back(
            {runs.number(r, "speed_over_c"), 100 * (runs.number(r, "duration_over_exact") - 1)});
      chart.series.push_back(std::move(series));
    }
  return chart;
}

std::string collision_summary(const Table& bars, const Table& balance) {
  std::string lines;
  const auto count = [&](const char* what, const Table& rows) {
    if (rows.size() == 0) return;
    lines += fmt::format("{:<15} {:3} runs", what, rows.size());
    for (const std::string& status : rows.distinct("status"))
      lines += fmt::format(", {} {}", rows.where("status", status).size(), status);
    lines += "\n";
  };
  count("colliding bars", bars);
  count("blocks that hit", balance);
  return lines;
}

}  // namespace mss::studies::contact

#include "experiments/plot/chart.hpp"

#include <algorithm>
#include <cmath>

namespace mss {

ChartAxis named_rows(const std::vector<std::string>& names) {
  ChartAxis axis{.label = "", .low = 0.4, .high = double(names.size()) + 0.6, .names = names};
  for (std::size_t i = 0; i < names.size(); ++i) axis.ticks.push_back(double(names.size() - i));
  return axis;
}

bool has_points(const Chart& chart) {
  return std::any_of(chart.series.begin(), chart.series.end(), [&](const ChartSeries& series) {
    return std::any_of(series.points.begin(), series.points.end(), [&](const ChartPoint& p) {
      return std::isfinite(p.x) && std::isfinite(p.y) && (!chart.x.logarithmic || p.x > 0) &&
             (!chart.y.logarithmic || p.y > 0);
    });
  });
}

}  // namespace mss

#include "experiments/fit/ring_down.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace mss::fit {

namespace {

/// Slope of a straight line through y[0], y[1], ... by least squares.
double slope_of(const std::vector<double>& y) {
  const double middle = double(y.size() - 1) / 2;
  double product = 0, square = 0;
  for (std::size_t k = 0; k < y.size(); ++k) {
    product += (double(k) - middle) * y[k];
    square += (double(k) - middle) * (double(k) - middle);
  }
  return product / square;
}

/// Vertex of the parabola through a sample and its neighbours.
Extremum vertex_at(const std::vector<double>& t, const std::vector<double>& value, std::size_t i) {
  const double before = (value[i] - value[i - 1]) / (t[i] - t[i - 1]),
               after = (value[i + 1] - value[i]) / (t[i + 1] - t[i]),
               bend = (after - before) / (t[i + 1] - t[i - 1]);
  if (bend == 0) return {t[i], value[i]};
  const double slope = before + bend * (t[i] - t[i - 1]), by = -slope / (2 * bend);
  return {t[i] + by, value[i] + slope * by + bend * by * by};
}

}  // namespace

std::vector<Extremum> extrema_of(const std::vector<double>& t, const std::vector<double>& value) {
  constexpr double share = 0.05;
  std::vector<Extremum> extrema;
  if (t.size() < 3) return extrema;
  const auto [least, most] = std::minmax_element(value.begin(), value.end());
  const double swing = share * (*most - *least);
  if (!(swing > 0)) return extrema;
  std::size_t lowest = 0, highest = 0;  // since the last extremum
  int direction = 0;                    // 1: up since the last one; 0: not known yet
  const auto add = [&](std::size_t i) {
    if (i > 0 && i + 1 < t.size()) extrema.push_back(vertex_at(t, value, i));
  };
  for (std::size_t i = 1; i < t.size(); ++i) {
    if (value[i] > value[highest]) highest = i;
    if (value[i] < value[lowest]) lowest = i;
    if (direction <= 0 && value[i] - value[lowest] >= swing) {
      add(lowest);
      direction = 1;
      highest = i;
    } else if (direction >= 0 && value[highest] - value[i] >= swing) {
      add(highest);
      direction = -1;
      lowest = i;
    }
  }
  return extrema;
}

std::optional<RingDown> ring_down_of(const std::vector<Extremum>& extrema) {
  if (extrema.size() < 3) return {};
  std::vector<double> times, logarithms;
  for (std::size_t k = 0; k < extrema.size(); ++k) {
    times.push_back(extrema[k].t);
    if (k > 0) logarithms.push_back(std::log(std::abs(extrema[k].value - extrema[k - 1].value)));
  }
  const double decrement = -slope_of(logarithms);  // of half a period
  return RingDown{.frequency = 1 / (2 * slope_of(times)),
                  .damping_ratio = decrement / std::hypot(std::numbers::pi, decrement),
                  .swings = int(logarithms.size())};
}

}  // namespace mss::fit

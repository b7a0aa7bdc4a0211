#include "experiments/harness/ring_down.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace mss {

namespace {

/// Turns by less than this share of the largest distance from the rest are ripple.
constexpr double ripple = 0.02;

bool ascends(const std::vector<double>& times) {
  return std::adjacent_find(times.begin(), times.end(), [](double a, double b) { return !(a < b); }) ==
         times.end();
}

bool all_finite(const std::vector<double>& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
}

/// The vertex of the parabola through the samples i - 1, i and i + 1, the middle of which is the outermost.
Extremum vertex(const std::vector<double>& t, const std::vector<double>& y, std::size_t i) {
  const double left = t[i - 1] - t[i], right = t[i + 1] - t[i];
  const double a = (y[i - 1] - y[i]) / left, b = (y[i + 1] - y[i]) / right;  // slopes of the chords
  const double curvature = (b - a) / (right - left), slope = (right * a - left * b) / (right - left);
  if (curvature == 0) return {t[i], y[i]};
  const double shift = -slope / (2 * curvature);
  return {t[i] + shift, y[i] + slope * shift / 2};
}

/// Of `count` peaks, evenly spaced in time, the mean time between them [s].
double mean_period(const std::vector<Extremum>& peaks, std::size_t count) {
  return (peaks[count - 1].time - peaks[0].time) / double(count - 1);
}

double ratio_of_decrement(double decrement) {
  return decrement / std::hypot(2 * std::numbers::pi, decrement);
}

/// How many of the peaks, from the first on, are on their side of the rest: `side` 1 above, -1 below.
std::size_t on_their_side(const std::vector<Extremum>& peaks, double rest, double side) {
  const auto other = std::find_if(peaks.begin(), peaks.end(),
                                  [=](const Extremum& peak) { return !(side * (peak.value - rest) > 0); });
  return std::size_t(other - peaks.begin());
}

/// Damping ratio of whole swings: upper peaks less the mean of their lower neighbours; missing if fewer than
/// two upper peaks have both.
double swing_ratio(const Extrema& extrema, std::size_t most_upper) {
  std::vector<double> swings;
  for (std::size_t i = 0; i < most_upper; ++i) {
    const Extremum& peak = extrema.upper[i];
    const auto after = std::find_if(extrema.lower.begin(), extrema.lower.end(),
                                    [&](const Extremum& low) { return low.time > peak.time; });
    if (after == extrema.lower.begin()) continue;  // it begins at a peak: no lower one before that
    if (after == extrema.lower.end()) break;
    swings.push_back(peak.value - ((after - 1)->value + after->value) / 2);
  }
  if (swings.size() < 2) return no_value;
  return ratio_of_decrement(std::log(swings.front() / swings.back()) / double(swings.size() - 1));
}

}  // namespace

Extrema find_extrema(const std::vector<double>& times, const std::vector<double>& values,
                     double least_swing) {
  if (times.size() != values.size() || !all_finite(times) || !all_finite(values) || !ascends(times))
    throw std::invalid_argument("find_extrema: as many finite values as times that ascend are needed");
  Extrema found;
  std::size_t highest = 0, lowest = 0;
  bool rising = true, falling = true;  // both until the first turn
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] > values[highest]) highest = i;
    if (values[i] < values[lowest]) lowest = i;
    if (rising && values[i] < values[highest] - least_swing) {
      if (highest > 0) found.upper.push_back(vertex(times, values, highest));
      rising = false, falling = true;
      lowest = i;
    } else if (falling && values[i] > values[lowest] + least_swing) {
      if (lowest > 0) found.lower.push_back(vertex(times, values, lowest));
      falling = false, rising = true;
      highest = i;
    }
  }
  return found;
}

RingDown ring_down(const Extrema& extrema, double rest, int most_periods) {
  const std::size_t most = std::size_t(most_periods) + 1;
  const std::size_t upper = std::min(most, on_their_side(extrema.upper, rest, 1));
  const std::size_t lower = std::min(most, on_their_side(extrema.lower, rest, -1));
  if (upper < 3) return {.status = "fewer than three upper peaks"};
  if (lower < 3) return {.status = "fewer than three lower peaks"};
  const double decrement =
      std::log((extrema.upper[0].value - rest) / (extrema.upper[upper - 1].value - rest)) / double(upper - 1);
  const double swings = swing_ratio(extrema, upper);
  if (std::isnan(swings)) return {.status = "no two upper peaks between lower ones"};
  return {.frequency = 2 / (mean_period(extrema.upper, upper) + mean_period(extrema.lower, lower)),
          .damping_ratio = ratio_of_decrement(decrement),
          .swing_damping_ratio = swings,
          .periods = int(upper) - 1};
}

RingDown ring_down(const std::vector<double>& times, const std::vector<double>& values, double rest,
                   int most_periods) {
  if (times.size() != values.size()) return {.status = "not as many values as times"};
  if (!all_finite(times) || !all_finite(values) || !std::isfinite(rest))
    return {.status = "a number is missing"};
  if (!ascends(times)) return {.status = "times do not ascend"};
  double furthest = 0;
  for (const double value : values) furthest = std::max(furthest, std::abs(value - rest));
  return ring_down(find_extrema(times, values, ripple * furthest), rest, most_periods);
}

}  // namespace mss

#include "experiments/harness/ring_down.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace mss {

namespace {

/// Turns by less than this share of all that a series moves are ripple.
constexpr double ripple = 0.05;

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

/// Slope of the straight line through y[0], y[1], ... by least squares.
double slope_of(const std::vector<double>& y) {
  const double middle = double(y.size() - 1) / 2;
  double product = 0, square = 0;
  for (std::size_t k = 0; k < y.size(); ++k) {
    product += (double(k) - middle) * y[k];
    square += (double(k) - middle) * (double(k) - middle);
  }
  return product / square;
}

bool alternates(const std::vector<Extremum>& turns) {
  for (std::size_t k = 2; k < turns.size(); ++k)
    if (!((turns[k].value - turns[k - 1].value) * (turns[k - 1].value - turns[k - 2].value) < 0))
      return false;
  return true;
}

/// Heights of upper peaks above the rest, up to the first that is not.
std::vector<double> heights_above(double rest, const std::vector<Extremum>& turns) {
  std::vector<double> heights;
  for (std::size_t k = turns[0].value > turns[1].value ? 0 : 1; k < turns.size(); k += 2) {
    if (!(turns[k].value > rest)) break;
    heights.push_back(turns[k].value - rest);
  }
  return heights;
}

}  // namespace

std::vector<Extremum> turning_points(const std::vector<double>& times, const std::vector<double>& values,
                                     double least_swing) {
  if (times.size() != values.size() || !all_finite(times) || !all_finite(values) || !ascends(times))
    throw std::invalid_argument("turning_points: as many finite values as times that ascend are needed");
  std::vector<Extremum> turns;
  std::size_t highest = 0, lowest = 0;
  bool rising = true, falling = true;  // both until the first turn
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (values[i] > values[highest]) highest = i;
    if (values[i] < values[lowest]) lowest = i;
    if (rising && values[i] < values[highest] - least_swing) {
      if (highest > 0) turns.push_back(vertex(times, values, highest));
      rising = false, falling = true;
      lowest = i;
    } else if (falling && values[i] > values[lowest] + least_swing) {
      if (lowest > 0) turns.push_back(vertex(times, values, lowest));
      falling = false, rising = true;
      highest = i;
    }
  }
  return turns;
}

std::vector<Extremum> turning_points(const std::vector<double>& times, const std::vector<double>& values) {
  if (values.empty()) return {};
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  return turning_points(times, values, ripple * (*most - *least));
}

RingDown ring_down(const std::vector<Extremum>& turns, double rest, int most_turns) {
  const std::size_t count = std::min(turns.size(), std::size_t(most_turns));
  if (count < 3) return {.status = "fewer than three turning points"};
  const std::vector<Extremum> first(turns.begin(), turns.begin() + std::ptrdiff_t(count));
  if (!alternates(first)) return {.status = "maxima and minima are not in turn"};
  std::vector<double> times, logarithms;
  for (std::size_t k = 0; k < count; ++k) {
    times.push_back(first[k].time);
    if (k > 0) logarithms.push_back(std::log(std::abs(first[k].value - first[k - 1].value)));
  }
  if (!ascends(times)) return {.status = "times do not ascend"};
  const double swings = -slope_of(logarithms);
  RingDown found{.frequency = 1 / (2 * slope_of(times)),
                 .swing_damping_ratio = swings / std::hypot(std::numbers::pi, swings)};
  if (std::isnan(rest)) return found;
  const std::vector<double> heights = heights_above(rest, first);
  if (heights.size() < 2) return {.status = "fewer than two upper peaks above the rest"};
  const double peaks = std::log(heights.front() / heights.back()) / double(heights.size() - 1);
  found.peak_damping_ratio = peaks / std::hypot(2 * std::numbers::pi, peaks);
  return found;
}

RingDown ring_down(const std::vector<double>& times, const std::vector<double>& values, double rest,
                   int most_turns) {
  if (times.size() != values.size()) return {.status = "not as many values as times"};
  if (!all_finite(times) || !all_finite(values)) return {.status = "a number is missing"};
  if (!ascends(times)) return {.status = "times do not ascend"};
  return ring_down(turning_points(times, values), rest, most_turns);
}

}  // namespace mss

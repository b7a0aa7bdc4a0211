#pragma once

#include <algorithm>
#include <vector>

namespace mss {

/// A function of time that is linear between given points, and constant before the first and after the last.
/// Where two pieces meet, its slope is that of the later one.
template <class Value>
struct PiecewiseLinear {
  struct Point {
    double t;  ///< [s]
    Value value;
  };
  std::vector<Point> points{};  ///< ascending in t; none: not given

  bool empty() const { return points.empty(); }
  /// Whether it changes at a time, or later.
  bool changes(double t) const { return points.size() > 1 && t < points.back().t; }

  /// There must be a point.
  Value at(double t) const {
    const auto next = after(t);
    if (next == points.begin()) return next->value;
    const Point& before = *(next - 1);
    if (next == points.end()) return before.value;
    return before.value + (t - before.t) / (next->t - before.t) * (next->value - before.value);
  }
  /// There must be a point.
  Value slope(double t) const {
    const auto next = after(t);
    if (next == points.begin() || next == points.end()) return 0 * points.front().value;
    const Point& before = *(next - 1);
    return (next->value - before.value) / (next->t - before.t);
  }

 private:
  typename std::vector<Point>::const_iterator after(double t) const {
    return std::upper_bound(points.begin(), points.end(), t,
                            [](double a, const Point& p) { return a < p.t; });
  }
};

}  // namespace mss

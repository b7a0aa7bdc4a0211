#pragma once

#include <string>
#include <vector>

#include "experiments/harness/table.hpp"

// What a motion that rings down says of a material: its frequency and its damping. Measured series and
// computed ones go through the same functions.

namespace mss {

/// A turning point of a motion.
struct Extremum {
  double time = 0;   ///< [s]
  double value = 0;  ///< in the unit of the series
};

/// Maxima and minima of a sampled series, in turn, each at the vertex of the parabola through the outermost
/// sample and its two neighbours, which may be spaced unevenly. A turn counts only if the series goes back by
/// more than `least_swing` after it, so that noise and the ripple of faster modes make none; the first and
/// the last sample are none. All numbers must be finite, and times ascend: throws std::invalid_argument.
std::vector<Extremum> turning_points(const std::vector<double>& times, const std::vector<double>& values,
                                     double least_swing);

/// The same, where swings of less than a twentieth of all that the series moves do not count.
std::vector<Extremum> turning_points(const std::vector<double>& times, const std::vector<double>& values);

/// Frequency and damping of a series that rings down. Numbers are missing where the status is not "ok".
struct RingDown {
  std::string status = "ok";
  /// Of the damped motion [Hz]: turning points are half a period apart, by least squares.
  double frequency = no_value;
  /// The ratio to critical damping, zeta = d / sqrt(pi^2 + d^2), of the logarithmic decrement d of swings
  /// from one turning point to the next, by least squares: where the motion comes to rest does not change it,
  /// nor, to first order, how that place drifts.
  double swing_damping_ratio = no_value;
  /// The same of upper peaks about a rest, zeta = d / sqrt(4 pi^2 + d^2), from the first to the last, as
  /// measurements are often read; missing where no rest is given.
  double peak_damping_ratio = no_value;
};

/// From the first turning points, `most_turns` of them at most. Needs three, that ascend in time and go up
/// and down in turn; with a `rest`, two upper peaks above it: else the status says what is missing.
RingDown ring_down(const std::vector<Extremum>& turns, double rest = no_value, int most_turns = 1 << 20);

/// The same from samples, whose numbers that are not finite and times that do not ascend are statuses too.
RingDown ring_down(const std::vector<double>& times, const std::vector<double>& values,
                   double rest = no_value, int most_turns = 1 << 20);

}  // namespace mss

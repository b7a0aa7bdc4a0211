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

/// The turning points of a motion, each kind in time.
struct Extrema {
  std::vector<Extremum> upper, lower;
};

/// Turning points of a sampled series, each at the vertex of the parabola through the outermost sample and
/// its two neighbours, which may be spaced unevenly. A turn counts only if the series goes back by more than
/// `least_swing` after it, so that the ripple of faster modes makes no peaks; the first and the last sample
/// are none. All numbers must be finite, and times ascend: throws std::invalid_argument.
Extrema find_extrema(const std::vector<double>& times, const std::vector<double>& values,
                     double least_swing = 0);

/// Frequency and damping of a series that rings down. Numbers are missing where the status is not "ok".
struct RingDown {
  std::string status = "ok";
  double frequency = no_value;  ///< of the damped motion [Hz], see ring_down()
  /// The ratio to critical damping, zeta = d / sqrt(4 pi^2 + d^2), of the logarithmic decrement d of the
  /// upper peaks about the rest, a period;
  double damping_ratio = no_value;
  /// and of whole swings, from each upper peak to the mean of the lower ones before and after it, which a
  /// rest that drifts does not change.
  double swing_damping_ratio = no_value;
  int periods = 0;  ///< that the decrement is of
};

/// How many periods a decrement is taken over at most. Later peaks of a measured motion are nearer to noise
/// and to what the rest drifts.
inline constexpr int ring_down_periods = 3;

/// From turning points: over the first periods, `most_periods` of them at most; the frequency is one over the
/// mean of the mean periods of upper and of lower peaks. Needs three upper peaks above the rest and three
/// lower ones below it: else the status says what is missing.
RingDown ring_down(const Extrema& extrema, double rest, int most_periods = ring_down_periods);

/// The same from samples. Turns of less than a fiftieth of the largest distance from the rest do not count.
/// Numbers that are not finite, and times that do not ascend, are statuses too.
RingDown ring_down(const std::vector<double>& times, const std::vector<double>& values, double rest,
                   int most_periods = ring_down_periods);

}  // namespace mss

#pragma once

#include <optional>
#include <vector>

namespace mss::fit {

/// A turning point of a quantity in time.
struct Extremum {
  double t = 0;  ///< [s]
  double value = 0;
};

/// Maxima and minima in turn, between which a quantity moves by at least a twentieth of all that it does:
/// less is noise, or the end of a decay. Their places are those of parabolas through three samples; the first
/// and the last sample are none. Times ascend.
std::vector<Extremum> extrema_of(const std::vector<double>& t, const std::vector<double>& value);

/// A decaying vibration.
struct RingDown {
  double frequency = 0;      ///< of the damped vibration [Hz]
  double damping_ratio = 0;  ///< of critical damping
  int swings = 0;            ///< from one extremum to the next
};

/// From the times of extrema by least squares, half a period from one to the next, and from the logarithms of
/// the swings between them, which do not depend on where the vibration comes to rest, nor to first order on
/// how that place moves. Nothing of fewer than three extrema.
std::optional<RingDown> ring_down_of(const std::vector<Extremum>& extrema);

}  // namespace mss::fit

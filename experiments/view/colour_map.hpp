#pragma once

#include <array>
#include <vector>

namespace mss::view {

/// Red, green, blue of sRGB, 0 to 1.
using Colour = std::array<float, 3>;

/// The map viridis (van der Walt and Smith, 2015): equal steps appear equally large, also to the colour-blind
/// and in grey. `share` is clamped to [0, 1]; NaN gives a grey that the map has nowhere.
Colour map_colour(double share);

/// The interval of numbers that a colour bar spans, and its ticks.
struct ValueRange {
  double low = 0;
  double high = 1;
  double step = 0.2;  ///< between ticks, one, two or five times a power of ten

  double share(double value) const { return (value - low) / (high - low); }
  std::vector<double> ticks() const;
};

/// The smallest range of whole steps, three to eight of them, that holds [low, high], widened to `least`
/// about its middle if it is narrower.
ValueRange round_range(double low, double high, double least);

}  // namespace mss::view

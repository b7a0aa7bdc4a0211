#pragma once

#include "core/body/cell_fill.hpp"

namespace mss {

inline double mean_of(const std::array<float, 8>& corners) {
  double sum = 0;
  for (const float share : corners) sum += double(share);
  return sum / 8;
}

/// The mean of the octants next to a spring between two corners of a cell: those of the smallest box of
/// corners that contains both.
inline double filled_at(const CellFill& fill, int a, int b) {
  double sum = 0;
  int count = 0;
  for (int c = 0; c < 8; ++c)
    if (((c ^ a) & ~(a ^ b)) == 0) {
      sum += double(fill.octant[std::size_t(c)]);
      ++count;
    }
  return sum / count;
}

/// A share with a floor: 0 keeps it, 1 replaces it by the mean.
inline double blend(double share, double floor, double mean) { return share + floor * (mean - share); }

/// Share of a full cell's part of a spring between two corners that a fill gives it; `floor` is
/// BodyConfig::springs_floor().
inline double spring_share(const CellFill& fill, int a, int b, double floor) {
  return blend(filled_at(fill, a, b), floor, mean_of(fill.octant));
}

/// Share of a full corner's mass that a fill gives a corner; `floor` is BodyConfig::mass_floor().
inline double corner_share(const CellFill& fill, int corner, double floor) {
  return blend(double(fill.corner[std::size_t(corner)]), floor, mean_of(fill.corner));
}

}  // namespace mss

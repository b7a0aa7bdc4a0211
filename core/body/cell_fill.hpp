#pragma once

#include <array>
#include <numeric>
#include <vector>

namespace mss {

/// How a material fills a cell, corners numbered c = bx + 2 by + 4 bz.
struct CellFill {
  std::array<float, 8> octant{};  ///< filled share of the eighth at each corner, in [0, 1]
  /// Eight times the integral of the corner's trilinear weight over what is filled, over the cell's volume:
  /// the share of the cell's mass at a corner, 1 in a full cell. Their mean is share().
  std::array<float, 8> corner{};

  /// A cell filled evenly, as f = 1 for a full one.
  static constexpr CellFill even(float f) {
    CellFill fill;
    fill.octant.fill(f);
    fill.corner.fill(f);
    return fill;
  }
  /// Filled share of the cell.
  float share() const { return std::accumulate(octant.begin(), octant.end(), 0.0F) / 8; }

  bool operator==(const CellFill&) const = default;
};

/// What a cell holds of one part of the body.
struct PartFill {
  int part = 0;
  CellFill fill = CellFill::even(1);

  bool operator==(const PartFill&) const = default;
};

/// What a cell holds: one entry per part in it.
using CellContent = std::vector<PartFill>;

}  // namespace mss

#pragma once

#include <array>
#include <vector>

#include "core/body/body.hpp"

namespace mss::studies::reduce {

/// Positions of the particles of a box from those of the same box in larger cells, each by the trilinear
/// interpolation of the cell that it rests in.
class Trilinear {
 public:
  /// Both bodies must outlive it.
  Trilinear(const Body& coarse, const Body& fine);

  /// Writes x [m], of all particles of the fine body.
  void draw(const Field<double>& coarse, Field<double>& x);

 private:
  /// Between which lattice planes of the larger cells one of the smaller lies, and where.
  struct Between {
    int lower;
    double share;
  };

  const Lattice &coarse_, &fine_;
  std::array<std::vector<Between>, 3> between_;  ///< by axis and plane
  std::vector<int> lower_;                       ///< of the first axis, once more,
  std::vector<double> share_, row_;              ///< and a row of the larger cells where a fine row is
};

}  // namespace mss::studies::reduce

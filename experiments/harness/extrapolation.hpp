#pragma once

#include <cmath>
#include <vector>

#include "experiments/harness/table.hpp"

namespace mss {

/// What values at finer and finer cells tend to, as v + c h^p.
struct Limit {
  double value = no_value;
  double order = no_value;  ///< p
};

/// From three values, each at a size of cells half of the one before.
inline Limit limit_of(const std::vector<double>& values) {
  const double ratio = (values[1] - values[0]) / (values[2] - values[1]);
  return {values[2] + (values[2] - values[1]) / (ratio - 1), std::log2(ratio)};
}

/// Richardson's extrapolation from two such values, p assumed to be 2.
inline double richardson(double coarse, double fine) { return fine + (fine - coarse) / 3; }

}  // namespace mss

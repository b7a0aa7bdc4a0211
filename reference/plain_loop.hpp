#pragma once

#include <cstdint>
#include <vector>

#include "reference/algorithm1.hpp"

namespace mss::reference {

/// What a careful programmer writes first: one thread, no atomics, flat arrays of springs and particles, each
/// force added once. The second baseline of the timing chart: it shows how much of Algorithm 1's time is its
/// atomics.
class PlainLoop {
 public:
  /// Takes particles, springs and cells from `model`, at its current state.
  explicit PlainLoop(const Algorithm1& model);

  /// One update with semi-implicit Euler.
  void step(double dt);

  const std::vector<Vec3>& positions() const { return x_; }

 private:
  struct Spring {
    std::uint32_t a, b;
    double stiffness, rest_length, damping;
  };
  void add_volume_forces();

  Vec3 gravity_;
  double volume_stiffness_;
  double cell_volume_;
  std::vector<Vec3> x_, v_, f_;
  std::vector<double> mass_;
  std::vector<Spring> springs_;
  std::vector<Algorithm1::Cell> cells_;
};

}  // namespace mss::reference

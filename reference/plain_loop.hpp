#pragma once

#include <cstdint>
#include <vector>

#include "reference/algorithm1.hpp"

namespace mss::reference {

/// What a careful programmer writes first: no atomics, flat arrays of springs and particles, each force added
/// once. The second baseline of the timing chart: it shows how much of Algorithm 1's time is its atomics.
/// Real is float or double. With several threads each adds to forces of its own, which are summed for each
/// particle.
template <class Real>
class PlainLoop {
 public:
  using Vector = Eigen::Matrix<Real, 3, 1>;

  /// Takes particles, springs and cells from `model`, at its current state.
  explicit PlainLoop(const Algorithm1& model, int threads = 1);

  /// One update with semi-implicit Euler.
  void step(double dt);

  const std::vector<Vector>& positions() const { return x_; }

 private:
  struct Spring {
    std::uint32_t a, b;
    Real stiffness, rest_length, damping;
  };
  /// The part of the springs and cells that one of `ranks` threads adds to its forces.
  void add_forces(std::size_t rank, std::size_t ranks);
  void add_volume_force(const Algorithm1::Cell& cell, std::vector<Vector>& f) const;
  /// The part of the particles that it moves.
  void move_particles(Real dt, std::size_t rank, std::size_t ranks);

  int threads_;
  Vector gravity_;
  bool has_volume_force_;
  Real cell_volume_;
  std::vector<Vector> x_, v_;
  std::vector<std::vector<Vector>> f_;  ///< by thread
  std::vector<Real> mass_;
  std::vector<Spring> springs_;
  std::vector<Algorithm1::Cell> cells_;
};

}  // namespace mss::reference

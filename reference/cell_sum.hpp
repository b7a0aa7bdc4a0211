#pragma once

#include <array>
#include <vector>

#include "core/body/body.hpp"
#include "core/system/system.hpp"

namespace mss {

/// A vector per corner c = bx + 2 by + 4 bz of a cell.
using CellCorners = Eigen::Matrix<double, 3, 8>;

/// A matrix by corner, then axis, and the 3 x 3 block of two corners.
using CellMatrix = Eigen::Matrix<double, 24, 24>;
inline Eigen::Matrix3d block_of(const CellMatrix& matrix, Eigen::Index c, Eigen::Index d) {
  return matrix.block<3, 3>(3 * c, 3 * d);
}

/// -sum f x^T [J] of forces [N] on the corners of a cell, about the mean of these [m].
inline Eigen::Matrix3d virial_about_middle(const CellCorners& forces, const CellCorners& corners) {
  return -forces * (corners.colwise() - corners.rowwise().mean()).transpose();
}

/// Values of a field at the corners of the cell at a site.
CellCorners corners_at(const Body& body, const Field<double>& field, std::ptrdiff_t site);

/// Adds up contributions of cells to their corners, for each particle always in the same order, so that
/// results are the same bits for any number of threads.
class CellSum {
 public:
  /// The body must outlive it.
  explicit CellSum(const Body& body);

  /// Sites of the cells' lower corners.
  const std::vector<std::ptrdiff_t>& cells() const { return cells_; }

  /// Adds per_cell(site), CellCorners, of every cell to `out`, on the system's threads.
  template <class PerCell>
  void add(System<double>& system, PerCell&& per_cell, Field<double>& out) {
    system.parallel(std::ptrdiff_t(cells_.size()), [&](std::ptrdiff_t cell) {
      shares_[std::size_t(cell)] = per_cell(cells_[std::size_t(cell)]);
    });
    system.parallel(std::ptrdiff_t(cells_at_.size()), [&](std::ptrdiff_t p) {
      Vec3 sum = Vec3::Zero();
      for (std::size_t c = 0; c < 8; ++c)
        if (const std::ptrdiff_t cell = cells_at_[std::size_t(p)][c]; cell >= 0)
          sum += shares_[std::size_t(cell)].col(Eigen::Index(c));
      const std::ptrdiff_t site = body_.sites()[std::size_t(p)];
      out.set(site, out.at(site) + sum);
    });
  }

 private:
  const Body& body_;
  std::vector<std::ptrdiff_t> cells_;
  std::vector<std::array<std::ptrdiff_t, 8>> cells_at_;  ///< per particle: the cell it is corner c of, or -1
  std::vector<CellCorners> shares_;
};

}  // namespace mss

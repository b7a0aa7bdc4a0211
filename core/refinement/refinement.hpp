#pragma once

#include <array>
#include <set>
#include <vector>

#include "core/body/body.hpp"

namespace mss {

/// Where cells are smaller: those with volume in the box are split in eight, and their parts again, so many
/// times.
struct RefinedBox {
  Box box{};
  int levels = 1;
};

/// Which cells of a body are split in eight, and which of their parts again.
///
/// A cell of depth d has edges of h / 2^d, and its indices count such cells from the lower corner of the box
/// of the body's voxels.
class RefinementMap {
 public:
  using Cell = std::array<int, 3>;

  /// Splits a cell, and whatever it lies in.
  void split(int depth, Cell cell);
  bool is_split(int depth, const Cell& cell) const {
    return std::size_t(depth) < split_.size() && split_[std::size_t(depth)].contains(cell);
  }
  /// The greatest depth of a cell.
  int depth() const { return int(split_.size()); }
  /// How many cells are split, of all depths.
  std::size_t split_count() const;
  /// In order.
  const std::set<Cell>& split_cells(int depth) const { return split_[std::size_t(depth)]; }

  /// Splits what must be for cells that touch, if only at a corner, to differ by one depth at most (2:1).
  void balance(const VoxelGrid& voxels);

 private:
  std::vector<std::set<Cell>> split_;  ///< by depth
};

/// Whether the body has a cell of that depth there, or cells that are parts of it.
bool has_cell(const VoxelGrid& voxels, int depth, const RefinementMap::Cell& cell);

/// The cells that boxes split; not balanced.
RefinementMap refinement_of(const BodyConfig& body, const std::vector<RefinedBox>& boxes);

}  // namespace mss

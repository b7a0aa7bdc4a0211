#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/body/cell_fill.hpp"

namespace mss {

/// Which cells of an nx x ny x nz box belong to a body. Cell (i, j, k) lies at [i, i+1] x [j, j+1] x [k, k+1]
/// in units of the cell size.
///
/// Along an axis of 0 cells a box is flat: its cells are squares, and along two such axes lines. There they
/// count as repeated without end: coordinates along it say nothing.
class VoxelGrid {
 public:
  /// Throws InputError for numbers below 0, and three times 0.
  VoxelGrid(int nx, int ny, int nz, bool filled = false);

  /// A completely filled box.
  static VoxelGrid box(int nx, int ny, int nz) { return {nx, ny, nz, true}; }

  int nx() const { return size_[0]; }
  int ny() const { return size_[1]; }
  int nz() const { return size_[2]; }
  std::array<int, 3> size() const { return size_; }

  /// Axes along which it is flat, as bits.
  int flat_axes() const { return int(size_[0] == 0) + 2 * int(size_[1] == 0) + 4 * int(size_[2] == 0); }
  /// 3 of a solid, 2 of a sheet, 1 of a rope.
  int dimensions() const { return int(size_[0] > 0) + int(size_[1] > 0) + int(size_[2] > 0); }

  /// True where a cell is; false outside the box too, so that callers need no border cases.
  bool at(int i, int j, int k) const {
    return is_within(0, i) && is_within(1, j) && is_within(2, k) && cells_[index(i, j, k)] != 0;
  }
  void set(int i, int j, int k, bool present) { cells_[index(i, j, k)] = present ? 1 : 0; }

  /// Of a cell inside the box among all boxed(), x first.
  std::size_t index(int i, int j, int k) const {
    return static_cast<std::size_t>(i) * step_[0] + static_cast<std::size_t>(j) * step_[1] +
           static_cast<std::size_t>(k) * step_[2];
  }

  std::size_t count() const;
  /// Cells that the box has room for.
  std::size_t boxed() const { return cells_.size(); }

  /// Calls visit(i, j, k) for every place in the box, x first, whether a cell is there or not; along flat
  /// axes with 0.
  template <class Visit>
  void for_each_place(Visit&& visit) const {
    for (int k = 0; k < places(2); ++k)
      for (int j = 0; j < places(1); ++j)
        for (int i = 0; i < places(0); ++i) visit(i, j, k);
  }

 private:
  int places(std::size_t axis) const { return size_[axis] == 0 ? 1 : size_[axis]; }
  bool is_within(std::size_t axis, int i) const { return size_[axis] == 0 || (i >= 0 && i < size_[axis]); }

  std::array<int, 3> size_;
  std::array<std::size_t, 3> step_;  ///< from one cell to the next along an axis; 0 along flat ones
  std::vector<std::uint8_t> cells_;
};

/// Cells, and what they hold as in BodyConfig.
struct VoxelFile {
  VoxelGrid voxels;
  std::vector<CellContent> contents{};
  std::vector<std::uint32_t> content_of{};
};

/// Reads z-layers, bottom first, separated by blank lines; a line is one row of x, lines go along y. '#' is a
/// full cell of part 0, '1' to '9' one filled to so many tenths, a letter from A to Z a full cell of the part
/// of that name, '.' none. `parts` are the names of parts 1, 2, ... Throws InputError naming file and line
/// for anything else, ragged rows included.
VoxelFile read_voxels(const std::filesystem::path& file, const std::vector<std::string>& parts = {});

}  // namespace mss

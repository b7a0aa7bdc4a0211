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
class VoxelGrid {
 public:
  VoxelGrid(int nx, int ny, int nz, bool filled = false);

  /// A completely filled box.
  static VoxelGrid box(int nx, int ny, int nz) { return {nx, ny, nz, true}; }

  int nx() const { return size_[0]; }
  int ny() const { return size_[1]; }
  int nz() const { return size_[2]; }
  std::array<int, 3> size() const { return size_; }

  /// True where a cell is; false outside the box too, so that callers need no border cases.
  bool at(int i, int j, int k) const {
    const bool inside = i >= 0 && j >= 0 && k >= 0 && i < size_[0] && j < size_[1] && k < size_[2];
    return inside && cells_[index(i, j, k)] != 0;
  }
  void set(int i, int j, int k, bool present) { cells_[index(i, j, k)] = present ? 1 : 0; }

  /// Of a cell inside the box among all nx ny nz, x first.
  std::size_t index(int i, int j, int k) const {
    return static_cast<std::size_t>(i) +
           static_cast<std::size_t>(size_[0]) *
               (static_cast<std::size_t>(j) +
                static_cast<std::size_t>(size_[1]) * static_cast<std::size_t>(k));
  }

  std::size_t count() const;

 private:
  std::array<int, 3> size_;
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

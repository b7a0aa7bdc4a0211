#pragma once

#include <array>
#include <cstddef>

namespace mss {

/// Whether corner c = bx + 2 by + 4 bz of a cell is on its upper side along an axis: 0 or 1.
constexpr int corner_bit(int corner, int axis) { return (corner >> axis) & 1; }
/// The same as -1 or 1.
constexpr int corner_sign(int corner, int axis) { return corner_bit(corner, axis) != 0 ? 1 : -1; }

/// Index arithmetic of the particle lattice: site (i, j, k) is the corner shared by up to eight cells.
///
/// Sites of one plane (fixed k) are contiguous and rows along x follow each other without gaps. Planes start
/// at multiples of `plane_align`, so that a vector block never straddles two of them, and end with an
/// empty row and block: the sweep may read the eight corners of any block without bounds checks, and still
/// reads from two planes only, so that another thread may write the plane after those at the same time. One
/// ghost plane lies behind the last.
struct Lattice {
  static constexpr std::ptrdiff_t plane_align = 16;  ///< the widest vector: 16 floats

  Lattice(int nx, int ny, int nz) : cells{nx, ny, nz}, row(nx + 1) {
    const std::ptrdiff_t padded = used() + row + 1 + plane_align;
    plane = (padded + plane_align - 1) / plane_align * plane_align;
    sites = plane * (nz + 1);
    size = sites + plane;
  }

  /// Sites of a plane that rows cover.
  std::ptrdiff_t used() const { return row * (cells[1] + 1); }

  int planes() const { return cells[2] + 1; }
  std::ptrdiff_t site(int i, int j, int k) const { return i + row * j + plane * k; }

  /// The reverse: (i, j, k).
  std::array<int, 3> coordinates(std::ptrdiff_t site) const {
    const std::ptrdiff_t in_plane = site % plane;
    return {int(in_plane % row), int(in_plane / row), int(site / plane)};
  }

  /// Offset from a cell's lower corner to its corner c = bx + 2 by + 4 bz.
  std::ptrdiff_t corner(int c) const {
    return corner_bit(c, 0) + row * corner_bit(c, 1) + plane * corner_bit(c, 2);
  }

  std::array<int, 3> cells;  ///< cells along x, y, z
  std::ptrdiff_t row;        ///< sites from one row to the next
  std::ptrdiff_t plane;      ///< sites from one plane to the next
  std::ptrdiff_t sites;      ///< sites that may hold particles, padding between planes included
  std::ptrdiff_t size;       ///< length of an array over sites, ghosts included
};

}  // namespace mss

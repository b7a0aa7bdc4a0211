#pragma once

#include <array>
#include <cstddef>

#include "core/base/lattice.hpp"

namespace mss {

/// The sites of a lattice, sorted into eight parts by the parity of their three coordinates.
///
/// Colour p = px + 2 py + 4 pz has the cells (2a + px, 2b + py, 2c + pz). No two of a colour share a corner,
/// and eight is the fewest colours for which that is so: the corners of a cell are all neighbours. Corner
/// c = bx + 2 by + 4 bz of every cell of a colour lies in one part, p ^ c, at the cell's own index there plus
/// corner(p, c), so that a kernel reads the corners of neighbouring cells of a colour from contiguous memory.
/// Every part has the dimensions of the largest. Planes end with room for the corners of what kernels take
/// for cells beyond the last row, so that two pairs of planes have no number in common.
struct ColouredLattice {
  static constexpr int colours = 8;

  explicit ColouredLattice(const Lattice& lattice)
      : row(lattice.cells[0] / 2 + 1), planes_in_part(lattice.cells[2] / 2 + 1), cells(lattice.cells) {
    constexpr std::ptrdiff_t align = Lattice::plane_align;
    const auto aligned = [](std::ptrdiff_t count) { return (count + align - 1) / align * align; };
    plane = aligned(aligned(used()) + row + 1);
    before = aligned(1 + row + plane);
    part = plane * (planes_in_part + 1) + aligned(1 + row) + align;
  }

  /// Indices of a plane of a part that its rows cover.
  std::ptrdiff_t used() const { return row * (cells[1] / 2 + 1); }
  /// The same in whole blocks of that many lanes.
  std::ptrdiff_t used(int lanes) const { return (used() + lanes - 1) / lanes * lanes; }

  std::ptrdiff_t size() const { return before + colours * part; }
  static int colour(int i, int j, int k) { return (i & 1) + 2 * (j & 1) + 4 * (k & 1); }
  /// Of site (i, j, k) in arrays of size().
  std::ptrdiff_t index(int i, int j, int k) const {
    return before + colour(i, j, k) * part + i / 2 + row * (j / 2) + plane * (k / 2);
  }
  /// From an index within the part of a colour to that, in arrays of size(), of the site one further by dx,
  /// dy, dz, each -1, 0 or 1.
  std::ptrdiff_t neighbour(int colour, int dx, int dy, int dz) const {
    const auto pairs = [](int parity, int d) { return d > 0 ? parity : d < 0 ? parity - 1 : 0; };
    const int other = colour ^ ((dx & 1) + 2 * (dy & 1) + 4 * (dz & 1));
    return before + other * part + pairs(colour & 1, dx) + row * pairs((colour >> 1) & 1, dy) +
           plane * pairs(colour >> 2, dz);
  }
  /// The same for corner c = bx + 2 by + 4 bz of a cell.
  std::ptrdiff_t corner(int colour, int c) const {
    return neighbour(colour, c & 1, (c >> 1) & 1, (c >> 2) & 1);
  }
  /// Planes of cells of a colour.
  int planes(int colour) const { return (cells[2] - (colour >> 2)) / 2 + 1; }

  std::ptrdiff_t row;     ///< indices from one row of a part to the next
  std::ptrdiff_t plane;   ///< indices from one plane of a part to the next
  std::ptrdiff_t part;    ///< indices from one part to the next
  std::ptrdiff_t before;  ///< indices before the first part
  int planes_in_part;
  std::array<int, 3> cells;
};

}  // namespace mss

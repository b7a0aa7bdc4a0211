#pragma once

#include <array>
#include <cstddef>

#include "core/refinement/refined_body.hpp"

namespace mss {

/// The cells of a refined body that have been split so often, and those that have been split further, merged:
/// the lattice that a multigrid method has in place of them. Merged cells are filled evenly, with as much of
/// every part as those that they replace have on average, and are as stiff and viscous.
struct MergedCells {
  BodyConfig config;
  RefinementMap::Cell corner{};  ///< of the lattice, the lower one, in its cells
};

MergedCells merged_cells(const RefinedBody& body, int depth);

/// Where a lattice lies in one of cells of the same size.
class LatticeWindow {
 public:
  /// `corner`: where the small lattice's lower corner is in the large one [cells].
  LatticeWindow(const Lattice& small, const Lattice& large, const std::array<int, 3>& corner)
      : small_(small),
        row_(large.row),
        plane_(large.plane),
        first_(large.site(corner[0], corner[1], corner[2])),
        is_whole_(small.cells == large.cells) {}

  const Lattice& small() const { return small_; }
  /// Whether the lattices are the same, site by site.
  bool is_whole() const { return is_whole_; }
  /// Site in the large lattice of one in the small.
  std::ptrdiff_t operator()(std::ptrdiff_t site) const {
    const std::array<int, 3> at = small_.coordinates(site);
    return first_ + at[0] + row_ * at[1] + plane_ * at[2];
  }
  /// Calls visit(first, first_in_large) for every row of the small lattice in a plane.
  template <class Visit>
  void for_each_row(std::ptrdiff_t plane, Visit&& visit) const {
    for (std::ptrdiff_t j = 0; j <= small_.cells[1]; ++j)
      visit(small_.plane * plane + small_.row * j, first_ + plane_ * plane + row_ * j);
  }

 private:
  Lattice small_;
  std::ptrdiff_t row_, plane_, first_;
  bool is_whole_;
};

}  // namespace mss

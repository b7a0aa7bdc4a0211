#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/body/body.hpp"
#include "core/kernels/sweep.hpp"

namespace mss {

/// One list per plane of a lattice.
template <class Item>
struct PlaneLists {
  std::vector<Item> items{};
  std::vector<std::size_t> begin{0};  ///< per plane and one more: where its list begins

  std::span<const Item> of(int plane) const {
    const auto k = std::size_t(plane);
    return std::span(items).subspan(begin[k], begin[k + 1] - begin[k]);
  }
  void end_plane() { begin.push_back(items.size()); }
};

/// What a sweep computes of a body: blocks of W sites that follow each other in a plane, as few as hold all
/// particles. Each begins at the first particle that none before it holds, so none overlaps another. Those of
/// a box follow each other without gaps, across the ends of rows.
class SweepBlocks {
 public:
  /// Blocks that are swept in one go, and runs no longer than that: their particles stay in the first-level
  /// cache until they are finished.
  static constexpr std::ptrdiff_t piece = 32;

  /// `width` W, the lanes of a vector.
  SweepBlocks(const Body& body, int width);

  /// A plane's blocks, ascending.
  std::span<const BlockRun> of(int plane) const { return runs_.of(plane); }
  /// The number of blocks in a run.
  std::ptrdiff_t count(const BlockRun& run) const { return (run.last - run.first) / width_; }
  /// The number of blocks in the planes below this one.
  std::size_t before(int plane) const { return before_[std::size_t(plane)]; }
  /// Where sums must be set to zero before a plane is swept: sites of blocks of this plane and the next one
  /// whose sums no block of the row before begins (see pass_on in sweep_loops.hpp).
  std::span<const BlockRun> zeroed(int plane) const { return zeroed_.of(plane); }

 private:
  std::ptrdiff_t width_;
  PlaneLists<BlockRun> runs_, zeroed_;
  std::vector<std::size_t> before_{0};
};

}  // namespace mss

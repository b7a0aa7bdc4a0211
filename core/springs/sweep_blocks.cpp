#include "core/springs/sweep_blocks.hpp"

#include <algorithm>

namespace mss {

namespace {

using Marks = std::vector<char>;  ///< per site of a plane

/// Adds the runs of the fewest blocks that hold the marked sites of a plane and end in it.
void cover(const Marks& marked, std::ptrdiff_t width, PlaneLists<BlockRun>& runs) {
  const auto size = std::ptrdiff_t(marked.size());
  const std::size_t before = runs.items.size();
  for (std::ptrdiff_t q = 0; q < size; ++q) {
    if (!marked[std::size_t(q)]) continue;
    const std::ptrdiff_t first = std::min(q, size - width), last = first + width;
    BlockRun* run = runs.items.size() > before ? &runs.items.back() : nullptr;
    if (run && first == run->last && last - run->first <= SweepBlocks::piece * width)
      run->last = last;
    else
      runs.items.push_back({first, last});
    q = last - 1;
  }
  runs.end_plane();
}

}  // namespace

SweepBlocks::SweepBlocks(const Body& body, int width) : width_(width) {
  const Lattice& lattice = body.lattice();
  Marks marked(std::size_t(lattice.plane), 0);
  const auto mark = [&](int plane, std::ptrdiff_t offset, bool value) {
    for (const BlockRun& run : of(plane))
      std::fill(marked.begin() + run.first + offset, marked.begin() + run.last + offset, char(value));
  };
  for (int k = 0; k < lattice.planes(); ++k) {
    for (std::ptrdiff_t q = 0; q < lattice.plane; ++q)
      marked[std::size_t(q)] = body.weights_at(lattice.plane * k + q).mass != 0;
    cover(marked, width, runs_);
    std::ptrdiff_t blocks = 0;
    for (const BlockRun& run : of(k)) blocks += count(run);
    before_.push_back(before_.back() + std::size_t(blocks));
  }
  for (int k = 0; k < lattice.planes(); ++k) {
    std::fill(marked.begin(), marked.end(), char(0));
    mark(k, 0, true);
    if (k + 1 < lattice.planes()) mark(k + 1, 0, true);
    if (lattice.row >= width) mark(k, lattice.row, false);
    cover(marked, width, zeroed_);
  }
}

}  // namespace mss

#include "integrators/linear/merged_cells.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "integrators/linear/coarsening.hpp"

namespace mss {

namespace {

using Cell = RefinementMap::Cell;

/// What cells of a refined body hold, as parts of merged cells.
class MergedContents {
 public:
  explicit MergedContents(const RefinedBody& body)
      : body_(body),
        parts_(int(body.config().parts.size()) + 1),
        by_ratio_(body.config().any_part(
            [](const Part& part) { return part.damping.law == Damping::Law::ratio; })) {}

  /// Parts in cells of a depth: those of the body, and, where their viscosity goes with the size of cells,
  /// once more for every size that is merged, with the viscosity of that.
  std::vector<Part> parts(int depth) const {
    std::vector<Part> all = body_.config().all_parts();
    for (Part& part : all)
      for (double* k : {&part.springs.edge, &part.springs.face, &part.springs.body})
        *k = std::ldexp(*k, -depth);
    for (int merged = depth; by_ratio_ && merged < body_.map().depth(); ++merged)
      for (int p = 0; p < parts_; ++p) {
        all.push_back(all[all.size() - std::size_t(parts_)]);
        all.back().damping.zeta /= 2;
      }
    return all;
  }

  CellContent of(int depth, const Cell& cell) const {
    if (!body_.map().is_split(depth, cell)) {
      const BodyConfig& config = body_.config();
      if (config.content_of.empty()) return {PartFill{}};
      return config.contents[config.content_of[config.voxels.index(cell[0] >> depth, cell[1] >> depth,
                                                                   cell[2] >> depth)]];
    }
    CellContent sum;
    for (int c = 0; c < 8; ++c) {
      CellContent part = of(depth + 1, {2 * cell[0] + corner_bit(c, 0), 2 * cell[1] + corner_bit(c, 1),
                                        2 * cell[2] + corner_bit(c, 2)});
      for (PartFill& fill : part) fill.part += by_ratio_ ? parts_ : 0;
      add_eighth(part, sum);
    }
    return sum;
  }

 private:
  const RefinedBody& body_;
  int parts_;
  bool by_ratio_;  ///< whether a part's damping is a ratio, whose viscosity goes with the size of cells
};

std::vector<Cell> cells_of(const RefinedBody& body, int depth) {
  std::vector<Cell> cells;
  if (depth > 0) {
    for (const auto& [i, j, k] : body.map().split_cells(depth - 1))
      for (int c = 0; c < 8; ++c)
        cells.push_back({2 * i + corner_bit(c, 0), 2 * j + corner_bit(c, 1), 2 * k + corner_bit(c, 2)});
    return cells;
  }
  const VoxelGrid& voxels = body.config().voxels;
  for (int k = 0; k < voxels.nz(); ++k)
    for (int j = 0; j < voxels.ny(); ++j)
      for (int i = 0; i < voxels.nx(); ++i)
        if (voxels.at(i, j, k)) cells.push_back({i, j, k});
  return cells;
}

}  // namespace

MergedCells merged_cells(const RefinedBody& body, int depth) {
  const std::vector<Cell> cells = cells_of(body, depth);
  Cell lower = cells.front(), upper = lower;
  for (const Cell& cell : cells)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], cell[axis]);
      upper[axis] = std::max(upper[axis], cell[axis]);
    }
  MergedCells merged{body.config(), lower};
  BodyConfig& config = merged.config;
  const MergedContents contents(body);
  config.cell_size = std::ldexp(config.cell_size, -depth);
  config.origin += config.cell_size * Vec3(lower[0], lower[1], lower[2]);
  config.parts = contents.parts(depth);
  config.springs = config.parts.front().springs;
  config.parts.erase(config.parts.begin());
  config.voxels = VoxelGrid(upper[0] - lower[0] + 1, upper[1] - lower[1] + 1, upper[2] - lower[2] + 1);
  const auto [nx, ny, nz] = config.voxels.size();
  std::vector<CellContent> by_cell(std::size_t(nx) * std::size_t(ny) * std::size_t(nz));
  for (const Cell& cell : cells) {
    const int i = cell[0] - lower[0], j = cell[1] - lower[1], k = cell[2] - lower[2];
    config.voxels.set(i, j, k, true);
    by_cell[config.voxels.index(i, j, k)] = contents.of(depth, cell);
  }
  set_contents(config, by_cell);
  return merged;
}

}  // namespace mss

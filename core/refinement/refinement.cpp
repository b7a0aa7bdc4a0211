#include "core/refinement/refinement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/error.hpp"
#include "core/base/limits.hpp"

namespace mss {

namespace {

using Cell = RefinementMap::Cell;

/// Of a cell.
constexpr double rounding = 1e-9;

bool overlap(const BodyConfig& body, int depth, const Cell& cell, const Box& box) {
  const double edge = std::ldexp(body.cell_size, -depth), margin = rounding * body.cell_size;
  for (int axis = 0; axis < 3; ++axis) {
    const double lower = body.origin[axis] + edge * cell[std::size_t(axis)];
    if (std::min(lower + edge, box.upper[axis]) - std::max(lower, box.lower[axis]) <= margin) return false;
  }
  return true;
}

Cell part(const Cell& cell, int c) {
  return {2 * cell[0] + corner_bit(c, 0), 2 * cell[1] + corner_bit(c, 1), 2 * cell[2] + corner_bit(c, 2)};
}

void split_within(const BodyConfig& body, const RefinedBox& refined, int depth, const Cell& cell,
                  RefinementMap& map) {
  if (depth == refined.levels || !overlap(body, depth, cell, refined.box)) return;
  map.split(depth, cell);
  for (int c = 0; c < 8; ++c) split_within(body, refined, depth + 1, part(cell, c), map);
}

}  // namespace

void RefinementMap::split(int depth, Cell cell) {
  if (split_.size() <= std::size_t(depth)) split_.resize(std::size_t(depth) + 1);
  for (; depth >= 0 && split_[std::size_t(depth)].insert(cell).second; --depth)
    cell = {cell[0] / 2, cell[1] / 2, cell[2] / 2};
}

std::size_t RefinementMap::split_count() const {
  return std::accumulate(split_.begin(), split_.end(), std::size_t{0},
                         [](std::size_t sum, const std::set<Cell>& cells) { return sum + cells.size(); });
}

/// A split cell of depth d needs neighbours of depth d or more all around: they are parts of split cells.
void RefinementMap::balance(const VoxelGrid& voxels) {
  for (int depth = this->depth() - 1; depth > 0; --depth) {
    const std::set<Cell> cells = split_[std::size_t(depth)];
    for (const Cell& cell : cells)
      for (int n = 0; n < 27; ++n) {
        const Cell neighbour{cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1};
        if (mss::has_cell(voxels, depth, neighbour))
          split(depth - 1, {neighbour[0] / 2, neighbour[1] / 2, neighbour[2] / 2});
      }
  }
}

bool has_cell(const VoxelGrid& voxels, int depth, const Cell& cell) {
  return voxels.at(cell[0] >> depth, cell[1] >> depth, cell[2] >> depth);
}

RefinementMap refinement_of(const BodyConfig& body, const std::vector<RefinedBox>& boxes) {
  RefinementMap map;
  for (const RefinedBox& refined : boxes)
    for (int k = 0; k < body.voxels.nz(); ++k)
      for (int j = 0; j < body.voxels.ny(); ++j)
        for (int i = 0; i < body.voxels.nx(); ++i)
          if (body.voxels.at(i, j, k)) {
            split_within(body, refined, 0, {i, j, k}, map);
            if (8 * double(map.split_count()) > most_sites())
              throw InputError(fmt::format(
                  "splits cells into more than {:.0f} million; give a smaller box, or fewer levels",
                  most_sites() / 1e6));
          }
  return map;
}

}  // namespace mss

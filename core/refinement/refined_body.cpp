#include "core/refinement/refined_body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/base/limits.hpp"

namespace mss {

namespace {

using Cell = RefinementMap::Cell;

void check(const BodyConfig& config) {
  if (config.sharing != Sharing::weighted)
    throw InputError(
        "cells of several sizes need springs that they share by weight (sharing = \"weighted\")");
  if (!config.weights.empty())
    throw InputError("weights are for bodies with cells of one size; leave them out, or the refinement");
  for (const CellContent& content : config.contents)
    for (const PartFill& fill : content)
      if (!(fill.fill == CellFill::even(fill.fill.share())))
        throw InputError(
            "cells that a mesh fills are not filled evenly, and only those that are can be split");
}

/// The cells of a depth that are not split, in order.
std::vector<Cell> cells_of(const VoxelGrid& voxels, const RefinementMap& map, int depth) {
  std::vector<Cell> cells;
  const auto add = [&](const Cell& cell) {
    if (!map.is_split(depth, cell)) cells.push_back(cell);
  };
  if (depth == 0) {
    for (int k = 0; k < voxels.nz(); ++k)
      for (int j = 0; j < voxels.ny(); ++j)
        for (int i = 0; i < voxels.nx(); ++i)
          if (voxels.at(i, j, k)) add({i, j, k});
    return cells;
  }
  for (const auto& [i, j, k] : map.split_cells(depth - 1))
    for (int c = 0; c < 8; ++c)
      add({2 * i + corner_bit(c, 0), 2 * j + corner_bit(c, 1), 2 * k + corner_bit(c, 2)});
  return cells;
}

/// The smallest box of cells that contains them: its lower corner and its size.
std::pair<Cell, Cell> bounds(const std::vector<Cell>& cells) {
  Cell lower = cells.front(), upper = lower;
  for (const Cell& cell : cells)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], cell[axis]);
      upper[axis] = std::max(upper[axis], cell[axis]);
    }
  double sites = 1;
  Cell size{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    size[axis] = upper[axis] - lower[axis] + 1;
    sites *= size[axis] + 1;
  }
  if (sites > most_sites())
    throw InputError(fmt::format("makes a lattice of {:.0f} million particles; at most {:.0f} million fit",
                                 sites / 1e6, most_sites() / 1e6));
  return {lower, size};
}

/// The same materials in cells whose edges are half as long, so many times.
void shrink_cells(BodyConfig& config, int depth) {
  const double scale = std::ldexp(1.0, -depth);
  config.cell_size *= scale;
  const auto shrink = [&](SpringConstants& springs) {
    for (double* k : {&springs.edge, &springs.face, &springs.body}) *k *= scale;
  };
  shrink(config.springs);
  for (Part& part : config.parts) shrink(part.springs);
}

/// Site (i, j, k) of a lattice that a particle is at.
Cell indices(const Lattice& lattice, std::ptrdiff_t site) { return lattice.coordinates(site); }

}  // namespace

RefinedBody::RefinedBody(const BodyConfig& config, RefinementMap map)
    : config_(config), map_(std::move(map)) {
  check(config);
  map_.balance(config.voxels);
  for (int depth = 0; depth <= map_.depth(); ++depth) add_level(depth);
  for (std::size_t level = 1; level < levels_.size(); ++level)
    if (depths_[level - 1] + 1 == depths_[level]) find_hanging(level);
  find_masses();
}

void RefinedBody::add_level(int depth) {
  const std::vector<Cell> cells = cells_of(config_.voxels, map_, depth);
  if (cells.empty()) return;
  const auto [corner, size] = bounds(cells);
  BodyConfig level = config_;
  shrink_cells(level, depth);
  level.origin = config_.origin + level.cell_size * Vec3(corner[0], corner[1], corner[2]);
  level.voxels = VoxelGrid(size[0], size[1], size[2]);
  if (!config_.content_of.empty())
    level.content_of.assign(std::size_t(size[0]) * std::size_t(size[1]) * std::size_t(size[2]), 0);
  for (const auto& [i, j, k] : cells) {
    const int x = i - corner[0], y = j - corner[1], z = k - corner[2];
    level.voxels.set(x, y, z, true);
    if (!config_.content_of.empty())
      level.content_of[level.voxels.index(x, y, z)] =
          config_.content_of[config_.voxels.index(i >> depth, j >> depth, k >> depth)];
  }
  const std::ptrdiff_t first =
      levels_.empty() ? 0 : levels_.back().first + levels_.back().body.lattice().size;
  bodies_.push_back(std::make_unique<const Body>(level));
  levels_.push_back({*bodies_.back(), first});
  depths_.push_back(depth);
  corners_.push_back(corner);
}

/// A particle hangs if a cell of the larger ones has it on its surface. Its masters are the corners of the
/// smallest edge or face of theirs that it lies on.
void RefinedBody::find_hanging(std::size_t level) {
  const Body &body = levels_[level].body, &larger = levels_[level - 1].body;
  const Cell &corner = corners_[level], &larger_corner = corners_[level - 1];
  for (const std::ptrdiff_t site : body.sites()) {
    const Cell at = indices(body.lattice(), site);
    Cell first{}, last{}, lowest{}, highest{};  // masters, and the cells that touch all of them
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int half = at[axis] + corner[axis];
      first[axis] = half / 2 - larger_corner[axis];
      last[axis] = (half + 1) / 2 - larger_corner[axis];
      lowest[axis] = last[axis] - 1;
      highest[axis] = first[axis];
    }
    bool hangs = false;
    for (int k = lowest[2]; k <= highest[2]; ++k)
      for (int j = lowest[1]; j <= highest[1]; ++j)
        for (int i = lowest[0]; i <= highest[0]; ++i) hangs = hangs || larger.config().voxels.at(i, j, k);
    if (!hangs) continue;
    HangingParticle particle{.level = level, .site = site, .count = 0};
    for (int k = first[2]; k <= last[2]; ++k)
      for (int j = first[1]; j <= last[1]; ++j)
        for (int i = first[0]; i <= last[0]; ++i)
          particle.masters[particle.count++] = larger.lattice().site(i, j, k);
    hanging_.push_back(particle);
  }
}

void RefinedBody::find_masses() {
  mass_.assign(std::size_t(levels_.back().first + levels_.back().body.lattice().size), 0);
  for (const auto& [body, first] : levels_) {
    total_mass_ += body.total_mass();
    for (const std::ptrdiff_t site : body.sites()) mass_[std::size_t(first + site)] = body.mass(site);
  }
  std::vector<bool> hangs(mass_.size());
  for (const HangingParticle& p : hanging_) {
    double& mass = mass_[std::size_t(site_in_field(p.level, p.site))];
    for (std::size_t m = 0; m < p.count; ++m)
      mass_[std::size_t(site_in_field(p.level - 1, p.masters[m]))] += p.weight() * mass;
    mass = 0;
    hangs[std::size_t(site_in_field(p.level, p.site))] = true;
  }
  for (const auto& [body, first] : levels_)
    for (const std::ptrdiff_t site : body.sites())
      if (!hangs[std::size_t(first + site)]) sites_.push_back(first + site);
}

RefinementMap::Cell RefinedBody::cell(std::size_t level, std::ptrdiff_t site) const {
  Cell cell = indices(levels_[level].body.lattice(), site);
  for (std::size_t axis = 0; axis < 3; ++axis) cell[axis] += corners_[level][axis];
  return cell;
}

std::size_t RefinedBody::cell_count() const {
  std::size_t count = 0;
  for (const Level& level : levels_) count += level.body.cell_count();
  return count;
}

template <class Real>
void RefinedBody::interpolate(Field<Real>& field) const {
  for (const HangingParticle& p : hanging_)
    for (int axis = 0; axis < 3; ++axis) {
      Real* f = field.axis(axis);
      Real sum = 0;
      for (std::size_t m = 0; m < p.count; ++m) sum += f[site_in_field(p.level - 1, p.masters[m])];
      f[site_in_field(p.level, p.site)] = static_cast<Real>(p.weight()) * sum;
    }
}

template <class Real>
void RefinedBody::scatter_to_masters(Field<Real>& forces) const {
  for (const HangingParticle& p : hanging_)
    for (int axis = 0; axis < 3; ++axis) {
      Real* f = forces.axis(axis);
      Real& own = f[site_in_field(p.level, p.site)];
      for (std::size_t m = 0; m < p.count; ++m)
        f[site_in_field(p.level - 1, p.masters[m])] += static_cast<Real>(p.weight()) * own;
      own = 0;
    }
}

template void RefinedBody::interpolate(Field<float>&) const;
template void RefinedBody::interpolate(Field<double>&) const;
template void RefinedBody::scatter_to_masters(Field<float>&) const;
template void RefinedBody::scatter_to_masters(Field<double>&) const;

}  // namespace mss

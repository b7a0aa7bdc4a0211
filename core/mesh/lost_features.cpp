#include "core/mesh/lost_features.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/mesh/inside_samples.hpp"

namespace mss {

namespace {

/// A lost cell has surface further than this from all cells with samples [cells].
constexpr double least_depth = 0.5;

using Cell = std::array<int, 3>;
using Polygon = std::vector<Vec3>;

/// The part of a convex polygon where sign (x_axis - plane) is not negative.
Polygon half_of(const Polygon& polygon, int axis, double plane, double sign) {
  Polygon part;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double da = sign * (a[axis] - plane), db = sign * (b[axis] - plane);
    if (da >= 0) part.push_back(a);
    if ((da < 0) == (db < 0)) continue;
    part.push_back(a + da / (da - db) * (b - a));
    part.back()[axis] = plane;
  }
  return part;
}

/// Calls visit(cell, piece) for the pieces of a polygon in the cells that it meets. Coordinates in cells.
template <class Visit>
void divide(const Polygon& polygon, const SampleGrid& grid, int axis, Cell& cell, Visit&& visit) {
  if (polygon.size() < 3) return;
  if (axis < 0) {
    visit(cell, polygon);
    return;
  }
  const auto along = [axis](const Vec3& x) { return x[axis]; };
  const auto [low, high] = std::ranges::minmax(polygon, {}, along);
  const int last = grid.cells[std::size_t(axis)] - 1;
  const int begin = std::clamp(int(std::floor(low[axis])), 0, last);
  const int end = std::clamp(int(std::ceil(high[axis])) - 1, begin, last);
  Polygon rest = polygon;
  for (int c = begin; c <= end; ++c) {
    cell[std::size_t(axis)] = c;
    divide(c < end ? half_of(rest, axis, c + 1, -1) : rest, grid, axis - 1, cell, visit);
    if (c < end) rest = half_of(rest, axis, c + 1, 1);
  }
}

/// Of the first so many triangles.
template <class Visit>
void for_each_piece(const TriangleMesh& surface, std::size_t triangles, const SampleGrid& grid,
                    Visit&& visit) {
  for (std::size_t t = 0; t < triangles; ++t) {
    Polygon polygon;
    for (const Vec3& x : surface.corners(t)) polygon.push_back((x - grid.origin) / grid.cell_size);
    Cell cell{};
    divide(polygon, grid, 2, cell, visit);
  }
}

/// Calls visit(neighbour) for up to 26 cells around one.
template <class Visit>
void for_each_neighbour(const Cell& cell, const SampleGrid& grid, Visit&& visit) {
  for (int i = 0; i < 27; ++i) {
    const Cell at{cell[0] + i % 3 - 1, cell[1] + i / 3 % 3 - 1, cell[2] + i / 9 - 1};
    bool within = i != 13;
    for (std::size_t a = 0; a < 3; ++a) within &= at[a] >= 0 && at[a] < grid.cells[a];
    if (within) visit(at);
  }
}

/// Distance from a point of an empty cell to the nearest cell with samples [cells]; at most 1.
double depth(const Vec3& x, const Cell& cell, const std::vector<std::uint64_t>& masks,
             const SampleGrid& grid) {
  double least = 1;
  for_each_neighbour(cell, grid, [&](const Cell& at) {
    if (masks[grid.index(at)] == 0) return;
    const Vec3 lower(at[0], at[1], at[2]);
    const Vec3 nearest = x.cwiseMax(lower).cwiseMin(lower + Vec3::Ones());
    least = std::min(least, (x - nearest).norm());
  });
  return least;
}

double area_of(const Polygon& polygon) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    sum += (polygon[i] - polygon[0]).cross(polygon[i + 1] - polygon[0]);
  return sum.norm() / 2;
}

/// The surface in an empty cell. Lengths in cells.
struct Exposed {
  Vec3 lower = Vec3::Constant(1e300);
  Vec3 upper = Vec3::Constant(-1e300);
  double area = 0;
  double depth = 0;
};

std::map<std::size_t, Exposed> lost_cells(const TriangleMesh& surface, std::size_t first_cap,
                                          const std::vector<std::uint64_t>& masks, const SampleGrid& grid) {
  std::map<std::size_t, Exposed> cells;
  for_each_piece(surface, first_cap, grid, [&](const Cell& cell, const Polygon& piece) {
    if (masks[grid.index(cell)] != 0) return;
    double deepest = 0;
    for (const Vec3& x : piece) deepest = std::max(deepest, depth(x, cell, masks, grid));
    if (deepest < 1e-6) return;  // against the face of a filled cell
    Exposed& exposed = cells[grid.index(cell)];
    exposed.area += area_of(piece);
    exposed.depth = std::max(exposed.depth, deepest);
    for (const Vec3& x : piece) {
      exposed.lower = exposed.lower.cwiseMin(x);
      exposed.upper = exposed.upper.cwiseMax(x);
    }
  });
  std::erase_if(cells, [](const auto& cell) { return cell.second.depth <= least_depth; });
  return cells;
}

/// The volume of the solid in every cell [cells], by the divergence theorem: integral of x n_x over the
/// surface, where a cell takes the surface behind it, as seen along x, for its own upper side.
std::vector<double> volumes_in_cells(const TriangleMesh& surface, double orientation,
                                     const SampleGrid& grid) {
  std::vector<double> volume(grid.cell_count()), across(grid.cell_count());
  for_each_piece(surface, surface.triangles.size(), grid, [&](const Cell& cell, const Polygon& piece) {
    for (std::size_t i = 1; i + 1 < piece.size(); ++i) {
      const Vec3 &a = piece[0], &b = piece[i], &c = piece[i + 1];
      const double seen = orientation * (b - a).cross(c - a).x() / 2;  // area as seen along x
      volume[grid.index(cell)] += seen * ((a.x() + b.x() + c.x()) / 3 - cell[0]);
      across[grid.index(cell)] += seen;
    }
  });
  for (std::size_t row = 0; row < volume.size(); row += std::size_t(grid.cells[0])) {
    double behind = 0;
    for (std::size_t i = std::size_t(grid.cells[0]); i-- > 0; behind += across[row + i])
      volume[row + i] += behind;
  }
  return volume;
}

/// Takes the cells that hang together with the first one out of `cells`.
LostFeature take_feature(std::map<std::size_t, Exposed>& cells, const std::vector<double>& volumes,
                         const SampleGrid& grid) {
  const double h = grid.cell_size;
  Exposed all;
  double volume = 0;
  LostFeature feature;
  std::vector<std::pair<std::size_t, Exposed>> next{*cells.begin()};
  cells.erase(cells.begin());
  for (std::size_t n = 0; n < next.size(); ++n) {
    const auto [cell, exposed] = next[n];
    all.lower = all.lower.cwiseMin(exposed.lower);
    all.upper = all.upper.cwiseMax(exposed.upper);
    all.area += exposed.area;
    volume += std::min(volumes[cell], 1.0);
    feature.cells.push_back(cell);
    for_each_neighbour(grid.cell(cell), grid, [&](const Cell& at) {
      const auto found = cells.find(grid.index(at));
      if (found == cells.end()) return;
      next.push_back(*found);
      cells.erase(found);
    });
  }
  std::ranges::sort(feature.cells);
  feature.box = {grid.origin + h * all.lower, grid.origin + h * all.upper};
  feature.area = all.area * h * h;
  feature.volume = volume * h * h * h;
  return feature;
}

}  // namespace

std::vector<LostFeature> find_lost_features(const TriangleMesh& closed_mesh, std::size_t first_cap,
                                            double orientation, const std::vector<std::uint64_t>& masks,
                                            const SampleGrid& grid) {
  std::map<std::size_t, Exposed> cells = lost_cells(closed_mesh, first_cap, masks, grid);
  if (cells.empty()) return {};
  const std::vector<double> volumes = volumes_in_cells(closed_mesh, orientation, grid);
  std::vector<LostFeature> features;
  while (!cells.empty()) features.push_back(take_feature(cells, volumes, grid));
  std::erase_if(features, [&](const LostFeature& f) { return f.volume < -1e-9 * f.area * grid.cell_size; });
  for (LostFeature& feature : features) feature.volume = std::max(feature.volume, 0.0);
  std::ranges::stable_sort(features, std::ranges::greater{}, &LostFeature::volume);
  return features;
}

}  // namespace mss

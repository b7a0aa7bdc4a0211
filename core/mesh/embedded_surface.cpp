#include "core/mesh/embedded_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mss {

namespace {

using Cell = std::array<int, 3>;

double squared_distance(const Vec3& x, const Cell& cell) {
  double sum = 0;
  for (int a = 0; a < 3; ++a) {
    const double low = cell[std::size_t(a)];
    sum += std::pow(x[a] - std::clamp(x[a], low, low + 1), 2);
  }
  return sum;
}

/// The cell that is nearest to a point [cells], by shells of cells around the one that it would be in.
Cell nearest_cell(const VoxelGrid& voxels, const Vec3& x) {
  Cell own{};
  for (int a = 0; a < 3; ++a)
    own[std::size_t(a)] = int(std::clamp(std::floor(x[a]), 0.0, double(voxels.size()[std::size_t(a)] - 1)));
  Cell nearest = own;
  double least = std::numeric_limits<double>::infinity();
  const int most = std::max({voxels.nx(), voxels.ny(), voxels.nz()});
  // a cell of shell r is at least r - 1 cells away along one axis, measured within the lattice
  for (int r = 0; r <= most && (r == 0 || double(r - 1) * (r - 1) <= least); ++r)
    for (int k = own[2] - r; k <= own[2] + r; ++k)
      for (int j = own[1] - r; j <= own[1] + r; ++j) {
        const bool on_side = std::abs(k - own[2]) == r || std::abs(j - own[1]) == r;
        for (int i = own[0] - r; i <= own[0] + r; i += on_side || r == 0 ? 1 : 2 * r) {
          if (!voxels.at(i, j, k)) continue;
          const double distance = squared_distance(x, {i, j, k});
          if (distance >= least) continue;
          least = distance;
          nearest = {i, j, k};
        }
      }
  return nearest;
}

}  // namespace

EmbeddedSurface::EmbeddedSurface(const TriangleMesh& mesh, const VoxelGrid& voxels, double cell_size,
                                 const Vec3& origin)
    : lattice_(voxels.nx(), voxels.ny(), voxels.nz()) {
  points_.reserve(mesh.vertices.size());
  for (const Vec3& vertex : mesh.vertices) {
    const Vec3 x = (vertex - origin) / cell_size;
    const Cell cell = nearest_cell(voxels, x);
    Point point{.site = lattice_.site(cell[0], cell[1], cell[2]), .weights = {}};
    for (unsigned c = 0; c < 8; ++c) {
      double weight = 1;
      for (unsigned a = 0; a < 3; ++a) {
        const double along = x[Eigen::Index(a)] - cell[a];
        weight *= corner_bit(c, a) != 0 ? along : 1 - along;
      }
      point.weights[c] = weight;
    }
    points_.push_back(point);
  }
}

template <class Real>
std::vector<Vec3> EmbeddedSurface::interpolate(const Field<Real>& field) const {
  std::vector<Vec3> values;
  values.reserve(points_.size());
  for (std::size_t v = 0; v < points_.size(); ++v) values.push_back(at(v, field));
  return values;
}

template <class Real>
void EmbeddedSurface::distribute(const std::vector<Vec3>& forces, Field<Real>& particles) const {
  for (std::size_t v = 0; v < points_.size(); ++v)
    if (forces[v] != Vec3::Zero()) distribute(v, forces[v], particles);
}

template std::vector<Vec3> EmbeddedSurface::interpolate(const Field<float>&) const;
template std::vector<Vec3> EmbeddedSurface::interpolate(const Field<double>&) const;
template void EmbeddedSurface::distribute(const std::vector<Vec3>&, Field<float>&) const;
template void EmbeddedSurface::distribute(const std::vector<Vec3>&, Field<double>&) const;

}  // namespace mss

#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/base/field.hpp"
#include "core/base/lattice.hpp"
#include "core/body/voxels.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace mss {

/// The vertices of a surface as points of cells: x = sum_c w_c x_c over the eight corners of the cell that a
/// vertex is in, or of the nearest one, with the trilinear weights of its place at rest. They add up to 1 and
/// reproduce affine maps; outside the cell they extrapolate and may be negative.
class EmbeddedSurface {
 public:
  /// Of cells of size h [m] whose lattice begins at `origin`; there must be at least one.
  EmbeddedSurface(const TriangleMesh& mesh, const VoxelGrid& voxels, double cell_size, const Vec3& origin);

  std::size_t size() const { return points_.size(); }

  /// Value of a field over lattice sites at a vertex: its position, or velocity,
  template <class Real>
  Vec3 at(std::size_t vertex, const Field<Real>& field) const {
    const Point& point = points_[vertex];
    Vec3 value = Vec3::Zero();
    for (int c = 0; c < 8; ++c)
      value += point.weights[std::size_t(c)] * field.at(point.site + lattice_.corner(c));
    return value;
  }
  /// and at all vertices.
  template <class Real>
  std::vector<Vec3> interpolate(const Field<Real>& field) const;

  /// Adds a force on a vertex [N] to the particles of its cell, by the same weights: force and, about any
  /// point, moment are the same, because the vertex is where the weights say.
  template <class Real>
  void distribute(std::size_t vertex, const Vec3& force, Field<Real>& particles) const {
    for (int c = 0; c < 8; ++c) {
      const std::ptrdiff_t site = points_[vertex].site + lattice_.corner(c);
      particles.set(site, particles.at(site) + points_[vertex].weights[std::size_t(c)] * force);
    }
  }
  /// The same for as many forces as vertices.
  template <class Real>
  void distribute(const std::vector<Vec3>& forces, Field<Real>& particles) const;

  /// Lower corner of a vertex's cell.
  std::ptrdiff_t site(std::size_t vertex) const { return points_[vertex].site; }
  const std::array<double, 8>& weights(std::size_t vertex) const { return points_[vertex].weights; }

 private:
  struct Point {
    std::ptrdiff_t site;
    std::array<double, 8> weights;  ///< of corners c = bx + 2 by + 4 bz
  };
  Lattice lattice_;
  std::vector<Point> points_;
};

}  // namespace mss

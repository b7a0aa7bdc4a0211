#pragma once

#include <array>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"
#include "core/mesh/triangle_tree.hpp"

namespace mss {

/// How far a point is from a surface, and the outward direction of length 1 there.
struct SignedDistance {
  double gap = 0;  ///< negative inside [m]
  Vec3 normal = Vec3::UnitZ();
};

/// A closed surface of triangles and how far points are from it. On which side of it a point is, its nearest
/// point says by its pseudonormal: the triangle's normal, of an edge the sum of both triangles', of a vertex
/// the sum of all weighted by their angles there. Baerentzen and Aanaes, IEEE TVCG 11 (2005) 243.
class ClosedSurface {
 public:
  /// Throws InputError, as "is not closed: ..", for a mesh with open edges, or without triangles.
  explicit ClosedSurface(const TriangleMesh& mesh);

  /// Of a point. The direction is that of the way between the nearest point and it, or on the surface the
  /// pseudonormal.
  SignedDistance distance(const Vec3& point) const;

 private:
  Vec3 pseudonormal(std::size_t triangle, const std::array<double, 3>& weights) const;

  TriangleMesh mesh_;
  TriangleTree tree_;
  std::vector<Vec3> of_triangles_, of_vertices_;
  std::vector<std::array<Vec3, 3>> of_edges_;  ///< by triangle, opposite its corners
};

}  // namespace mss

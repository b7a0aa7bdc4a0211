#include "core/mesh/closed_surface.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/base/error.hpp"

namespace mss {

namespace {

TriangleMesh checked(const TriangleMesh& mesh) {
  TriangleMesh merged = merge_identical(mesh);
  if (merged.triangles.empty()) throw InputError("has no triangle; give a closed surface");
  if (const std::size_t open = open_edges(merged).size(); open > 0)
    throw InputError(
        fmt::format("is not closed: {} edges of its triangles have no partner that runs the other way; give "
                    "a closed surface",
                    open));
  return merged;
}

}  // namespace

ClosedSurface::ClosedSurface(const TriangleMesh& mesh)
    : mesh_(checked(mesh)), tree_(mesh_), of_vertices_(mesh_.vertices.size(), Vec3::Zero()) {
  std::map<std::pair<int, int>, Vec3> of_edge;
  const auto edge = [](int a, int b) { return std::pair(std::min(a, b), std::max(a, b)); };
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
    const std::array<int, 3>& triangle = mesh_.triangles[t];
    const std::array<Vec3, 3> corner = mesh_.corners(t);
    const Vec3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]).stableNormalized();
    of_triangles_.push_back(normal);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
      const Vec3 u = corner[j] - corner[i], w = corner[k] - corner[i];
      of_vertices_[std::size_t(triangle[i])] += std::atan2(u.cross(w).norm(), u.dot(w)) * normal;
      of_edge.try_emplace(edge(triangle[j], triangle[k]), Vec3::Zero()).first->second += normal;
    }
  }
  for (const auto& [a, b, c] : mesh_.triangles)
    of_edges_.push_back({of_edge.at(edge(b, c)), of_edge.at(edge(c, a)), of_edge.at(edge(a, b))});
}

/// A weight is 0 where the nearest point is on the edge opposite its corner.
Vec3 ClosedSurface::pseudonormal(std::size_t triangle, const std::array<double, 3>& weights) const {
  for (std::size_t i = 0; i < 3; ++i)
    if (weights[i] == 1) return of_vertices_[std::size_t(mesh_.triangles[triangle][i])];
  for (std::size_t i = 0; i < 3; ++i)
    if (weights[i] == 0) return of_edges_[triangle][i];
  return of_triangles_[triangle];
}

SignedDistance ClosedSurface::distance(const Vec3& point) const {
  const std::size_t triangle = tree_.nearest(point, mesh_.vertices);
  const NearestPoint at = nearest_point(point, mesh_.corners(triangle));
  const Vec3 normal = pseudonormal(triangle, at.weights), off = point - at.at;
  const double distance = off.norm();
  const bool inside = off.dot(normal) < 0;
  // As close as rounding the direction of the way between them is none.
  const double rounding = 1e-12 * (point.norm() + at.at.norm());
  if (distance <= rounding) return {inside ? -distance : distance, normal.stableNormalized()};
  return {inside ? -distance : distance, (inside ? -1 : 1) / distance * off};
}

}  // namespace mss

#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/body/body.hpp"

namespace mss {

/// A surface of triangles [m]. Counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Vec3> vertices;
  std::vector<std::array<int, 3>> triangles;  ///< three indices of vertices each

  /// The three corners of a triangle.
  std::array<Vec3, 3> corners(std::size_t triangle) const {
    const auto& [a, b, c] = triangles[triangle];
    return {vertices[std::size_t(a)], vertices[std::size_t(b)], vertices[std::size_t(c)]};
  }
};

/// How a mesh is placed: x -> R s x + d.
struct Placement {
  double scale = 1;
  Vec3 axis = Vec3::UnitZ();  ///< of the rotation; need not have length 1
  double degrees = 0;
  Vec3 translation = Vec3::Zero();  ///< d [m]
};

void place(TriangleMesh& mesh, const Placement& placement);

/// Vertices of equal coordinates become one, and those of no triangle are dropped.
TriangleMesh merge_identical(const TriangleMesh& mesh);

/// The smallest box with all vertices; of a mesh without vertices the box of the origin.
Box bounding_box(const TriangleMesh& mesh);

/// Vertices inside a box that is widened by `slack` on all sides [m], ascending.
std::vector<std::size_t> vertices_in(const TriangleMesh& mesh, const Box& box, double slack);

/// Triangles with all corners in such a box, ascending.
std::vector<std::size_t> faces_in(const TriangleMesh& mesh, const Box& box, double slack);

/// Distance of a point from a triangle [m].
double distance(const Vec3& point, const std::array<Vec3, 3>& corners);

/// A directed edge of a triangle that has no partner: no triangle runs along it the other way. An edge that
/// k more triangles run along in one direction than in the other appears k times.
struct OpenEdge {
  int from;
  int to;
};
std::vector<OpenEdge> open_edges(const TriangleMesh& mesh);

/// The triangles that close a mesh: every ring of open edges is joined with the mean of its vertices.
/// Together with them, crossings of any line and winding numbers are whole, because no edge lacks its
/// partner. Returns `mesh` with these vertices and triangles added behind its own.
TriangleMesh closed(const TriangleMesh& mesh, const std::vector<OpenEdge>& edges);

/// Triangles whose area is below 1e-12 of the square of their longest edge.
std::size_t zero_faces(const TriangleMesh& mesh);

/// Number of parts that no vertex joins.
std::size_t shells(const TriangleMesh& mesh);

/// sum a . (b x c) / 6 over the triangles [m^3], the divergence theorem; of a closed mesh only. Negative if
/// it is inside out.
double enclosed_volume(const TriangleMesh& mesh);

/// Centre of the volume that a closed mesh encloses [m]; it must not be 0.
Vec3 centroid(const TriangleMesh& mesh);

/// [m^2]
double surface_area(const TriangleMesh& mesh);

}  // namespace mss

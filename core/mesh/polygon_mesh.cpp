#include "core/mesh/polygon_mesh.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"

namespace mss {

namespace {

constexpr double largest_coordinate = 1e15;
constexpr std::size_t most_corners = 1000;

std::string place_of(const PolygonMesh& mesh, std::size_t face) {
  const std::size_t line = mesh.faces[face].line;
  return line > 0 ? fmt::format("line {}: ", line)
                  : fmt::format("face {} of {}: ", face + 1, mesh.faces.size());
}

void check_vertices(const PolygonMesh& mesh) {
  for (const Vec3& x : mesh.vertices)
    if (!(x.cwiseAbs().maxCoeff() <= largest_coordinate) || !x.allFinite())
      throw InputError(
          fmt::format("has a vertex at ({}, {}, {}); give coordinates that are finite and at most 1e15 m",
                      x.x(), x.y(), x.z()));
}

/// Cuts ears off a polygon: corners that are convex, with no other corner in the triangle of their
/// neighbours.
class EarCutter {
 public:
  EarCutter(const std::vector<Vec3>& vertices, std::vector<int> corners)
      : x_(vertices), corners_(std::move(corners)) {
    const Vec3& origin = at(0);
    for (std::size_t i = 1; i + 1 < corners_.size(); ++i)
      normal_ += (at(i) - origin).cross(at(i + 1) - origin);
  }

  void cut(std::vector<std::array<int, 3>>& triangles) {
    for (std::size_t next = 1; corners_.size() > 3;) {
      const std::size_t ear = find_ear(next);
      triangles.push_back({corners_[before(ear)], corners_[ear], corners_[after(ear)]});
      corners_.erase(corners_.begin() + std::ptrdiff_t(ear));
      next = ear % corners_.size();
    }
    triangles.push_back({corners_[0], corners_[1], corners_[2]});
  }

 private:
  const Vec3& at(std::size_t corner) const { return x_[std::size_t(corners_[corner])]; }
  std::size_t before(std::size_t corner) const { return (corner + corners_.size() - 1) % corners_.size(); }
  std::size_t after(std::size_t corner) const { return (corner + 1) % corners_.size(); }

  /// Twice the area of a triangle, seen along the normal.
  double area(const Vec3& a, const Vec3& b, const Vec3& c) const { return (b - a).cross(c - a).dot(normal_); }

  /// The first from a corner on; that corner if there is none, as in polygons that meet themselves.
  std::size_t find_ear(std::size_t from) const {
    for (std::size_t i = 0; i < corners_.size(); ++i)
      if (const std::size_t corner = (from + i) % corners_.size(); is_ear(corner)) return corner;
    return from;
  }

  bool is_ear(std::size_t corner) const {
    const Vec3 &a = at(before(corner)), &b = at(corner), &c = at(after(corner));
    if (!(area(a, b, c) > 0)) return false;
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const Vec3& p = at(i);
      if (p == a || p == b || p == c) continue;
      if (area(a, b, p) >= 0 && area(b, c, p) >= 0 && area(c, a, p) >= 0) return false;
    }
    return true;
  }

  const std::vector<Vec3>& x_;
  std::vector<int> corners_;
  Vec3 normal_ = Vec3::Zero();
};

std::vector<int> checked_corners(const PolygonMesh& mesh, std::size_t face, std::size_t begin) {
  const std::size_t end = mesh.faces[face].end;
  if (end - begin > most_corners)
    throw InputError(fmt::format("{}a face of {} corners; at most {} are read, divide it into triangles",
                                 place_of(mesh, face), end - begin, most_corners));
  std::vector<int> corners;
  for (std::size_t i = begin; i < end; ++i) {
    const std::int64_t corner = mesh.corners[i];
    if (corner < 0 || corner >= std::int64_t(mesh.vertices.size()))
      throw InputError(fmt::format("{}has a face with vertex {}, but {} vertices; export the mesh again",
                                   place_of(mesh, face), corner + (mesh.faces[face].line > 0 ? 1 : 0),
                                   mesh.vertices.size()));
    corners.push_back(int(corner));
  }
  return corners;
}

}  // namespace

std::size_t short_faces(const PolygonMesh& mesh) {
  std::size_t count = 0, begin = 0;
  for (const PolygonMesh::Face& face : mesh.faces) {
    if (face.end - begin < 3) ++count;
    begin = face.end;
  }
  return count;
}

TriangleMesh triangles_of(const PolygonMesh& mesh) {
  check_vertices(mesh);
  TriangleMesh result{.vertices = mesh.vertices, .triangles = {}};
  result.triangles.reserve(mesh.faces.size());
  std::size_t begin = 0;
  for (std::size_t face = 0; face < mesh.faces.size(); begin = mesh.faces[face++].end)
    if (std::vector<int> corners = checked_corners(mesh, face, begin); corners.size() >= 3)
      EarCutter(mesh.vertices, std::move(corners)).cut(result.triangles);
  return result;
}

}  // namespace mss

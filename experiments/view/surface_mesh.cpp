#include "experiments/view/surface_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

namespace mss::view {

namespace {

/// One of the six directions of a face.
struct Direction {
  int axis;
  int side;  ///< 0: down the axis, 1: up
};

/// Corners c = bx + 2 by + 4 bz of a cell's face, counter-clockwise as seen from outside.
std::array<int, 4> face_corners(Direction d) {
  const int base = d.side << d.axis, u = 1 << (d.axis + 1) % 3, w = 1 << (d.axis + 2) % 3;
  if (d.side == 1) return {base, base + u, base + u + w, base + w};
  return {base, base + w, base + u + w, base + u};
}

std::array<float, 3> to_array(const Vec3& v) { return {float(v[0]), float(v[1]), float(v[2])}; }

void add(std::array<float, 3>& sum, const Vec3& v) {
  for (std::size_t a = 0; a < 3; ++a) sum[a] += float(v[Eigen::Index(a)]);
}

/// How far along a ray a triangle is met (Moeller and Trumbore, 1997).
std::optional<double> meet(const Ray& ray, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 p = ray.direction.cross(c - a), from_a = ray.origin - a;
  const double determinant = p.dot(b - a);
  if (determinant == 0) return std::nullopt;
  const Vec3 q = from_a.cross(b - a);
  const double u = from_a.dot(p) / determinant, v = ray.direction.dot(q) / determinant;
  const double distance = q.dot(c - a) / determinant;
  if (u < 0 || v < 0 || u + v > 1 || distance <= 0) return std::nullopt;
  return distance;
}

}  // namespace

SurfaceMesh::SurfaceMesh(const Body& body) {
  add_faces(body);
  add_triangles();
  sites_ = corner_site_;
  std::sort(sites_.begin(), sites_.end());
  sites_.erase(std::unique(sites_.begin(), sites_.end()), sites_.end());
  for (const std::ptrdiff_t site : corner_site_)
    corner_entry_.push_back(
        std::size_t(std::lower_bound(sites_.begin(), sites_.end(), site) - sites_.begin()));
  Field<double> rest(body.lattice().size);
  for (const std::ptrdiff_t site : sites_) rest.set(site, body.rest_position(site));
  update(rest, std::vector<float>(sites_.size(), 0.0F));
}

void SurfaceMesh::add_faces(const Body& body) {
  const VoxelGrid& voxels = body.config().voxels;
  std::map<std::pair<std::ptrdiff_t, int>, std::uint32_t> vertex_of;  // by site and direction
  const auto add_face = [&](const std::array<int, 3>& cell, Direction d) {
    Face face{};
    const std::array<int, 4> corners = face_corners(d);
    for (std::size_t i = 0; i < 4; ++i) {
      std::array<int, 3> at = cell;
      for (std::size_t axis = 0; axis < 3; ++axis) at[axis] += (corners[i] >> axis) & 1;
      const std::ptrdiff_t site = body.lattice().site(at[0], at[1], at[2]);
      const auto [entry, is_new] =
          vertex_of.try_emplace({site, 2 * d.axis + d.side}, std::uint32_t(corner_site_.size()));
      if (is_new) {
        corner_site_.push_back(site);
        const auto u = std::size_t(d.axis + 1) % 3, w = std::size_t(d.axis + 2) % 3;
        vertices_.push_back({.cells = {float(at[u]), float(at[w])}});
      }
      face[i] = entry->second;
    }
    faces_.push_back(face);
  };
  for (int k = 0; k < voxels.nz(); ++k)
    for (int j = 0; j < voxels.ny(); ++j)
      for (int i = 0; i < voxels.nx(); ++i)
        for (int axis = 0; voxels.at(i, j, k) && axis < 3; ++axis)
          for (const int side : {0, 1}) {
            std::array<int, 3> next{i, j, k};
            next[std::size_t(axis)] += 2 * side - 1;
            if (!voxels.at(next[0], next[1], next[2])) add_face({i, j, k}, {axis, side});
          }
}

void SurfaceMesh::add_triangles() {
  for (const Face& face : faces_) {
    const auto middle = std::uint32_t(vertices_.size());
    const std::array<float, 2>&from = vertices_[face[0]].cells, &to = vertices_[face[2]].cells;
    vertices_.push_back({.cells = {(from[0] + to[0]) / 2, (from[1] + to[1]) / 2}});
    for (std::size_t side = 0; side < 4; ++side)
      triangles_.insert(triangles_.end(), {face[side], face[(side + 1) % 4], middle});
  }
}

Vec3 SurfaceMesh::position(std::uint32_t vertex) const {
  const auto& p = vertices_[vertex].position;
  return {p[0], p[1], p[2]};
}

void SurfaceMesh::update(const Field<double>& x, const std::vector<float>& values) {
  const auto put = [](SurfaceVertex& vertex, const Vec3& position, const Vec3& normal, float value) {
    vertex.position = to_array(position);
    vertex.normal = to_array(normal);
    vertex.value = value;
  };
  for (std::size_t v = 0; v < corner_site_.size(); ++v)
    put(vertices_[v], x.at(corner_site_[v]), Vec3::Zero(), values[corner_entry_[v]]);
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    const auto& [a, b, c, d] = faces_[f];
    const auto at = [&](std::uint32_t vertex) { return x.at(corner_site_[vertex]); };
    const Vec3 area = (at(c) - at(a)).cross(at(d) - at(b)) / 2;
    SurfaceVertex& middle = vertices_[centre(f)];
    put(middle, (at(a) + at(b) + at(c) + at(d)) / 4, area, 0);
    for (const std::uint32_t corner : faces_[f]) {
      middle.value += vertices_[corner].value / 4;
      add(vertices_[corner].normal, area);
    }
  }
  for (SurfaceVertex& vertex : vertices_) {
    const Vec3 sum(vertex.normal[0], vertex.normal[1], vertex.normal[2]);
    vertex.normal = to_array(sum.stableNormalized());  // of two faces folded onto each other: as it is, 0
  }
}

double SurfaceMesh::volume() const {
  double six_fold = 0;
  const Vec3 origin = position(0);  // near the body: less is lost to cancellation
  for (std::size_t i = 0; i < triangles_.size(); i += 3)
    six_fold += (position(triangles_[i]) - origin)
                    .dot((position(triangles_[i + 1]) - origin).cross(position(triangles_[i + 2]) - origin));
  return six_fold / 6;
}

std::optional<SurfaceMesh::Hit> SurfaceMesh::hit(const Ray& ray) const {
  std::optional<Hit> first;
  for (std::size_t i = 0; i < triangles_.size(); i += 3) {
    const auto distance =
        meet(ray, position(triangles_[i]), position(triangles_[i + 1]), position(triangles_[i + 2]));
    if (!distance || (first && *distance >= first->distance)) continue;
    const Vec3 point = ray.origin + *distance * ray.direction;
    const auto away = [&](std::uint32_t vertex) { return (position(vertex) - point).squaredNorm(); };
    const bool second_nearer = away(triangles_[i + 1]) < away(triangles_[i]);
    first = Hit{corner_site_[triangles_[second_nearer ? i + 1 : i]], *distance};
  }
  return first;
}

}  // namespace mss::view

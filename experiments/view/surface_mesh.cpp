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

/// Whether a cell of another size is behind a face: all of it or nothing is covered, by larger cells or by
/// ones half as large.
bool has_other_cell(const std::vector<Level>& levels, const Level& level, const std::array<int, 3>& cell,
                    Direction d) {
  Vec3 behind = level.body.rest_position(level.body.lattice().site(cell[0], cell[1], cell[2]));
  const double size = level.body.config().cell_size;
  behind += Vec3::Constant(size / 4);
  behind[d.axis] += (d.side == 1 ? 1 : -0.5) * size;
  return std::any_of(levels.begin(), levels.end(), [&](const Level& other) {
    const BodyConfig& config = other.body.config();
    const Vec3 at = ((behind - config.origin) / config.cell_size).array().floor();
    return config.voxels.at(int(at[0]), int(at[1]), int(at[2]));
  });
}

}  // namespace

SurfaceMesh::SurfaceMesh(const std::vector<Level>& levels) {
  for (const Level& level : levels) add_faces(levels, level);
  add_triangles();
  corner_entry_ = collect_sites(corner_site_);
  Field<double> rest(levels.back().first + levels.back().body.lattice().size);
  for (const auto& [body, first] : levels)
    for (const std::ptrdiff_t site : body.sites()) rest.set(first + site, body.rest_position(site));
  update(rest, std::vector<float>(sites_.size(), 0.0F));
}

void SurfaceMesh::add_faces(const std::vector<Level>& levels, const Level& level) {
  const Body& body = level.body;
  const VoxelGrid& voxels = body.config().voxels;
  std::map<std::pair<std::ptrdiff_t, int>, std::uint32_t> vertex_of;  // by site and direction
  const auto add_face = [&](const std::array<int, 3>& cell, Direction d) {
    Face face{};
    const std::array<int, 4> corners = face_corners(d);
    for (std::size_t i = 0; i < 4; ++i) {
      std::array<int, 3> at = cell;
      for (std::size_t axis = 0; axis < 3; ++axis) at[axis] += (corners[i] >> axis) & 1;
      const std::ptrdiff_t site = level.first + body.lattice().site(at[0], at[1], at[2]);
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
            if (!voxels.at(next[0], next[1], next[2]) &&
                !has_other_cell(levels, level, {i, j, k}, {axis, side}))
              add_face({i, j, k}, {axis, side});
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
  normalise();
}

std::ptrdiff_t SurfaceMesh::site_at(std::size_t triangle, const Vec3& point) const {
  const std::uint32_t first = triangles_[triangle], second = triangles_[triangle + 1];
  return corner_site_[distance(second, point) < distance(first, point) ? second : first];
}

}  // namespace mss::view

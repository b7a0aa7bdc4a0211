#include "experiments/view/surface_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <tuple>

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

CrossSection::CrossSection(const Body& body) : body_(body.config()) {
  constexpr double thinnest = 1.0 / 300;
  const BodyConfig& config = body.config();
  const auto [nx, ny, nz] = config.voxels.size();
  half_ = std::max(config.across(), thinnest * config.cell_size * std::max({nx, ny, nz})) / 2;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if ((config.voxels.flat_axes() >> axis & 1) != 0)
      sides_[axis].resize(body.particle_count(), Vec3::Unit(Eigen::Index(axis)));
}

void CrossSection::update(const Field<double>& x) {
  const int flat_axes = body_.config().voxels.flat_axes(), other = 7 & ~flat_axes;
  const bool is_rope = body_.config().voxels.dimensions() == 1;
  const int along = other == 1 ? 0 : other == 2 ? 1 : 2;
  for (std::size_t p = 0; p < body_.particle_count(); ++p) {
    const std::ptrdiff_t site = body_.sites()[p];
    const auto turn =
        is_rope ? Eigen::Quaterniond::FromTwoVectors(Vec3::Unit(along), tangent_of_rope(site, along, x))
                : Eigen::Quaterniond::Identity();
    for (int axis = 0; axis < 3; ++axis)
      if (!sides_[std::size_t(axis)].empty())
        sides_[std::size_t(axis)][p] = is_rope ? turn * Vec3::Unit(axis) : normal_of_sheet(site, axis, x);
  }
}

/// Of the squares at a particle, by their areas.
Vec3 CrossSection::normal_of_sheet(std::ptrdiff_t site, int flat, const Field<double>& x) const {
  const std::array<int, 2> axes{(flat + 1) % 3, (flat + 2) % 3};
  const auto [i, j, k] = body_.lattice().coordinates(site);
  const std::array<int, 3> at{i, j, k};
  Vec3 sum = Vec3::Zero();
  for (const int c : body_.corners()) {
    std::array<int, 3> cell = at;
    for (int axis = 0; axis < 3; ++axis) cell[std::size_t(axis)] -= corner_bit(c, axis);
    if (!body_.config().voxels.at(cell[0], cell[1], cell[2])) continue;
    const std::ptrdiff_t lower = site - body_.lattice().corner(c);
    const auto corner = [&](int u, int w) {
      return x.at(lower + body_.lattice().corner((u << axes[0]) + (w << axes[1])));
    };
    sum += (corner(1, 1) - corner(0, 0)).cross(corner(0, 1) - corner(1, 0));
  }
  return sum.stableNormalized();
}

Vec3 CrossSection::tangent_of_rope(std::ptrdiff_t site, int along, const Field<double>& x) const {
  const std::ptrdiff_t step = body_.lattice().corner(1 << along);
  const auto at = [&](std::ptrdiff_t other) {
    const bool exists = other >= 0 && other < body_.lattice().sites && body_.particle(other) >= 0;
    return x.at(exists ? other : site);
  };
  const Vec3 tangent = at(site + step) - at(site - step);
  return tangent.isZero(0) ? Vec3(Vec3::Unit(along)) : tangent;
}

Vec3 CrossSection::to_corner(std::ptrdiff_t site, int corner) const {
  const auto particle = std::size_t(body_.particle(site));
  Vec3 sum = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis)
    if (const std::vector<Vec3>& side = sides_[std::size_t(axis)]; !side.empty())
      sum += half_ * corner_sign(corner, axis) * side[particle];
  return sum;
}

SurfaceMesh::SurfaceMesh(const std::vector<Level>& levels) {
  if (const Body& body = levels.front().body; !body.config().is_solid()) section_.emplace(body);
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
  const int flat = voxels.flat_axes();
  // By site, direction, and side along flat axes.
  std::map<std::tuple<std::ptrdiff_t, int, int>, std::uint32_t> vertex_of;
  const auto add_face = [&](const std::array<int, 3>& cell, Direction d) {
    Face face{};
    const std::array<int, 4> corners = face_corners(d);
    for (std::size_t i = 0; i < 4; ++i) {
      std::array<int, 3> at = cell;
      for (int axis = 0; axis < 3; ++axis) at[std::size_t(axis)] += corner_bit(corners[i] & ~flat, axis);
      const std::ptrdiff_t site = level.first + body.lattice().site(at[0], at[1], at[2]);
      const auto [entry, is_new] = vertex_of.try_emplace({site, 2 * d.axis + d.side, corners[i] & flat},
                                                         std::uint32_t(corner_site_.size()));
      if (is_new) {
        corner_site_.push_back(site);
        corner_of_cell_.push_back(corners[i]);
        const auto u = std::size_t(d.axis + 1) % 3, w = std::size_t(d.axis + 2) % 3;
        const auto in_cells = [&](std::size_t across) {
          return float(cell[across] + corner_bit(corners[i], int(across)));
        };
        vertices_.push_back({.cells = {in_cells(u), in_cells(w)}});
      }
      face[i] = entry->second;
    }
    faces_.push_back(face);
  };
  voxels.for_each_place([&](int i, int j, int k) {
    for (int axis = 0; voxels.at(i, j, k) && axis < 3; ++axis)
      for (const int side : {0, 1}) {
        std::array<int, 3> next{i, j, k};
        next[std::size_t(axis)] += 2 * side - 1;
        if ((flat >> axis & 1) != 0 || (!voxels.at(next[0], next[1], next[2]) &&
                                        !has_other_cell(levels, level, {i, j, k}, {axis, side})))
          add_face({i, j, k}, {axis, side});
      }
  });
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
  if (section_) section_->update(x);
  const auto at = [&](std::uint32_t v) -> Vec3 {
    const Vec3 middle = x.at(corner_site_[v]);
    return section_ ? Vec3(middle + section_->to_corner(corner_site_[v], corner_of_cell_[v])) : middle;
  };
  for (std::uint32_t v = 0; v < corner_site_.size(); ++v)
    put(vertices_[v], at(v), Vec3::Zero(), values[corner_entry_[v]]);
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    const auto& [a, b, c, d] = faces_[f];
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

std::optional<DrawnSurface::Motion> SurfaceMesh::motion() const {
  if (section_) return std::nullopt;
  Motion motion;
  motion.shares.resize(vertices_.size());
  motion.faces_at.resize(vertices_.size());
  for (std::size_t v = 0; v < corner_entry_.size(); ++v) motion.shares[v] = {{corner_entry_[v], 1}};
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    motion.faces.push_back(faces_[f]);
    motion.faces_at[centre(f)] = {std::uint32_t(f)};
    for (const std::uint32_t corner : faces_[f]) {
      motion.shares[centre(f)].push_back({corner_entry_[corner], 0.25});
      motion.faces_at[corner].push_back(std::uint32_t(f));
    }
  }
  return motion;
}

std::ptrdiff_t SurfaceMesh::site_at(std::size_t triangle, const Vec3& point) const {
  const std::uint32_t first = triangles_[triangle], second = triangles_[triangle + 1];
  return corner_site_[distance(second, point) < distance(first, point) ? second : first];
}

}  // namespace mss::view

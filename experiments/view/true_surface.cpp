#include "experiments/view/true_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace mss::view {

TrueSurface::TrueSurface(const TriangleMesh& mesh, const Body& body)
    : surface_(mesh, body.config().voxels, body.config().cell_size, body.config().origin),
      lattice_(body.lattice()) {
  divide_at_edges(mesh);
  std::vector<std::ptrdiff_t> corners;
  for (std::size_t point = 0; point < surface_.size(); ++point)
    for (int c = 0; c < 8; ++c) corners.push_back(surface_.site(point) + lattice_.corner(c));
  entry_ = collect_sites(corners);
  Field<double> rest(lattice_.size);
  for (const std::ptrdiff_t site : sites_) rest.set(site, body.rest_position(site));
  update(rest, std::vector<float>(sites_.size(), 0.0F));
}

/// A triangle shares a vertex with the first one there whose normal is near its own.
void TrueSurface::divide_at_edges(const TriangleMesh& mesh) {
  constexpr double least_cosine = 0.5;
  struct Copy {
    Vec3 normal;
    std::uint32_t vertex;
  };
  std::vector<std::vector<Copy>> copies(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.corners(t);
    const Vec3 normal = (b - a).cross(c - a).stableNormalized();
    for (const int point : mesh.triangles[t]) {
      std::vector<Copy>& known = copies[std::size_t(point)];
      auto copy = std::find_if(known.begin(), known.end(),
                               [&](const Copy& k) { return k.normal.dot(normal) > least_cosine; });
      if (copy == known.end()) {
        copy = known.insert(known.end(), {normal, std::uint32_t(vertices_.size())});
        vertices_.emplace_back();
        point_of_.push_back(std::uint32_t(point));
      }
      triangles_.push_back(copy->vertex);
    }
  }
}

float TrueSurface::value_of(std::size_t point, const std::vector<float>& values) const {
  double sum = 0;
  for (std::size_t c = 0; c < 8; ++c)
    sum += surface_.weights(point)[c] * double(values[entry_[8 * point + c]]);
  return float(sum);
}

void TrueSurface::update(const Field<double>& x, const std::vector<float>& values) {
  const std::vector<Vec3> points = surface_.interpolate(x);
  for (std::size_t v = 0; v < vertices_.size(); ++v)
    vertices_[v] = {.position = to_array(points[point_of_[v]]), .value = value_of(point_of_[v], values)};
  for (std::size_t i = 0; i < triangles_.size(); i += 3) {
    const auto at = [&](std::size_t corner) { return points[point_of_[triangles_[i + corner]]]; };
    const Vec3 area = (at(1) - at(0)).cross(at(2) - at(0)) / 2;
    for (std::size_t corner = 0; corner < 3; ++corner) add(vertices_[triangles_[i + corner]].normal, area);
  }
  normalise();
}

std::optional<DrawnSurface::Motion> TrueSurface::motion() const {
  Motion motion;
  motion.shares.resize(vertices_.size());
  motion.faces_at.resize(vertices_.size());
  for (std::size_t v = 0; v < vertices_.size(); ++v)
    for (std::size_t c = 0; c < 8; ++c)
      motion.shares[v].push_back(
          {entry_[8 * std::size_t(point_of_[v]) + c], surface_.weights(point_of_[v])[c]});
  for (std::size_t i = 0; i < triangles_.size(); i += 3) {
    for (std::size_t corner = i; corner < i + 3; ++corner)
      motion.faces_at[triangles_[corner]].push_back(std::uint32_t(motion.faces.size()));
    motion.faces.push_back({triangles_[i], triangles_[i + 1], triangles_[i + 2], triangles_[i + 2]});
  }
  return motion;
}

std::ptrdiff_t TrueSurface::site_at(std::size_t triangle, const Vec3& point) const {
  const auto first = triangles_.begin() + std::ptrdiff_t(triangle);
  const std::uint32_t nearest = *std::min_element(first, first + 3, [&](std::uint32_t a, std::uint32_t b) {
    return distance(a, point) < distance(b, point);
  });
  const std::array<double, 8>& weights = surface_.weights(point_of_[nearest]);
  const auto corner = std::max_element(weights.begin(), weights.end()) - weights.begin();
  return surface_.site(point_of_[nearest]) + lattice_.corner(int(corner));
}

}  // namespace mss::view

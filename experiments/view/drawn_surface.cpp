#include "experiments/view/drawn_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace mss::view {

namespace {

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

std::array<float, 3> to_array(const Vec3& v) { return {float(v[0]), float(v[1]), float(v[2])}; }

void add(std::array<float, 3>& sum, const Vec3& v) {
  for (std::size_t a = 0; a < 3; ++a) sum[a] += float(v[Eigen::Index(a)]);
}

Vec3 DrawnSurface::position(std::uint32_t vertex) const {
  const auto& p = vertices_[vertex].position;
  return {p[0], p[1], p[2]};
}

std::vector<std::size_t> DrawnSurface::collect_sites(const std::vector<std::ptrdiff_t>& all) {
  sites_ = all;
  std::sort(sites_.begin(), sites_.end());
  sites_.erase(std::unique(sites_.begin(), sites_.end()), sites_.end());
  std::vector<std::size_t> places;
  places.reserve(all.size());
  for (const std::ptrdiff_t site : all)
    places.push_back(std::size_t(std::lower_bound(sites_.begin(), sites_.end(), site) - sites_.begin()));
  return places;
}

void DrawnSurface::normalise() {
  for (SurfaceVertex& vertex : vertices_) {
    const Vec3 sum(vertex.normal[0], vertex.normal[1], vertex.normal[2]);
    vertex.normal = to_array(sum.stableNormalized());  // of two faces folded onto each other: as it is, 0
  }
}

double DrawnSurface::volume() const {
  double six_fold = 0;
  const Vec3 origin = position(0);  // near the body: less is lost to cancellation
  for (std::size_t i = 0; i < triangles_.size(); i += 3)
    six_fold += (position(triangles_[i]) - origin)
                    .dot((position(triangles_[i + 1]) - origin).cross(position(triangles_[i + 2]) - origin));
  return six_fold / 6;
}

std::optional<DrawnSurface::Hit> DrawnSurface::hit(const Ray& ray) const {
  std::optional<double> first;
  std::size_t triangle = 0;
  for (std::size_t i = 0; i < triangles_.size(); i += 3) {
    const auto distance =
        meet(ray, position(triangles_[i]), position(triangles_[i + 1]), position(triangles_[i + 2]));
    if (!distance || (first && *distance >= *first)) continue;
    first = distance;
    triangle = i;
  }
  if (!first) return std::nullopt;
  return Hit{site_at(triangle, ray.origin + *first * ray.direction), *first};
}

}  // namespace mss::view

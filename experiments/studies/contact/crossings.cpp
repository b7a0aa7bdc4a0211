// Whether a surface goes through itself.
#include "experiments/studies/contact/crossings.hpp"

#include <Eigen/Geometry>

namespace mss::studies::contact {

namespace {

double volume_of(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return (b - a).cross(c - a).dot(d - a);
}

std::vector<Vec3> moved_inwards(const TriangleMesh& mesh, const std::vector<Vec3>& vertices, double by) {
  std::vector<Vec3> outwards(vertices.size(), Vec3::Zero());
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3& corner = vertices[std::size_t(a)];
    const Vec3 area = (vertices[std::size_t(b)] - corner).cross(vertices[std::size_t(c)] - corner);
    for (const int v : {a, b, c}) outwards[std::size_t(v)] += area;
  }
  std::vector<Vec3> moved = vertices;
  for (std::size_t v = 0; v < moved.size(); ++v) moved[v] -= by * outwards[v].stableNormalized();
  return moved;
}

std::array<Vec3, 3> corners_at(const TriangleMesh& mesh, std::size_t triangle,
                               const std::vector<Vec3>& vertices) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return {vertices[std::size_t(a)], vertices[std::size_t(b)], vertices[std::size_t(c)]};
}

bool are_apart(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
  const auto lower = [](const auto& t) { return Vec3(t[0].cwiseMin(t[1]).cwiseMin(t[2])); };
  const auto upper = [](const auto& t) { return Vec3(t[0].cwiseMax(t[1]).cwiseMax(t[2])); };
  return ((lower(a) - upper(b)).array() > 0).any() || ((lower(b) - upper(a)).array() > 0).any();
}

bool have_edge_through(const std::array<Vec3, 3>& edges_of, const std::array<Vec3, 3>& triangle) {
  return goes_through(edges_of[0], edges_of[1], triangle) ||
         goes_through(edges_of[1], edges_of[2], triangle) || goes_through(edges_of[2], edges_of[0], triangle);
}

/// By their corners.
double distance_between(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
  double least = (a[0] - b[0]).norm();
  for (const Vec3& of_a : a)
    for (const Vec3& of_b : b) least = std::min(least, (of_a - of_b).norm());
  return least;
}

}  // namespace

bool goes_through(const Vec3& from, const Vec3& to, const std::array<Vec3, 3>& triangle) {
  const auto& [a, b, c] = triangle;
  if (volume_of(a, b, c, from) * volume_of(a, b, c, to) >= 0) return false;
  const double u = volume_of(from, to, a, b), v = volume_of(from, to, b, c), w = volume_of(from, to, c, a);
  return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}

std::size_t crossings(const TriangleMesh& rest, const std::vector<Vec3>& vertices, double neighbours,
                      double inset) {
  const std::vector<Vec3> inside = moved_inwards(rest, vertices, inset);
  std::size_t count = 0;
  for (std::size_t s = 0; s < rest.triangles.size(); ++s) {
    const std::array<Vec3, 3> a = corners_at(rest, s, inside);
    for (std::size_t t = 0; t < s; ++t) {
      const std::array<Vec3, 3> b = corners_at(rest, t, inside);
      if (are_apart(a, b) || distance_between(rest.corners(s), rest.corners(t)) <= neighbours) continue;
      if (have_edge_through(a, b) || have_edge_through(b, a)) ++count;
    }
  }
  return count;
}

}  // namespace mss::studies::contact

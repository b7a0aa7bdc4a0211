#include "core/mesh/triangle_mesh.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <numeric>
#include <tuple>
#include <utility>

namespace mss {

namespace {

/// Sets of numbers that are joined step by step.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }

  int find(int i) {
    while (parent_[std::size_t(i)] != i) {
      parent_[std::size_t(i)] = parent_[std::size_t(parent_[std::size_t(i)])];
      i = parent_[std::size_t(i)];
    }
    return i;
  }
  void join(int i, int j) { parent_[std::size_t(find(i))] = find(j); }

 private:
  std::vector<int> parent_;
};

/// An edge as one number: the smaller index, the larger, and the direction.
std::uint64_t edge_key(int from, int to) {
  const auto low = std::uint64_t(std::min(from, to));
  const auto high = std::uint64_t(std::max(from, to));
  return low << 32 | high << 1 | std::uint64_t(from > to);
}

std::vector<std::uint64_t> sorted_edges(const TriangleMesh& mesh) {
  std::vector<std::uint64_t> keys;
  keys.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles)
    for (std::size_t c = 0; c < 3; ++c) {
      const int from = t[c];
      const int to = t[(c + 1) % 3];
      if (from != to) keys.push_back(edge_key(from, to));
    }
  std::sort(keys.begin(), keys.end());
  return keys;
}

}  // namespace

void place(TriangleMesh& mesh, const Placement& placement) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(placement.degrees * std::numbers::pi / 180, placement.axis.stableNormalized())
          .toRotationMatrix();
  for (Vec3& x : mesh.vertices) x = turn * (placement.scale * x) + placement.translation;
}

TriangleMesh merge_identical(const TriangleMesh& mesh) {
  const auto& x = mesh.vertices;
  std::vector<int> used;
  used.reserve(x.size());
  std::vector<int> merged(x.size(), -1);
  for (const auto& t : mesh.triangles)
    for (const int v : t)
      if (std::exchange(merged[std::size_t(v)], 0) < 0) used.push_back(v);
  const auto key = [&](int v) {
    const Vec3& p = x[std::size_t(v)];
    return std::tuple(p.x(), p.y(), p.z());
  };
  // in the order of coordinates, then of the file
  std::sort(used.begin(), used.end(),
            [&](int a, int b) { return std::tuple(key(a), a) < std::tuple(key(b), b); });
  std::vector<int> first = used;  // of the vertices equal to each
  for (std::size_t i = 1; i < used.size(); ++i)
    if (key(used[i]) == key(used[i - 1])) first[i] = first[i - 1];
  for (std::size_t i = 0; i < used.size(); ++i) merged[std::size_t(used[i])] = first[i];

  TriangleMesh result;
  std::vector<int> place_of(x.size(), -1);
  for (std::size_t v = 0; v < x.size(); ++v)
    if (merged[v] == int(v)) {
      place_of[v] = int(result.vertices.size());
      result.vertices.push_back(x[v]);
    }
  result.triangles = mesh.triangles;
  for (auto& t : result.triangles)
    for (int& v : t) v = place_of[std::size_t(merged[std::size_t(v)])];
  return result;
}

Box bounding_box(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return {};
  Box box{mesh.vertices.front(), mesh.vertices.front()};
  for (const Vec3& x : mesh.vertices) {
    box.lower = box.lower.cwiseMin(x);
    box.upper = box.upper.cwiseMax(x);
  }
  return box;
}

std::vector<std::size_t> vertices_in(const TriangleMesh& mesh, const Box& box, double slack) {
  std::vector<std::size_t> inside;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    const auto x = mesh.vertices[v].array();
    if ((x >= box.lower.array() - slack).all() && (x <= box.upper.array() + slack).all()) inside.push_back(v);
  }
  return inside;
}

std::vector<std::size_t> faces_in(const TriangleMesh& mesh, const Box& box, double slack) {
  std::vector<bool> inside(mesh.vertices.size());
  for (const std::size_t vertex : vertices_in(mesh, box, slack)) inside[vertex] = true;
  std::vector<std::size_t> faces;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& corners = mesh.triangles[t];
    if (std::all_of(corners.begin(), corners.end(), [&](int v) { return inside[std::size_t(v)]; }))
      faces.push_back(t);
  }
  return faces;
}

/// Of the plane where the point is above the triangle, else of the nearest of its edges.
double distance(const Vec3& point, const std::array<Vec3, 3>& corners) {
  const Vec3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  double nearest = std::numeric_limits<double>::infinity();
  bool above = normal.squaredNorm() > 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 edge = corners[(i + 1) % 3] - corners[i], arm = point - corners[i];
    if (normal.cross(edge).dot(arm) < 0) above = false;
    const double length2 = edge.squaredNorm();
    const double along = length2 > 0 ? std::clamp(edge.dot(arm) / length2, 0.0, 1.0) : 0;
    nearest = std::min(nearest, (arm - along * edge).norm());
  }
  return above ? std::abs(normal.normalized().dot(point - corners[0])) : nearest;
}

std::vector<OpenEdge> open_edges(const TriangleMesh& mesh) {
  const std::vector<std::uint64_t> keys = sorted_edges(mesh);
  std::vector<OpenEdge> open;
  for (std::size_t begin = 0, end = 0; begin < keys.size(); begin = end) {
    int excess = 0;  // of those from the smaller index to the larger
    for (end = begin; end < keys.size() && keys[end] >> 1 == keys[begin] >> 1; ++end)
      excess += (keys[end] & 1) == 0 ? 1 : -1;
    OpenEdge edge{int(keys[begin] >> 32), int(keys[begin] >> 1 & 0x7fffffff)};
    if (excess < 0) std::swap(edge.from, edge.to);
    for (int i = 0; i < std::abs(excess); ++i) open.push_back(edge);
  }
  return open;
}

TriangleMesh closed(const TriangleMesh& mesh, const std::vector<OpenEdge>& edges) {
  TriangleMesh result = mesh;
  DisjointSets rings(mesh.vertices.size());
  for (const OpenEdge& edge : edges) rings.join(edge.from, edge.to);
  std::vector<int> apex(mesh.vertices.size(), -1);  // of a ring, by the vertex that represents it
  std::vector<double> count;
  for (const OpenEdge& edge : edges) {
    int& mean = apex[std::size_t(rings.find(edge.from))];
    if (mean < 0) {
      mean = int(result.vertices.size());
      result.vertices.push_back(Vec3::Zero());
      count.push_back(0);
    }
    result.vertices[std::size_t(mean)] += mesh.vertices[std::size_t(edge.from)];
    count[std::size_t(mean) - mesh.vertices.size()] += 1;
    result.triangles.push_back({edge.to, edge.from, mean});
  }
  for (std::size_t ring = 0; ring < count.size(); ++ring)
    result.vertices[mesh.vertices.size() + ring] /= count[ring];
  return result;
}

std::size_t zero_faces(const TriangleMesh& mesh) {
  std::size_t count = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.corners(t);
    const double longest = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    if (!((b - a).cross(c - a).norm() / 2 > 1e-12 * longest)) ++count;
  }
  return count;
}

std::size_t shells(const TriangleMesh& mesh) {
  DisjointSets sets(mesh.vertices.size());
  for (const auto& t : mesh.triangles) {
    sets.join(t[0], t[1]);
    sets.join(t[1], t[2]);
  }
  std::vector<bool> counted(mesh.vertices.size());
  std::size_t count = 0;
  for (const auto& t : mesh.triangles) {
    const auto root = std::size_t(sets.find(t[0]));
    if (!counted[root]) ++count;
    counted[root] = true;
  }
  return count;
}

double enclosed_volume(const TriangleMesh& mesh) {
  const Box box = bounding_box(mesh);
  const Vec3 centre = (box.lower + box.upper) / 2;  // less rounding than about the origin
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.corners(t);
    sum += (a - centre).dot((b - centre).cross(c - centre));
  }
  return sum / 6;
}

Vec3 centroid(const TriangleMesh& mesh) {
  const Box box = bounding_box(mesh);
  const Vec3 centre = (box.lower + box.upper) / 2;
  Vec3 moment = Vec3::Zero();
  double volume = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.corners(t);
    const double tetrahedron = (a - centre).dot((b - centre).cross(c - centre)) / 6;
    volume += tetrahedron;
    moment += tetrahedron / 4 * (a + b + c - 3 * centre);
  }
  return centre + moment / volume;
}

double surface_area(const TriangleMesh& mesh) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.corners(t);
    sum += (b - a).cross(c - a).norm() / 2;
  }
  return sum;
}

}  // namespace mss

#include "core/mesh/triangle_tree.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace mss {

namespace {

constexpr std::size_t triangles_of_leaf = 4;

Box nothing() {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  return {Vec3::Constant(infinity), Vec3::Constant(-infinity)};
}

double squared_distance(const Box& box, const Vec3& point) {
  return (point - point.cwiseMax(box.lower).cwiseMin(box.upper)).squaredNorm();
}

}  // namespace

NearestPoint nearest_point(const Vec3& point, const std::array<Vec3, 3>& corners) {
  const auto& [a, b, c] = corners;
  const Vec3 ab = b - a, ac = c - a;
  const auto weighted = [&](double u, double v) {
    return NearestPoint{a + u * ab + v * ac, {1 - u - v, u, v}};
  };
  const double d1 = ab.dot(point - a), d2 = ac.dot(point - a);
  if (d1 <= 0 && d2 <= 0) return {a, {1, 0, 0}};
  const double d3 = ab.dot(point - b), d4 = ac.dot(point - b);
  if (d3 >= 0 && d4 <= d3) return {b, {0, 1, 0}};
  const double beside_ab = d1 * d4 - d3 * d2;
  if (beside_ab <= 0 && d1 >= 0 && d3 <= 0) return weighted(d1 / (d1 - d3), 0);
  const double d5 = ab.dot(point - c), d6 = ac.dot(point - c);
  if (d6 >= 0 && d5 <= d6) return {c, {0, 0, 1}};
  const double beside_ac = d5 * d2 - d1 * d6;
  if (beside_ac <= 0 && d2 >= 0 && d6 <= 0) return weighted(0, d2 / (d2 - d6));
  const double beside_bc = d3 * d6 - d5 * d4;
  if (beside_bc <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double along = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {b + along * (c - b), {0, 1 - along, along}};
  }
  const double sum = beside_ab + beside_ac + beside_bc;
  return weighted(beside_ac / sum, beside_ab / sum);
}

TriangleTree::TriangleTree(const TriangleMesh& mesh)
    : triangles_(mesh.triangles), order_(mesh.triangles.size()) {
  std::iota(order_.begin(), order_.end(), std::size_t(0));
  std::vector<Vec3> middles;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    const auto [a, b, c] = mesh.corners(t);
    middles.emplace_back((a + b + c) / 3);
  }
  build(middles, 0, triangles_.size());
  fit(mesh.vertices);
}

void TriangleTree::build(const std::vector<Vec3>& middles, std::size_t begin, std::size_t end) {
  const std::size_t self = nodes_.size();
  nodes_.push_back({.begin = begin, .end = end, .is_leaf = end - begin <= triangles_of_leaf});
  if (!nodes_[self].is_leaf) {
    Box box = nothing();
    for (std::size_t i = begin; i < end; ++i) {
      box.lower = box.lower.cwiseMin(middles[order_[i]]);
      box.upper = box.upper.cwiseMax(middles[order_[i]]);
    }
    Eigen::Index axis = 0;
    (box.upper - box.lower).maxCoeff(&axis);
    const auto at = [&](std::size_t i) { return order_.begin() + std::ptrdiff_t(i); };
    const std::size_t middle = begin + (end - begin) / 2;
    std::nth_element(at(begin), at(middle), at(end), [&](std::size_t s, std::size_t t) {
      return std::pair(middles[s][axis], s) < std::pair(middles[t][axis], t);
    });
    build(middles, begin, middle);
    build(middles, middle, end);
  }
  nodes_[self].behind = nodes_.size();
}

/// From the last node, so that descendants come before those they are of.
void TriangleTree::fit(const std::vector<Vec3>& vertices) {
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    Node& node = nodes_[n];
    node.box = nothing();
    const auto add = [&](const Vec3& lower, const Vec3& upper) {
      node.box.lower = node.box.lower.cwiseMin(lower);
      node.box.upper = node.box.upper.cwiseMax(upper);
    };
    for (std::size_t i = node.begin; node.is_leaf && i < node.end; ++i)
      for (const int vertex : triangles_[order_[i]])
        add(vertices[std::size_t(vertex)], vertices[std::size_t(vertex)]);
    for (std::size_t child = n + 1; !node.is_leaf && child < node.behind; child = nodes_[child].behind)
      add(nodes_[child].box.lower, nodes_[child].box.upper);
  }
}

std::size_t TriangleTree::nearest(const Vec3& point, const std::vector<Vec3>& vertices) const {
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t n = 0; n < nodes_.size();) {
    const Node& node = nodes_[n];
    const bool may_have = squared_distance(node.box, point) <= least;
    for (std::size_t i = node.begin; may_have && node.is_leaf && i < node.end; ++i) {
      const std::size_t t = order_[i];
      const auto& [a, b, c] = triangles_[t];
      const double distance = (nearest_point(point, {vertices[std::size_t(a)], vertices[std::size_t(b)],
                                                     vertices[std::size_t(c)]})
                                   .at -
                               point)
                                  .squaredNorm();
      if (distance > least || (distance == least && t > nearest)) continue;
      least = distance;
      nearest = t;
    }
    n = may_have ? n + 1 : node.behind;
  }
  return nearest;
}

}  // namespace mss

#include "core/mesh/winding.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace mss {

namespace {

constexpr double four_pi = 4 * std::numbers::pi;
constexpr std::size_t leaf_size = 4;
/// A cluster is a dipole from this many of its radii on.
constexpr double far = 4;

Vec3 centroid(const std::array<Vec3, 3>& t) { return (t[0] + t[1] + t[2]) / 3; }
Vec3 area_normal(const std::array<Vec3, 3>& t) { return (t[1] - t[0]).cross(t[2] - t[0]) / 2; }

/// The field of a dipole of strength A falls as A / (4 pi r^2), so its slope is at most 2 A / (4 pi r^3).
double largest_change(double area, double distance, double within) {
  if (within == 0) return 0;
  const double nearest = distance - within;
  if (nearest <= 0) return std::numeric_limits<double>::infinity();
  return within * 2 * area / (four_pi * nearest * nearest * nearest);
}

}  // namespace

double solid_angle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double la = a.norm();
  const double lb = b.norm();
  const double lc = c.norm();
  const double numerator = a.dot(b.cross(c));
  const double denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return 2 * std::atan2(numerator, denominator);
}

WindingTree::WindingTree(const TriangleMesh& mesh, std::size_t first, double longest) {
  for (std::size_t t = first; t < mesh.triangles.size(); ++t) add_divided(mesh.corners(t), longest);
  if (!triangles_.empty()) build(0, triangles_.size());
}

void WindingTree::add_divided(const std::array<Vec3, 3>& triangle, double longest) {
  const auto& [a, b, c] = triangle;
  const std::array<double, 3> squares{(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()};
  const auto edge = std::size_t(std::max_element(squares.begin(), squares.end()) - squares.begin());
  if (!(squares[edge] > longest * longest)) {
    triangles_.push_back(triangle);
    return;
  }
  const Vec3& from = triangle[edge];
  const Vec3& to = triangle[(edge + 1) % 3];
  const Vec3& opposite = triangle[(edge + 2) % 3];
  const Vec3 middle = (from + to) / 2;
  add_divided({from, middle, opposite}, longest);
  add_divided({middle, to, opposite}, longest);
}

void WindingTree::build(std::size_t begin, std::size_t end) {
  const std::size_t self = nodes_.size();
  Node node;
  node.begin = begin;
  node.end = end;
  bound(node);
  node.leaf = end - begin <= leaf_size;
  nodes_.push_back(node);
  if (!node.leaf) split(begin, end);
  nodes_[self].behind = nodes_.size();
}

void WindingTree::split(std::size_t begin, std::size_t end) {
  Vec3 lower = centroid(triangles_[begin]);
  Vec3 upper = lower;
  for (std::size_t t = begin; t < end; ++t) {
    lower = lower.cwiseMin(centroid(triangles_[t]));
    upper = upper.cwiseMax(centroid(triangles_[t]));
  }
  Eigen::Index axis = 0;
  (upper - lower).maxCoeff(&axis);
  const auto at = [&](std::size_t t) { return triangles_.begin() + std::ptrdiff_t(t); };
  const std::size_t middle = begin + (end - begin) / 2;
  std::nth_element(at(begin), at(middle), at(end),
                   [axis](const auto& s, const auto& t) { return centroid(s)[axis] < centroid(t)[axis]; });
  build(begin, middle);
  build(middle, end);
}

void WindingTree::bound(Node& node) const {
  Vec3 weighted = Vec3::Zero();
  Vec3 mean = Vec3::Zero();
  for (std::size_t t = node.begin; t < node.end; ++t) {
    const Vec3 normal = area_normal(triangles_[t]);
    node.dipole += normal;
    node.area += normal.norm();
    weighted += normal.norm() * centroid(triangles_[t]);
    mean += centroid(triangles_[t]) / double(node.end - node.begin);
  }
  node.centre = node.area > 0 ? Vec3(weighted / node.area) : mean;
  for (std::size_t t = node.begin; t < node.end; ++t)
    for (const Vec3& x : triangles_[t]) node.radius = std::max(node.radius, (x - node.centre).norm());
}

void WindingTree::add_triangles(const Node& node, const Vec3& point, double within, Value& sum) const {
  for (std::size_t t = node.begin; t < node.end; ++t) {
    const auto& [a, b, c] = triangles_[t];
    sum.winding += solid_angle(a - point, b - point, c - point) / four_pi;
    if (within == 0) continue;
    const Vec3 middle = centroid(triangles_[t]);
    const double radius = std::sqrt(
        std::max({(a - middle).squaredNorm(), (b - middle).squaredNorm(), (c - middle).squaredNorm()}));
    sum.change += largest_change(area_normal(triangles_[t]).norm(), (middle - point).norm() - radius, within);
  }
}

WindingTree::Value WindingTree::at(const Vec3& point, double within) const {
  Value sum;
  for (std::size_t n = 0; n < nodes_.size();) {
    const Node& node = nodes_[n];
    const Vec3 to = node.centre - point;
    const double distance = to.norm();
    // depth first: past a cluster that is done with, the next node is the one behind all its descendants
    if (distance > far * node.radius + 2 * within) {
      sum.winding += node.dipole.dot(to) / (four_pi * distance * distance * distance);
      sum.change += largest_change(node.area, distance - node.radius, within);
      n = node.behind;
    } else if (node.leaf) {
      add_triangles(node, point, within, sum);
      n = node.behind;
    } else {
      ++n;
    }
  }
  return sum;
}

}  // namespace mss

#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace mss {

/// The point of a triangle that is nearest to another point: the sum of its weights times the corners. A
/// weight is 0 where the point is on the opposite edge.
struct NearestPoint {
  Vec3 at = Vec3::Zero();  ///< [m]
  std::array<double, 3> weights{};
};
/// Ericson, Real-Time Collision Detection (2005), 5.1.5.
NearestPoint nearest_point(const Vec3& point, const std::array<Vec3, 3>& corners);

/// A tree of boxes about the triangles of a surface that may move: which triangles are near a point.
///
/// Which triangles a node has is decided once, where the surface is at first; fit() moves the boxes along.
class TriangleTree {
 public:
  explicit TriangleTree(const TriangleMesh& mesh);

  /// Where its vertices are now.
  void fit(const std::vector<Vec3>& vertices);
  /// Of all; of an empty surface upside down.
  const Box& bounds() const { return nodes_.front().box; }

  /// Calls visit(triangle) for all triangles whose boxes a point is in, or no farther from than `distance`
  /// along an axis, in an order that does not depend on it.
  template <class Visit>
  void for_each_near(const Vec3& point, double distance, Visit&& visit) const {
    for (std::size_t n = 0; n < nodes_.size();) {
      const Node& node = nodes_[n];
      const bool is_near = (point - node.box.lower).minCoeff() >= -distance &&
                           (node.box.upper - point).minCoeff() >= -distance;
      for (std::size_t i = node.begin; is_near && node.is_leaf && i < node.end; ++i) visit(order_[i]);
      n = is_near ? n + 1 : node.behind;
    }
  }

  /// The triangle nearest to a point, of several as near that of the lowest index. There must be one.
  std::size_t nearest(const Vec3& point, const std::vector<Vec3>& vertices) const;

 private:
  struct Node {
    Box box{};
    std::size_t begin = 0, end = 0;  ///< of its triangles in order_
    std::size_t behind = 0;          ///< the node after all its descendants, which follow it
    bool is_leaf = false;
  };
  void build(const std::vector<Vec3>& middles, std::size_t begin, std::size_t end);

  std::vector<std::array<int, 3>> triangles_;
  std::vector<std::size_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace mss

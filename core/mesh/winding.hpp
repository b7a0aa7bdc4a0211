#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace mss {

/// The solid angle that the triangle a, b, c subtends at the origin, positive where the origin is behind it:
/// tan(Omega / 2) = a . (b x c) / (|a||b||c| + a.b |c| + b.c |a| + c.a |b|). Van Oosterom & Strackee 1983.
double solid_angle(const Vec3& a, const Vec3& b, const Vec3& c);

/// Generalised winding number of triangles about points, sum Omega / 4 pi (Jacobson, Kavan, Sorkine 2013):
/// clusters that are far away count as dipoles (Barill et al. 2018), the others are summed exactly.
class WindingTree {
 public:
  /// Takes the triangles from `first` on, divided until no edge is longer than `longest` [m].
  explicit WindingTree(const TriangleMesh& mesh, std::size_t first = 0,
                       double longest = std::numeric_limits<double>::infinity());

  /// A value at a point, and how far values within some distance of that point may be from it.
  struct Value {
    double winding = 0;
    double change = 0;  ///< infinite where a triangle is that near
  };
  /// The dipoles err by at most about .02.
  Value at(const Vec3& point, double within = 0) const;

 private:
  struct Node {
    Vec3 centre = Vec3::Zero();  ///< mean of the triangles' centroids, weighted with their areas
    Vec3 dipole = Vec3::Zero();  ///< sum of areas times normals [m^2]
    double radius = 0;           ///< of a ball about the centre with all triangles [m]
    double area = 0;             ///< [m^2]
    std::size_t begin = 0;       ///< of its triangles
    std::size_t end = 0;
    std::size_t behind = 0;  ///< the node after all its descendants, which follow it
    bool leaf = false;
  };
  void add_divided(const std::array<Vec3, 3>& triangle, double longest);
  void build(std::size_t begin, std::size_t end);
  void split(std::size_t begin, std::size_t end);
  void bound(Node& node) const;
  void add_triangles(const Node& node, const Vec3& point, double within, Value& sum) const;

  std::vector<std::array<Vec3, 3>> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace mss

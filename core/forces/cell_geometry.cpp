#include "core/forces/cell_geometry.hpp"

#include <Eigen/Geometry>

#include "core/base/lattice.hpp"

namespace mss {

namespace {

double triple(const Vec3& a, const Vec3& b, const Vec3& c) { return a.dot(b.cross(c)); }

/// Coefficients of the trilinear map on [-1, 1]^3:
///   x = c + x1 xi + y1 eta + z1 zeta + yz eta zeta + zx zeta xi + xy xi eta + xyz xi eta zeta.
struct TrilinearMap {
  Vec3 x1 = Vec3::Zero(), y1 = Vec3::Zero(), z1 = Vec3::Zero();
  Vec3 yz = Vec3::Zero(), zx = Vec3::Zero(), xy = Vec3::Zero();

  explicit TrilinearMap(const std::array<Vec3, 8>& corners) {
    for (int c = 0; c < 8; ++c) {
      const Vec3 p = corners[std::size_t(c)] / 8;
      const double sx = corner_sign(c, 0), sy = corner_sign(c, 1), sz = corner_sign(c, 2);
      x1 += sx * p;
      y1 += sy * p;
      z1 += sz * p;
      yz += sy * sz * p;
      zx += sz * sx * p;
      xy += sx * sy * p;
    }
  }
};

}  // namespace

// The Jacobian of the map is triquadratic; over the cube odd powers vanish and squares average to 1/3:
//   V = 8 ([x1 y1 z1] + ([x1 xy zx] + [xy y1 yz] + [zx yz z1]) / 3).
// The first term is the thesis's estimate, the others, products of the cell's warping modes, are missing
// there.
double trilinear_volume(const std::array<Vec3, 8>& corners) {
  const TrilinearMap m(corners);
  return 8 * (triple(m.x1, m.y1, m.z1) +
              (triple(m.x1, m.xy, m.zx) + triple(m.xy, m.y1, m.yz) + triple(m.zx, m.yz, m.z1)) / 3);
}

double thesis_volume(const std::array<Vec3, 8>& corners) {
  const TrilinearMap m(corners);
  return 8 * triple(m.x1, m.y1, m.z1);
}

Vec3 corner_sides(int corner) {
  return Vec3(corner_sign(corner, 0), corner_sign(corner, 1), corner_sign(corner, 2));
}

Eigen::Matrix3d mean_edges(const std::array<Vec3, 8>& corners) {
  Eigen::Matrix3d edges = Eigen::Matrix3d::Zero();
  for (int c = 0; c < 8; ++c) edges += corners[std::size_t(c)] * corner_sides(c).transpose() / 4;
  return edges;
}

double volume_of(const Eigen::Matrix3d& edges) { return triple(edges.col(0), edges.col(1), edges.col(2)); }

Eigen::Matrix3d volume_slopes(const Eigen::Matrix3d& edges) {
  const Vec3 x = edges.col(0), y = edges.col(1), z = edges.col(2);
  Eigen::Matrix3d slopes;
  slopes << y.cross(z), z.cross(x), x.cross(y);
  return slopes;
}

double corner_volume(const std::array<Vec3, 8>& p, int corner) {
  std::array<Vec3, 3> edge;
  for (int axis = 0; axis < 3; ++axis)
    edge[std::size_t(axis)] =
        double(corner_sign(corner, axis)) * (p[std::size_t(corner)] - p[std::size_t(corner ^ (1 << axis))]);
  return triple(edge[0], edge[1], edge[2]);
}

}  // namespace mss

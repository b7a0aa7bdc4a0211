#include "core/forces/cell_geometry.hpp"

#include <Eigen/Geometry>

namespace mss {

namespace {

double triple(const Vec3& a, const Vec3& b, const Vec3& c) { return a.dot(b.cross(c)); }

double side(int corner, int axis) { return ((corner >> axis) & 1) != 0 ? 1.0 : -1.0; }

/// Coefficients of the trilinear map on [-1, 1]^3:
///   x = c + x1 xi + y1 eta + z1 zeta + yz eta zeta + zx zeta xi + xy xi eta + xyz xi eta zeta.
struct TrilinearMap {
  Vec3 x1 = Vec3::Zero(), y1 = Vec3::Zero(), z1 = Vec3::Zero();
  Vec3 yz = Vec3::Zero(), zx = Vec3::Zero(), xy = Vec3::Zero();

  explicit TrilinearMap(const std::array<Vec3, 8>& corners) {
    for (int c = 0; c < 8; ++c) {
      const Vec3 p = corners[std::size_t(c)] / 8;
      const double sx = side(c, 0), sy = side(c, 1), sz = side(c, 2);
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

double corner_volume(const std::array<Vec3, 8>& p, int corner) {
  std::array<Vec3, 3> edge;
  for (int axis = 0; axis < 3; ++axis)
    edge[std::size_t(axis)] =
        side(corner, axis) * (p[std::size_t(corner)] - p[std::size_t(corner ^ (1 << axis))]);
  return triple(edge[0], edge[1], edge[2]);
}

}  // namespace mss

#pragma once

#include <array>
#include <optional>

#include "core/base/field.hpp"

namespace mss {

/// A vertex of one surface near a triangle of another, or of the same: how far behind it, and where.
///
/// The force of a touch is minus the gradient of the energy
///   E = k N(d) R(q),  N(d) = d^3 / (6 l) for d <= l, d (d - l) / 2 + l^2 / 6 beyond,
///   R = (1 - q)^2 for q < 1, else 0,  q = (s / (e + g d))^2,
/// where d is how far the vertex is behind the triangle's plane, and s how far the foot of its perpendicular
/// is outside the triangle. So N is a one-sided spring that is linear but for its first l, where its slope
/// starts at zero, as that of penalty planes, and R lets it end smoothly at a surface's rim. A vertex that
/// has touched before may slide off it: then the deeper it is, the farther out it ends, g = 2, so that no
/// slope is much steeper than the spring's. Another is at the rim, or beside it, g = 0. d and s depend on
/// distances of the vertex and the corners alone, so a touch changes neither momentum nor angular momentum,
/// and without friction no energy.
struct Touch {
  Vec3 normal = Vec3::UnitZ();       ///< of the triangle, outwards
  double depth = 0;                  ///< d [m]; negative in front
  double beside = 0;                 ///< s^2 [m^2]
  Vec3 from_nearest = Vec3::Zero();  ///< from the triangle's nearest point to the vertex [m]
  std::array<double, 3> foot{};      ///< weights of the corners in the foot of the perpendicular
  std::array<double, 3> nearest{};   ///< and in the triangle's nearest point
  double growth = 0;                 ///< g
  bool is_rounded = false;           ///< see round_off()
  Vec3 edge = Vec3::Zero();  ///< along which a rounded one slides freely, of length 1; of a corner none
};

/// g of vertices that have touched before.
inline constexpr double most_growth = 2;

/// Lengths of the law [m].
struct TouchLengths {
  double reach = 0;  ///< deepest that a vertex is followed
  double layer = 0;  ///< l
  double rim = 0;    ///< e
};

/// Whether a triangle with a normal and a vertex with the normal of its own surface, `outwards`, face each
/// other.
bool faces(const Vec3& normal, const Vec3& outwards);

/// How a vertex at a point lies to a triangle near it that it faces; `outwards`: the normal of its own
/// surface there. Surfaces that do not face each other do not touch: so the rims of two blocks, one on the
/// other, do not hold each other's sides. It touches if it is behind the triangle, d > 0, and that is the
/// nearest; one in front of the nearest is outside. Flat triangles touch nothing, nor does what is behind
/// one, but farther out than what touched before may slide.
std::optional<Touch> touch(const Vec3& point, const Vec3& outwards, const std::array<Vec3, 3>& corners,
                           const TouchLengths& lengths);

/// Of two triangles the nearer; of those with a nearest point in common the one that the vertex is less
/// beside: its plane is farther, which tells inside from outside.
bool is_nearer(const Touch& a, const Touch& b);

/// Makes the distance from the triangle's nearest point d, and the direction to there the normal: for a point
/// behind a valley of the surface, nearest to the valley's edge or corner, where the planes of the triangles
/// about it would have the force jump from one to the other. N(d) goes on smoothly there from beside it.
void round_off(Touch& touch, const std::array<Vec3, 3>& corners);

/// Whether it is within the rim of g = 0.
inline bool is_within_rim(const Touch& touch, const TouchLengths& lengths) {
  return touch.beside < lengths.rim * lengths.rim;
}

/// Energy over stiffness [m^2].
double touch_energy(const Touch& touch, const TouchLengths& lengths);

/// The pressing force over stiffness, the energy's derivative with respect to d [m].
double touch_pressure(const Touch& touch, const TouchLengths& lengths);

/// The second derivative of the energy with respect to the vertex, over stiffness, as if the triangle did not
/// turn, made positive semidefinite.
Eigen::Matrix3d touch_stiffness(const Touch& touch, const TouchLengths& lengths);

/// Forces over stiffness [m]: on the vertex, and on the triangle's corners. They add up to nothing.
struct TouchForces {
  Vec3 vertex;
  std::array<Vec3, 3> corners;
};
TouchForces touch_forces(const Touch& touch, const TouchLengths& lengths);

/// Minus the gradient of a sum of values at the corners, weighted as the triangle's nearest point is, by the
/// vertex and the corners. They add up to nothing, as do their moments.
TouchForces slope_at_nearest(const Touch& touch, const Vec3& point, const std::array<Vec3, 3>& corners,
                             const std::array<double, 3>& values);

/// A vertex held by friction to a point of a triangle, the anchor: its offset along the triangle, and the
/// gradients that make of a scalar times it forces without momentum and angular momentum. With
///   e = p - a,  g = n.(p - x_1),  offset^2 = |e|^2 - g^2
/// the energy k offset^2 / 2 depends on distances alone.
struct Offset {
  Vec3 along = Vec3::Zero();  ///< the part of e in the triangle's plane [m]
  Vec3 normal = Vec3::UnitZ();
  std::array<Vec3, 3> by_corner{
      Vec3::Zero(), Vec3::Zero(),
      Vec3::Zero()};  ///< minus the gradient of offset^2 / 2 with respect to the corners [m]
};
Offset offset_from(const std::array<double, 3>& anchor, const Vec3& point,
                   const std::array<Vec3, 3>& corners);

/// Weights of the corners in the foot of a point's perpendicular on the triangle's plane; they add up to 1.
std::array<double, 3> foot_on(const Vec3& point, const std::array<Vec3, 3>& corners);

}  // namespace mss

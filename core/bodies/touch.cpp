#include "core/bodies/touch.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/mesh/triangle_tree.hpp"

namespace mss {

namespace {

/// N over its length, its slope and its second derivative.
double spring_energy_of(double depth, double layer) {
  if (depth <= layer) return depth * depth * depth / (6 * layer);
  return depth * (depth - layer) / 2 + layer * layer / 6;
}
double spring_force_of(double depth, double layer) {
  return depth <= layer ? depth * depth / (2 * layer) : depth - layer / 2;
}

/// R and its derivatives.
struct Rim {
  double share, slope, curvature;
};
Rim rim_of(double q) {
  const double rest = std::max(0.0, 1 - q);
  return {rest * rest, -2 * rest, rest > 0 ? 2.0 : 0.0};
}
double rim_width(const Touch& touch, const TouchLengths& lengths) {
  return lengths.rim + touch.growth * touch.depth;
}
double q_of(const Touch& touch, const TouchLengths& lengths) {
  const double rim = rim_width(touch, lengths);
  return touch.beside / (rim * rim);
}

/// Inside the triangle weights have the gradients g_i along it: with a corner's motion u the plane turns by
/// -g_j (n.u), and the foot moves by d times that.
TouchForces slope_inside(const Touch& touch, const std::array<Vec3, 3>& corners,
                         const std::array<double, 3>& values) {
  const Vec3 area = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  std::array<Vec3, 3> gradient;
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < 3; ++i) {
    gradient[i] = area.cross(corners[(i + 2) % 3] - corners[(i + 1) % 3]) / area.squaredNorm();
    sum += values[i] * gradient[i];
  }
  TouchForces forces{-sum, {}};
  for (std::size_t i = 0; i < 3; ++i)
    forces.corners[i] = touch.nearest[i] * sum + touch.depth * sum.dot(gradient[i]) * touch.normal;
  return forces;
}

/// From corner i to corner j the weight of j is (p - x_i).e / e^2, e = x_j - x_i.
TouchForces slope_on_edge(const Touch& touch, const Vec3& point, const std::array<Vec3, 3>& corners,
                          const std::array<double, 3>& values, std::size_t i, std::size_t j) {
  const Vec3 e = corners[j] - corners[i];
  const double rise = (values[j] - values[i]) / e.squaredNorm();
  TouchForces forces{-rise * e, {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()}};
  forces.corners[j] = -rise * (point - corners[i] - 2 * touch.nearest[j] * e);
  forces.corners[i] = -forces.vertex - forces.corners[j];
  return forces;
}

}  // namespace

std::array<double, 3> foot_on(const Vec3& point, const std::array<Vec3, 3>& corners) {
  const auto& [a, b, c] = corners;
  const Vec3 area = (b - a).cross(c - a);
  const double squared = area.squaredNorm();
  const double of_b = (point - a).cross(c - a).dot(area) / squared,
               of_c = (b - a).cross(point - a).dot(area) / squared;
  return {1 - of_b - of_c, of_b, of_c};
}

bool faces(const Vec3& normal, const Vec3& outwards) {
  constexpr double most_cosine = -0.2;
  return normal.dot(outwards) < most_cosine;
}

std::optional<Touch> touch(const Vec3& point, const Vec3& outwards, const std::array<Vec3, 3>& corners,
                           const TouchLengths& lengths) {
  const Vec3 area = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  const double size = area.norm();
  if (!(size > 0)) return std::nullopt;
  Touch touch{.normal = area / size};
  touch.depth = -touch.normal.dot(point - corners[0]);
  if (!(std::abs(touch.depth) < lengths.reach) || !faces(touch.normal, outwards)) return std::nullopt;
  const NearestPoint nearest = nearest_point(point, corners);
  touch.from_nearest = point - nearest.at;
  touch.beside = std::max(0.0, touch.from_nearest.squaredNorm() - touch.depth * touch.depth);
  touch.growth = most_growth;
  if (touch.depth > 0 && q_of(touch, lengths) >= 1) return std::nullopt;
  touch.growth = 0;
  touch.nearest = nearest.weights;
  touch.foot = foot_on(point, corners);
  return touch;
}

void round_off(Touch& touch, const std::array<Vec3, 3>& corners) {
  const double distance = touch.from_nearest.norm();
  touch.is_rounded = true;
  touch.normal = -touch.from_nearest / distance;
  touch.depth = distance;
  touch.beside = 0;
  touch.foot = touch.nearest;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (touch.nearest[i] > 0 && touch.nearest[j] > 0)
        touch.edge = (corners[i] - corners[j]).stableNormalized();
}

bool is_nearer(const Touch& a, const Touch& b) {
  constexpr double rounding = 1e-9;
  const double of_a = a.from_nearest.squaredNorm(), of_b = b.from_nearest.squaredNorm();
  if (std::abs(of_a - of_b) > rounding * (of_a + of_b)) return of_a < of_b;
  return a.beside < b.beside;
}

double touch_energy(const Touch& touch, const TouchLengths& lengths) {
  return spring_energy_of(touch.depth, lengths.layer) * rim_of(q_of(touch, lengths)).share;
}

double touch_pressure(const Touch& touch, const TouchLengths& lengths) {
  const double q = q_of(touch, lengths), q_by_depth = -2 * touch.growth * q / rim_width(touch, lengths);
  const Rim rim = rim_of(q);
  return spring_force_of(touch.depth, lengths.layer) * rim.share +
         spring_energy_of(touch.depth, lengths.layer) * rim.slope * q_by_depth;
}

/// In d and s, whose gradients are -n and the direction aside.
Eigen::Matrix3d touch_stiffness(const Touch& touch, const TouchLengths& lengths) {
  const double energy = spring_energy_of(touch.depth, lengths.layer),
               force = spring_force_of(touch.depth, lengths.layer),
               slope = std::min(1.0, touch.depth / lengths.layer);
  const double q = q_of(touch, lengths), e = rim_width(touch, lengths), s = std::sqrt(touch.beside),
               g = touch.growth;
  const Rim rim = rim_of(q);
  if (touch.is_rounded)
    return slope * touch.normal * touch.normal.transpose() +
           force / touch.depth *
               (Eigen::Matrix3d::Identity() - touch.normal * touch.normal.transpose() -
                touch.edge * touch.edge.transpose());
  if (q == 0) return slope * rim.share * touch.normal * touch.normal.transpose();
  const double qd = -2 * g * q / e, qs = 2 * s / (e * e);
  const double qdd = 6 * g * g * q / (e * e), qds = -4 * g * s / (e * e * e), qss = 2 / (e * e);
  Eigen::Matrix2d planar;
  planar(0, 0) =
      slope * rim.share + 2 * force * rim.slope * qd + energy * (rim.curvature * qd * qd + rim.slope * qdd);
  planar(0, 1) = planar(1, 0) = force * rim.slope * qs + energy * (rim.curvature * qd * qs + rim.slope * qds);
  planar(1, 1) = energy * (rim.curvature * qs * qs + rim.slope * qss);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> parts(planar);
  planar =
      parts.eigenvectors() * parts.eigenvalues().cwiseMax(0).asDiagonal() * parts.eigenvectors().transpose();
  Eigen::Matrix<double, 3, 2> axes;
  axes << -touch.normal, (touch.from_nearest + touch.depth * touch.normal).stableNormalized();
  return axes * planar * axes.transpose();
}

/// With d' = -n and s^2' = 2 (p - c) + 2 d n for the vertex; d' = foot_i n and
/// s^2' = -2 nearest_i (p - c) - 2 d foot_i n for corners.
TouchForces touch_forces(const Touch& touch, const TouchLengths& lengths) {
  const double rim = rim_width(touch, lengths), press = touch_pressure(touch, lengths),
               aside = spring_energy_of(touch.depth, lengths.layer) * rim_of(q_of(touch, lengths)).slope /
                       (rim * rim);
  const Vec3 inwards = touch.depth * touch.normal;
  TouchForces forces{press * touch.normal - 2 * aside * (touch.from_nearest + inwards), {}};
  for (std::size_t i = 0; i < 3; ++i)
    forces.corners[i] = -press * touch.foot[i] * touch.normal +
                        2 * aside * (touch.nearest[i] * touch.from_nearest + touch.foot[i] * inwards);
  return forces;
}

TouchForces slope_at_nearest(const Touch& touch, const Vec3& point, const std::array<Vec3, 3>& corners,
                             const std::array<double, 3>& values) {
  const auto missing = std::count(touch.nearest.begin(), touch.nearest.end(), 0.0);
  if (missing == 0) return slope_inside(touch, corners, values);
  for (std::size_t i = 0; missing == 1 && i < 3; ++i)
    if (touch.nearest[i] == 0) return slope_on_edge(touch, point, corners, values, (i + 1) % 3, (i + 2) % 3);
  return {Vec3::Zero(), {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()}};
}

Offset offset_from(const std::array<double, 3>& anchor, const Vec3& point,
                   const std::array<Vec3, 3>& corners) {
  const Vec3 area = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  Offset offset{.normal = area.stableNormalized()};
  const Vec3 at = anchor[0] * corners[0] + anchor[1] * corners[1] + anchor[2] * corners[2];
  const Vec3 whole = point - at;
  const double gap = offset.normal.dot(point - corners[0]);
  offset.along = whole - gap * offset.normal;
  const std::array<double, 3> foot = foot_on(point, corners);
  for (std::size_t i = 0; i < 3; ++i) offset.by_corner[i] = anchor[i] * whole - gap * foot[i] * offset.normal;
  return offset;
}

}  // namespace mss

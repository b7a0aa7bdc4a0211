#include "core/environment/obstacle.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/mesh/shapes.hpp"

namespace mss {

namespace {

/// Of a shape's reach: a way that comes so near enters.
constexpr double entered = 1e-9;

Eigen::Matrix3d rotation_at_rest(const Obstacle& obstacle) {
  const bool has_axis = obstacle.shape == ObstacleShape::capsule || obstacle.shape == ObstacleShape::cylinder;
  if (has_axis) return Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), obstacle.axis).toRotationMatrix();
  return Eigen::AngleAxisd(obstacle.degrees * std::numbers::pi / 180, obstacle.axis.normalized())
      .toRotationMatrix();
}

double reach_of(const Obstacle& obstacle) {
  switch (obstacle.shape) {
    case ObstacleShape::sphere:
      return obstacle.radius;
    case ObstacleShape::box:
      return obstacle.size.norm() / 2;
    case ObstacleShape::capsule:
      return obstacle.length / 2 + obstacle.radius;
    case ObstacleShape::cylinder:
      return std::hypot(obstacle.length / 2, obstacle.radius);
    case ObstacleShape::mesh:
      break;
  }
  double reach = 0;
  for (const Vec3& vertex : obstacle.mesh->vertices) reach = std::max(reach, vertex.norm());
  return reach;
}

/// From a point, or a ball about it.
SignedDistance from_ball(const Vec3& y, double radius) {
  const double r = y.norm();
  return {r - radius, r > 0 ? Vec3(y / r) : Vec3(Vec3::UnitZ())};
}

/// By how far a point is beyond faces, negative behind them, along outward normals that are orthogonal.
template <std::size_t N>
SignedDistance from_faces(const std::array<double, N>& beyond, const std::array<Vec3, N>& normals) {
  std::size_t nearest = 0;
  Vec3 outside = Vec3::Zero();
  for (std::size_t i = 0; i < N; ++i) {
    if (beyond[i] > beyond[nearest]) nearest = i;
    outside += std::max(0.0, beyond[i]) * normals[i];
  }
  if (beyond[nearest] <= 0) return {beyond[nearest], normals[nearest]};
  const double distance = outside.norm();
  return {distance, outside / distance};
}

SignedDistance from_box(const Vec3& y, const Vec3& size) {
  std::array<double, 3> beyond{};
  std::array<Vec3, 3> normals;
  for (int axis = 0; axis < 3; ++axis) {
    beyond[std::size_t(axis)] = std::abs(y[axis]) - size[axis] / 2;
    normals[std::size_t(axis)] = std::copysign(1.0, y[axis]) * Vec3::Unit(axis);
  }
  return from_faces(beyond, normals);
}

SignedDistance from_capsule(const Vec3& y, double length, double radius) {
  return from_ball(y - std::clamp(y[2], -length / 2, length / 2) * Vec3::UnitZ(), radius);
}

SignedDistance from_cylinder(const Vec3& y, double length, double radius) {
  const Vec3 across{y[0], y[1], 0};
  const double r = across.norm();
  const Vec3 side = r > 0 ? Vec3(across / r) : Vec3(Vec3::UnitX());
  return from_faces<2>({r - radius, std::abs(y[2]) - length / 2},
                       {side, std::copysign(1.0, y[2]) * Vec3::UnitZ()});
}

}  // namespace

ObstacleSurface::ObstacleSurface(const Obstacle& obstacle)
    : obstacle_(obstacle), at_rest_(rotation_at_rest(obstacle)), reach_(reach_of(obstacle)) {
  if (obstacle.shape == ObstacleShape::mesh) surface_ = std::make_shared<const ClosedSurface>(*obstacle.mesh);
}

ObstacleSurface::Pose ObstacleSurface::pose(double t) const {
  Pose pose{at_rest_, obstacle_.centre, Vec3::Zero(), Vec3::Zero()};
  if (obstacle_.turn) {
    const Turn& turn = *obstacle_.turn;
    const Vec3 axis = turn.axis.normalized();
    const Eigen::Matrix3d turned =
        Eigen::AngleAxisd(turn.rate * std::min(t, turn.until), axis).toRotationMatrix();
    pose.rotation = turned * at_rest_;
    const Vec3 arm = turned * (obstacle_.centre - turn.centre);
    pose.origin = turn.centre + arm;
    if (t < turn.until) pose.angular_velocity = turn.rate * axis;
    pose.velocity = pose.angular_velocity.cross(arm);
  }
  if (!obstacle_.path.empty()) {
    pose.origin += obstacle_.path.at(t);
    pose.velocity += obstacle_.path.slope(t);
  }
  return pose;
}

SignedDistance ObstacleSurface::distance(const Vec3& y) const {
  switch (obstacle_.shape) {
    case ObstacleShape::sphere:
      return from_ball(y, obstacle_.radius);
    case ObstacleShape::box:
      return from_box(y, obstacle_.size);
    case ObstacleShape::capsule:
      return from_capsule(y, obstacle_.length, obstacle_.radius);
    case ObstacleShape::cylinder:
      return from_cylinder(y, obstacle_.length, obstacle_.radius);
    case ObstacleShape::mesh:
      break;
  }
  return surface_->distance(y);
}

MovingPlane ObstacleSurface::plane_at(const Vec3& y, const SignedDistance& distance, const Pose& now,
                                      const Pose& before) const {
  const Vec3 touched = y - distance.gap * distance.normal, point = now.outside(touched);
  return {{.point = point,
           .normal = now.rotation * distance.normal,
           .contact = obstacle_.contact,
           .restitution = obstacle_.restitution,
           .friction = obstacle_.friction},
          now.velocity + now.angular_velocity.cross(point - now.origin),
          point - before.outside(touched)};
}

Vec3 ObstacleSurface::centre(double t) const { return pose(t).origin; }

double ObstacleSurface::gap(const Vec3& x, double t) const { return distance(pose(t).inside(x)).gap; }

MovingPlane ObstacleSurface::plane(const Vec3& x, double t, double dt) const {
  const Pose now = pose(t);
  const Vec3 y = now.inside(x);
  return plane_at(y, distance(y), now, obstacle_.moves(t - dt) ? pose(t - dt) : now);
}

/// Where a way from in front, by a gap, comes to the surface: by steps as long as the distance from it, which
/// cannot pass it.
std::optional<Vec3> ObstacleSurface::entry(const Vec3& from, const Vec3& to, double gap) const {
  constexpr int most_steps = 256;  // ways along a surface are slow, and end near it
  const double length = (to - from).norm(), near = entered * reach_;
  double gone = 0;
  Vec3 at = from;
  for (int step = 0; step < most_steps && gap > near; ++step) {
    gone += gap;
    if (gone > length) return std::nullopt;
    at = from + gone / length * (to - from);
    gap = distance(at).gap;
  }
  return at;
}

std::optional<MovingPlane> ObstacleSurface::met(const Way& way, double close) const {
  const bool moves = obstacle_.moves(way.t - way.dt);
  const Pose now = pose(way.t), before = moves ? pose(way.t - way.dt) : now;
  const Vec3 from = before.inside(way.from), to = now.inside(way.to);
  const double length = (to - from).norm();
  if (to.norm() - reach_ > length) return std::nullopt;
  const SignedDistance end = distance(to);
  if (end.gap > length) return std::nullopt;
  const SignedDistance start = distance(from);
  if (start.gap > close) {
    if (const auto at = entry(from, to, start.gap)) return plane_at(*at, distance(*at), now, before);
  } else if (start.gap > -close && start.normal.dot(end.normal) < 0 && start.normal.dot(to - from) < 0) {
    return plane_at(from, start, now, before);  // through what is thinner than the way
  }
  if (end.gap > 0) return std::nullopt;
  return plane_at(to, end, now, before);
}

TriangleMesh ObstacleSurface::triangles(double t) const {
  TriangleMesh mesh;
  const Pose now = pose(t);
  const double r = obstacle_.radius, half = obstacle_.length / 2;
  switch (obstacle_.shape) {
    case ObstacleShape::sphere:
      mesh = icosphere(r, 6);
      break;
    case ObstacleShape::box:
      mesh = box_mesh(-obstacle_.size / 2, obstacle_.size / 2);
      break;
    case ObstacleShape::capsule:
      mesh = icosphere(r, 6);
      for (Vec3& vertex : mesh.vertices) vertex[2] += std::copysign(half, vertex[2]);
      break;
    case ObstacleShape::cylinder:
      mesh = cylinder_mesh(r, obstacle_.length, 32);
      break;
    case ObstacleShape::mesh:
      mesh = *obstacle_.mesh;
      break;
  }
  for (Vec3& vertex : mesh.vertices) vertex = now.outside(vertex);
  return mesh;
}

}  // namespace mss

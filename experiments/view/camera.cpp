#include "experiments/view/camera.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace mss::view {

namespace {

constexpr double half_angle = 0.32;  ///< between the axis of view and the upper edge of the screen [rad]
constexpr double steepest = 1.55;    ///< just short of straight down, where "up" would be lost [rad]

}  // namespace

void Camera::fit(const Vec3& lower, const Vec3& upper, const Viewport& view) {
  target_ = (lower + upper) / 2;
  const double radius = (upper - lower).norm() / 2;
  const double narrowest = std::atan(std::tan(half_angle) * std::min(1.0, view.width / view.height));
  distance_ = std::max(1.1 * radius / std::sin(narrowest), 1e-6);
  yaw_ = -1.0;
  pitch_ = 0.4;
}

void Camera::fill(std::span<const Vec3> points, const Viewport& view) {
  constexpr double share = 0.85;
  const double nearest = distance_ / 2;   // the eye stays outside of the sphere that fit() looks at
  for (int pass = 0; pass < 8; ++pass) {  // perspective: what comes nearer grows by more than it came nearer
    Eigen::Vector2d lower = project(points.front(), view), upper = lower;
    for (const Vec3& point : points) {
      lower = lower.cwiseMin(project(point, view));
      upper = upper.cwiseMax(project(point, view));
    }
    const Eigen::Vector2d size = upper - lower;
    const Eigen::Vector2d off =
        Eigen::Vector2d(view.x + view.width / 2, view.y + view.height / 2) - lower - size / 2;
    pan(off[0], off[1], view);
    const double filled = std::max(size[0] / view.width, size[1] / view.height);
    distance_ = std::max(nearest, distance_ * filled / share);
  }
}

void Camera::orbit(double dx, double dy) {
  constexpr double per_pixel = 0.008;
  yaw_ -= per_pixel * dx;
  pitch_ = std::clamp(pitch_ + per_pixel * dy, -steepest, steepest);
}

void Camera::pan(double dx, double dy, const Viewport& view) {
  const double metres = 2 * distance_ * std::tan(half_angle) / view.height;  // per pixel, at the target
  target_ += metres * (dy * up() - dx * right());
}

void Camera::zoom(double notches) { distance_ *= std::pow(0.9, notches); }

Vec3 Camera::backward() const {
  return {std::cos(pitch_) * std::cos(yaw_), std::cos(pitch_) * std::sin(yaw_), std::sin(pitch_)};
}
Vec3 Camera::right() const { return {-std::sin(yaw_), std::cos(yaw_), 0}; }
Vec3 Camera::up() const { return backward().cross(right()); }

Eigen::Matrix4d Camera::view_matrix() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.block<1, 3>(0, 0) = right();
  m.block<1, 3>(1, 0) = up();
  m.block<1, 3>(2, 0) = backward();
  m.block<3, 1>(0, 3) = -m.block<3, 3>(0, 0) * eye();
  return m;
}

Eigen::Matrix4d Camera::projection(const Viewport& view) const {
  const double near = distance_ / 50, far = distance_ * 50, scale = 1 / std::tan(half_angle);
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  m(0, 0) = scale * view.height / view.width;
  m(1, 1) = scale;
  m(2, 2) = (far + near) / (near - far);
  m(2, 3) = 2 * far * near / (near - far);
  m(3, 2) = -1;
  return m;
}

Ray Camera::ray(double px, double py, const Viewport& view) const {
  const double across = (2 * (px - view.x) - view.width) / view.height * std::tan(half_angle);
  const double upward = (1 - 2 * (py - view.y) / view.height) * std::tan(half_angle);
  return {eye(), (across * right() + upward * up() - backward()).normalized()};
}

Eigen::Vector2d Camera::project(const Vec3& point, const Viewport& view) const {
  const Eigen::Vector4d clip = projection(view) * view_matrix() * point.homogeneous();
  return {view.x + (clip[0] / clip[3] + 1) / 2 * view.width,
          view.y + (1 - clip[1] / clip[3]) / 2 * view.height};
}

}  // namespace mss::view

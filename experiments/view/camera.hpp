#pragma once

#include <Eigen/Core>
#include <span>

#include "experiments/view/drawn_surface.hpp"

namespace mss::view {

/// A rectangle of the screen [pixels], from its upper left corner.
struct Viewport {
  double x = 0, y = 0, width = 1, height = 1;

  bool contains(double px, double py) const {
    return px >= x && py >= y && px < x + width && py < y + height;
  }
};

/// An eye that orbits a point, z up.
class Camera {
 public:
  /// Turns towards a box [m] from the front, the right and above, with all of it in view.
  void fit(const Vec3& lower, const Vec3& upper, const Viewport& view);

  /// After fit() to a box round these points: as near as leaves a margin round them, and in the middle.
  void fill(std::span<const Vec3> points, const Viewport& view);

  /// The body follows the mouse by this many pixels: round its middle, or with it.
  void orbit(double dx, double dy);
  void pan(double dx, double dy, const Viewport& view);
  /// Nearer by so many notches of the wheel.
  void zoom(double notches);

  Eigen::Matrix4d view_matrix() const;
  Eigen::Matrix4d projection(const Viewport& view) const;

  /// Through a point of the screen.
  Ray ray(double px, double py, const Viewport& view) const;
  /// Projection of a point in front of the eye to the screen.
  Eigen::Vector2d project(const Vec3& point, const Viewport& view) const;

  Vec3 eye() const { return target_ + distance_ * backward(); }
  /// Viewing direction; unit.
  Vec3 forward() const { return -backward(); }
  double yaw() const { return yaw_; }  ///< [rad]
  double distance() const { return distance_; }
  const Vec3& target() const { return target_; }

 private:
  Vec3 backward() const;  ///< from the target to the eye
  Vec3 right() const;
  Vec3 up() const;

  Vec3 target_ = Vec3::Zero();
  double distance_ = 3;
  double yaw_ = 0;
  double pitch_ = 0;
};

}  // namespace mss::view

#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "core/environment/environment.hpp"
#include "core/mesh/closed_surface.hpp"

namespace mss {

/// A plane whose points move.
struct MovingPlane {
  Plane plane;
  Vec3 velocity = Vec3::Zero();  ///< of the point that is touched [m/s]
  Vec3 moved = Vec3::Zero();     ///< how far that point has come in the step [m]
};

/// The straight way of a point in a step of dt that ends at time t.
struct Way {
  Vec3 from, to;  ///< [m]
  double t, dt;   ///< [s]
};

/// The surface of an obstacle as it moves: where it is nearest to a point, and where a point's way meets it.
/// Distances are exact: closed forms of Ericson, Real-Time Collision Detection (2005), and of a mesh its
/// nearest triangle, with the side that the angle-weighted pseudonormal of Baerentzen and Aanaes, IEEE TVCG
/// 11 (2005) 243, says.
class ObstacleSurface {
 public:
  /// Throws InputError for a mesh that is not closed.
  explicit ObstacleSurface(const Obstacle& obstacle);

  const Obstacle& obstacle() const { return obstacle_; }
  /// Where the obstacle's centre is [m].
  Vec3 centre(double t) const;
  /// How far a point is from the surface, negative inside [m].
  double gap(const Vec3& x, double t) const;
  /// The plane that touches the surface where it is nearest to a point at time t, after a step of dt. The
  /// point's distance from it is the gap, but for rounding.
  MovingPlane plane(const Vec3& x, double t, double dt) const;
  /// The plane that stops a way: of what begins in front of the surface, by more than `close` [m], that where
  /// it enters, also where it ends beyond; of what began on it or inside, that nearest to its end. Nothing
  /// where the way meets no surface. Positions in between are as the obstacle sees them.
  std::optional<MovingPlane> met(const Way& way, double close) const;
  /// The surface as triangles, in its place at time t; of round shapes some hundred of them.
  TriangleMesh triangles(double t) const;

 private:
  /// x = rotation y + origin.
  struct Pose {
    Eigen::Matrix3d rotation;
    Vec3 origin, velocity, angular_velocity;

    Vec3 inside(const Vec3& x) const { return rotation.transpose() * (x - origin); }
    Vec3 outside(const Vec3& y) const { return rotation * y + origin; }
  };
  Pose pose(double t) const;
  /// Of a point about the shape's own axes.
  SignedDistance distance(const Vec3& y) const;
  std::optional<Vec3> entry(const Vec3& from, const Vec3& to, double gap) const;
  /// The plane where the surface is nearest to such a point, at a pose and after another.
  MovingPlane plane_at(const Vec3& y, const SignedDistance& distance, const Pose& now,
                       const Pose& before) const;

  Obstacle obstacle_;
  std::shared_ptr<const ClosedSurface> surface_;  ///< of a mesh
  Eigen::Matrix3d at_rest_;                       ///< turns the shape's own axes
  double reach_;                                  ///< of a ball about its centre that has all of it [m]
};

}  // namespace mss

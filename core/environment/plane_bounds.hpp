#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "core/environment/contact.hpp"

namespace mss {

/// Planes and obstacles of the law `impulse` as bounds on where particles may be, n.x >= n.point, for methods
/// that keep contact inside their steps. In indices obstacles follow planes; an obstacle bounds a particle in
/// a step by the plane that touches it where the particle is expected to meet it.
///
/// Methods that find their springs' forces at the end of a step need that: if planes acted after it, a body
/// that rests would press into the ground by what its weight makes of its lowest particles in a step, before
/// they are put back, and feel the springs of that.
class PlaneBounds {
 public:
  /// `held` must outlive it. `omega`: a bound on the body's frequencies [rad/s]; `cell_size` [m] of its
  /// smallest cells.
  PlaneBounds(const std::vector<Plane>& planes, const std::vector<Obstacle>& obstacles, const Vec3& gravity,
              double omega, double cell_size, const HeldSites& held)
      : planes_(planes),
        obstacles_(obstacles.begin(), obstacles.end()),
        gravity_(gravity),
        omega_(omega),
        cell_size_(cell_size),
        held_(held) {}

  /// Those that are planes.
  const std::vector<Plane>& planes() const { return planes_; }
  /// Planes and obstacles.
  std::size_t size() const { return planes_.size() + obstacles_.size(); }
  bool has_obstacles() const { return !obstacles_.empty(); }
  /// By what an index bounds a particle in a step in which its way is expected to be this.
  MovingPlane plane(std::size_t p, const Way& way) const {
    if (p < planes_.size()) return {planes_[p]};
    const ObstacleSurface& obstacle = obstacles_[p - planes_.size()];
    const std::optional<MovingPlane> met = obstacle.met(way, behind_by_rounding * cell_size_);
    return met ? *met : obstacle.plane(way.to, way.t, way.dt);
  }
  const Vec3& gravity() const { return gravity_; }  ///< [m/s^2]
  double cell_size() const { return cell_size_; }   ///< [m]
  /// 1 along axes that nothing prescribes, 0 along others.
  Vec3 free_axes(std::ptrdiff_t site) const {
    if (held_.empty()) return Vec3::Ones();
    return held_.free_axes(site);
  }
  /// How far behind a plane a step of dt may leave what begins it at x, at time t; see contact.hpp.
  double allowed_gap(std::size_t p, const Vec3& x, double t, double dt) const {
    const double speed = push_out_rate * cell_size_, close = behind_by_rounding * cell_size_;
    if (p < planes_.size()) return push_out_gap(planes_[p], x, speed, dt, close);
    const double gap = obstacles_[p - planes_.size()].gap(x, t);
    return gap < -close ? std::min(0.0, gap + speed * dt) : 0;
  }
  /// Whether what comes to a plane leaves it as restitution says in steps of dt [s]: in those that resolve
  /// the body's fastest motion. In longer ones particles have bounced on their springs and come to rest
  /// before they end.
  bool bounces(double dt) const { return omega_ * dt < 1; }
  /// Ends a step for a particle that the planes which `pushed` names by index have stopped in it: it rests,
  /// or leaves as restitution says, see contact.hpp. True if it leaves. `plane_at(p)`: by what an index
  /// bounds it, a MovingPlane. Calls give(plane, dv) for every change of velocity.
  template <class Pushed, class PlaneAt, class Give>
  bool rebound(std::ptrdiff_t site, const FreeStep& step, const Motion& before, Pushed&& pushed,
               PlaneAt&& plane_at, Motion& after, Give&& give) const {
    const bool may_leave = bounces(step.dt);
    const Motion start = after;
    bool leaves = false;
    const Vec3 free = free_axes(site);
    for (std::size_t p = 0; p < size(); ++p) {
      if (!pushed(p)) continue;
      const Vec3 v = after.v;
      const MovingPlane& met = plane_at(p);
      Motion seen{after.x, after.v - met.velocity};  // from the point that is touched
      leaves |= mss::rebound(met.plane, gravity_, step, may_leave,
                             {before.x + met.moved, before.v - met.velocity}, seen);
      after = {seen.x, seen.v + met.velocity};
      give(p, Vec3(free.cwiseProduct(after.v - v)));
    }
    after.x = start.x + free.cwiseProduct(after.x - start.x);
    after.v = start.v + free.cwiseProduct(after.v - start.v);
    for (std::size_t p = 0; p < size(); ++p)
      if (const Plane& plane = plane_at(p).plane; plane.gap(after.x) < std::min(0.0, plane.gap(start.x))) {
        after.x = start.x;
        break;
      }
    return leaves;
  }

 private:
  std::vector<Plane> planes_;
  std::vector<ObstacleSurface> obstacles_;
  Vec3 gravity_;
  double omega_, cell_size_;
  const HeldSites& held_;
};

/// The planes and obstacles of an environment as bounds of particles; nullptr unless all that act at the end
/// of steps are of the law `impulse` and touch particles. `held` must outlive it.
inline std::unique_ptr<PlaneBounds> plane_bounds(const Environment& environment, double omega,
                                                 double cell_size, const HeldSites& held) {
  std::vector<Plane> planes = environment.planes;
  std::vector<Obstacle> obstacles = environment.obstacles;
  const auto presses = [](const auto& one) { return one.contact == ContactLaw::penalty; };
  const auto bounds = [](const auto& one) { return one.contact == ContactLaw::impulse; };
  std::erase_if(planes, presses);
  std::erase_if(obstacles, presses);
  const bool all = std::all_of(planes.begin(), planes.end(), bounds) &&
                   std::all_of(obstacles.begin(), obstacles.end(), bounds);
  if ((planes.empty() && obstacles.empty()) || !all || environment.contact_surface) return nullptr;
  return std::make_unique<PlaneBounds>(planes, obstacles, environment.gravity, omega, cell_size, held);
}

}  // namespace mss

#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "core/environment/contact.hpp"

namespace mss {

/// Planes of the law `impulse` as bounds on where particles may be, n.x >= n.point, for methods that keep
/// contact inside their steps.
///
/// Methods that find their springs' forces at the end of a step need that: if planes acted after it, a body
/// that rests would press into the ground by what its weight makes of its lowest particles in a step, before
/// they are put back, and feel the springs of that.
class PlaneBounds {
 public:
  /// `held` must outlive it. `omega`: a bound on the body's frequencies [rad/s]; `cell_size` [m] of its
  /// smallest cells.
  PlaneBounds(const std::vector<Plane>& planes, const Vec3& gravity, double omega, double cell_size,
              const HeldSites& held)
      : planes_(planes), gravity_(gravity), omega_(omega), cell_size_(cell_size), held_(held) {}

  const std::vector<Plane>& planes() const { return planes_; }
  const Vec3& gravity() const { return gravity_; }  ///< [m/s^2]
  double cell_size() const { return cell_size_; }   ///< [m]
  /// 1 along axes that nothing prescribes, 0 along others.
  Vec3 free_axes(std::ptrdiff_t site) const {
    if (held_.empty()) return Vec3::Ones();
    return held_.free_axes(site);
  }
  /// How far behind a plane a step of dt may leave what begins it at x, see contact.hpp.
  double allowed_gap(std::size_t plane, const Vec3& x, double dt) const {
    return push_out_gap(planes_[plane], x, push_out_rate * cell_size_, dt, behind_by_rounding * cell_size_);
  }
  /// Whether what comes to a plane leaves it as restitution says in steps of dt [s]: in those that resolve
  /// the body's fastest motion. In longer ones particles have bounced on their springs and come to rest
  /// before they end.
  bool bounces(double dt) const { return omega_ * dt < 1; }
  /// Ends a step for a particle that the planes which `pushed` names by index have stopped in it: it rests,
  /// or leaves as restitution says, see contact.hpp. True if it leaves. Calls give(plane, dv) for every
  /// change of velocity.
  template <class Pushed, class Give>
  bool rebound(std::ptrdiff_t site, const FreeStep& step, const Motion& before, Pushed&& pushed,
               Motion& after, Give&& give) const {
    const bool may_leave = bounces(step.dt);
    const Motion start = after;
    bool leaves = false;
    const Vec3 free = free_axes(site);
    for (std::size_t p = 0; p < planes_.size(); ++p) {
      if (!pushed(p)) continue;
      const Vec3 v = after.v;
      leaves |= mss::rebound(planes_[p], gravity_, step, may_leave, before, after);
      give(p, Vec3(free.cwiseProduct(after.v - v)));
    }
    after.x = start.x + free.cwiseProduct(after.x - start.x);
    after.v = start.v + free.cwiseProduct(after.v - start.v);
    const bool behind = std::any_of(planes_.begin(), planes_.end(), [&](const Plane& plane) {
      return plane.gap(after.x) < std::min(0.0, plane.gap(start.x));
    });
    if (behind) after.x = start.x;
    return leaves;
  }

 private:
  std::vector<Plane> planes_;
  Vec3 gravity_;
  double omega_, cell_size_;
  const HeldSites& held_;
};

/// The planes of an environment as bounds of particles; nullptr unless all that act at the end of steps are
/// of the law `impulse` and touch particles. `held` must outlive it.
inline std::unique_ptr<PlaneBounds> plane_bounds(const Environment& environment, double omega,
                                                 double cell_size, const HeldSites& held) {
  std::vector<Plane> planes = environment.planes;
  std::erase_if(planes, [](const Plane& plane) { return plane.contact == ContactLaw::penalty; });
  const bool all = std::all_of(planes.begin(), planes.end(),
                               [](const Plane& plane) { return plane.contact == ContactLaw::impulse; });
  if (planes.empty() || !all || environment.contact_surface) return nullptr;
  return std::make_unique<PlaneBounds>(planes, environment.gravity, omega, cell_size, held);
}

}  // namespace mss

#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "core/environment.hpp"

namespace mss {

/// Planes of the law `impulse` as bounds on where particles may be, n.x >= n.point, for methods that keep
/// contact inside their steps.
///
/// Steps that resolve the body's fastest motion are too short for that to matter: there planes act after
/// them, as after those of explicit methods, and the time of an impact within a step counts. In longer ones a
/// body that rests would fall by g dt^2 before it is put back, as if it were that much softer.
class PlaneBounds {
 public:
  /// `held` must outlive it. `omega`: a bound on the body's frequencies [rad/s].
  PlaneBounds(const std::vector<Plane>& planes, double gravity, double omega, const HeldSites& held)
      : planes_(planes), gravity_(gravity), omega_(omega), held_(held) {}

  const std::vector<Plane>& planes() const { return planes_; }
  /// Its magnitude [m/s^2]: what rests on a plane moves towards it by that times a step before contact acts.
  double gravity() const { return gravity_; }
  /// Whether planes act inside steps of dt [s]: those that central differences could not take.
  bool act_inside(double dt) const { return omega_ * dt > 2; }
  /// 1 along axes that nothing prescribes, 0 along others.
  Vec3 free_axes(std::ptrdiff_t site) const {
    if (held_.empty()) return Vec3::Ones();
    return {held_.holds(site, 0) ? 0.0 : 1.0, held_.holds(site, 1) ? 0.0 : 1.0,
            held_.holds(site, 2) ? 0.0 : 1.0};
  }

 private:
  std::vector<Plane> planes_;
  double gravity_, omega_;
  const HeldSites& held_;
};

/// The planes of an environment as bounds of particles; nullptr unless all that act at the end of steps are
/// of the law `impulse` and touch particles. `held` must outlive it.
inline std::unique_ptr<PlaneBounds> plane_bounds(const Environment& environment, double omega,
                                                 const HeldSites& held) {
  std::vector<Plane> planes = environment.planes;
  std::erase_if(planes, [](const Plane& plane) { return plane.contact == ContactLaw::penalty; });
  const bool all = std::all_of(planes.begin(), planes.end(),
                               [](const Plane& plane) { return plane.contact == ContactLaw::impulse; });
  if (planes.empty() || !all || environment.contact_surface) return nullptr;
  return std::make_unique<PlaneBounds>(planes, environment.gravity.norm(), omega, held);
}

}  // namespace mss

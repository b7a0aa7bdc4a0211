#include "core/plane_contact.hpp"

#include <cmath>

namespace mss {

PlaneContact::PlaneContact(const Environment& environment, const SpectralBound& body, double cell_size)
    : cell_size_(cell_size) {
  for (const Plane& plane : environment.planes)
    if (plane.contact == ContactLaw::penalty)
      penalties_.emplace_back(plane, body, environment.gravity.norm(), cell_size);
    else
      colliding_.push_back(plane);
}

/// In a wedge one plane may push a particle into another, so all are applied again until none acts. From the
/// second round on, a plane is skipped if the particle, but for rounding, is neither behind it nor moves
/// towards it: that is where the plane has just put it.
bool PlaneContact::collide(const Motion& before, double dt, Motion& after) const {
  constexpr int most_rounds = 8;
  const auto apply = [&](const Plane& plane) {
    if (plane.contact == ContactLaw::thesis) return collide_thesis(plane, before, after);
    const double gap =
        push_out_gap(plane, before.x, push_out_rate * cell_size_, dt, behind_by_rounding * cell_size_);
    return gap < 0 ? push_out(plane, gap, after) : collide_impulse(plane, before, dt, after);
  };
  const double close = 1e-9 * cell_size_;
  const auto is_done = [&](const Plane& plane) {
    return plane.gap(after.x) > -close && plane.normal.dot(after.v) * dt > -close;
  };
  bool any = false;
  for (int round = 0; round < most_rounds; ++round) {
    bool changed = false;
    for (const Plane& plane : colliding_)
      if (round == 0 || !is_done(plane)) changed |= apply(plane);
    any |= changed;
    if (!changed || colliding_.size() == 1) break;
  }
  return any;
}

bool PlaneContact::is_free(const Motion& motion, double dt) const {
  const double close = 1e-9 * cell_size_;
  return std::all_of(colliding_.begin(), colliding_.end(), [&](const Plane& plane) {
    const double gap = plane.gap(motion.x);
    return gap > 0 || (gap > -close && plane.normal.dot(motion.v) * dt > -close);
  });
}

bool PlaneContact::sticks(const Motion& motion, const Vec3& acceleration) const {
  const double close = 1e-6 * cell_size_;
  return std::any_of(colliding_.begin(), colliding_.end(), [&](const Plane& plane) {
    return plane.contact == ContactLaw::impulse && mss::sticks(plane, motion, acceleration, close);
  });
}

Vec3 PlaneContact::acceleration(const Motion& motion) const {
  Vec3 sum = Vec3::Zero();
  for (const Penalty& penalty : penalties_)
    if (penalty.gap(motion.x) < 0) sum += penalty.acceleration(motion);
  return sum;
}

Eigen::Matrix3d PlaneContact::tangent(const Motion& motion, const TangentSum& sum, double mass) const {
  Eigen::Matrix3d block = Eigen::Matrix3d::Zero();
  for (const Penalty& penalty : penalties_)
    if (penalty.gap(motion.x) < 0) block += mass * penalty.tangent(motion, sum);
  return block;
}

void PlaneContact::add_potential(const Vec3& x, double& over_mass) const {
  for (const Penalty& penalty : penalties_) over_mass += penalty.potential(x);
}

/// Stiffness and damping of a plane are proportional to mass: they add to those of every mode alike.
SpectralBound PlaneContact::with_penalties(SpectralBound body) const {
  for (const Penalty& penalty : penalties_) {
    body.omega = std::hypot(body.omega, penalty.bound().omega);
    body.damping += penalty.bound().damping;
  }
  return body;
}

}  // namespace mss

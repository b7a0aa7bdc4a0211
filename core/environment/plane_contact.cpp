#include "core/environment/plane_contact.hpp"

#include <cmath>

namespace mss {

PlaneContact::PlaneContact(const Environment& environment, const SpectralBound& body, double cell_size)
    : omega_(body.omega),
      cell_size_(cell_size),
      fall_step_(std::sqrt(cell_size / (2000 * environment.gravity.norm()))) {
  for (const Plane& plane : environment.planes)
    if (plane.contact == ContactLaw::penalty)
      penalties_.emplace_back(plane, body, environment.gravity.norm(), cell_size);
    else
      colliding_.push_back(plane);
}

bool PlaneContact::is_free(const Motion& motion, double dt) const {
  return std::all_of(colliding_.begin(), colliding_.end(), [&](const Plane& plane) {
    return plane.gap(motion.x) > 0 || is_free(plane, motion, dt);
  });
}

std::optional<std::size_t> PlaneContact::sticks_to(const Vec3& x, const Vec3& acceleration) const {
  const double close = 1e-6 * cell_size_;
  for (std::size_t p = 0; p < colliding_.size(); ++p)
    if (colliding_[p].contact == ContactLaw::impulse &&
        sticks(colliding_[p], {x, Vec3::Zero()}, acceleration, close))
      return p;
  return std::nullopt;
}

std::optional<std::size_t> PlaneContact::carries(const Vec3& x, const Vec3& force) const {
  std::optional<std::size_t> carrying;
  double most = 0;
  for (std::size_t p = 0; p < colliding_.size(); ++p) {
    const double pressure = -colliding_[p].normal.dot(force);
    if (std::abs(colliding_[p].gap(x)) > 1e-6 * cell_size_ || pressure <= most) continue;
    most = pressure;
    carrying = p;
  }
  return carrying;
}

Vec3 PlaneContact::acceleration(const Motion& motion) const {
  Vec3 sum = Vec3::Zero();
  for (const Penalty& penalty : penalties_)
    if (penalty.gap(motion.x) < 0) sum += penalty.acceleration(motion);
  return sum;
}

Eigen::Matrix3d PlaneContact::tangent(const Motion& motion, const TangentCoefficients& sum,
                                      double mass) const {
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

#include "core/environment/plane_contact.hpp"

#include <cmath>

namespace mss {

namespace {

/// A plane that an obstacle's law is taken from.
Plane law_of(const Obstacle& obstacle) {
  return {.contact = obstacle.contact, .restitution = obstacle.restitution, .friction = obstacle.friction};
}

}  // namespace

PlaneContact::PlaneContact(const Environment& environment, const SpectralBound& body, double cell_size)
    : omega_(body.omega),
      cell_size_(cell_size),
      fall_step_(std::sqrt(cell_size / (2000 * environment.gravity.norm()))) {
  const double gravity = environment.gravity.norm();
  for (const Plane& plane : environment.planes)
    if (plane.contact == ContactLaw::penalty)
      penalties_.emplace_back(plane, body, gravity, cell_size);
    else
      colliding_.push_back(plane);
  for (const Obstacle& obstacle : environment.obstacles)
    if (obstacle.contact == ContactLaw::penalty)
      pressing_.push_back({ObstacleSurface(obstacle), Penalty(law_of(obstacle), body, gravity, cell_size)});
    else
      obstacles_.emplace_back(obstacle);
}

bool PlaneContact::moves(double t) const {
  return std::any_of(obstacles_.begin(), obstacles_.end(),
                     [&](const ObstacleSurface& surface) { return surface.obstacle().moves(t); }) ||
         std::any_of(pressing_.begin(), pressing_.end(),
                     [&](const Pressing& pressing) { return pressing.surface.obstacle().moves(t); });
}

bool PlaneContact::meets_obstacle(const Way& way) const {
  const double close = behind_by_rounding * cell_size_;
  return std::any_of(obstacles_.begin(), obstacles_.end(),
                     [&](const ObstacleSurface& surface) { return surface.met(way, close).has_value(); });
}

bool PlaneContact::apply(const ObstacleSurface& obstacle, const Motion& before, double t, double dt,
                         bool at_once, Motion& after) const {
  const double close = behind_by_rounding * cell_size_;
  const std::optional<MovingPlane> met = obstacle.met({before.x, after.x, t, dt}, close);
  if (!met) return false;
  const PushOut out{push_out_rate * cell_size_, at_once ? std::numeric_limits<double>::infinity() : close};
  return collide_moving(*met, obstacle.gap(before.x, t - dt), out, before, dt, after);
}

bool PlaneContact::is_free(const Motion& motion, double t, double dt) const {
  for (std::size_t p = 0; p < collisions(); ++p)
    if (plane_at(p, motion.x, t).plane.gap(motion.x) <= 0 && !is_free(p, motion, t, dt)) return false;
  return true;
}

std::optional<std::size_t> PlaneContact::sticks_to(const Vec3& x, double t, const Vec3& acceleration) const {
  const double close = 1e-6 * cell_size_;
  for (std::size_t p = 0; p < collisions(); ++p) {
    const auto& [plane, velocity, moved] = plane_at(p, x, t);
    if (plane.contact == ContactLaw::impulse && velocity.isZero(0) &&
        sticks(plane, {x, Vec3::Zero()}, acceleration, close))
      return p;
  }
  return std::nullopt;
}

std::optional<std::size_t> PlaneContact::carries(const Vec3& x, double t, const Vec3& force) const {
  std::optional<std::size_t> carrying;
  double most = 0;
  for (std::size_t p = 0; p < collisions(); ++p) {
    const Plane plane = plane_at(p, x, t).plane;
    const double pressure = -plane.normal.dot(force);
    if (std::abs(plane.gap(x)) > 1e-6 * cell_size_ || pressure <= most) continue;
    most = pressure;
    carrying = p;
  }
  return carrying;
}

Vec3 PlaneContact::acceleration(const Motion& motion, double t) const {
  Vec3 sum = Vec3::Zero();
  for_each_pressing(motion.x, t, [&](const Penalty& penalty) { sum += penalty.acceleration(motion); });
  return sum;
}

Eigen::Matrix3d PlaneContact::tangent(const Motion& motion, double t, const TangentCoefficients& sum,
                                      double mass) const {
  Eigen::Matrix3d block = Eigen::Matrix3d::Zero();
  for_each_pressing(motion.x, t,
                    [&](const Penalty& penalty) { block += mass * penalty.tangent(motion, sum); });
  return block;
}

void PlaneContact::add_potential(const Vec3& x, double t, double& over_mass) const {
  for_each_pressing(x, t, [&](const Penalty& penalty) { over_mass += penalty.potential(x); });
}

/// Stiffness and damping of a plane are proportional to mass: they add to those of every mode alike.
SpectralBound PlaneContact::with_penalties(SpectralBound body) const {
  const auto add = [&](const SpectralBound& more) {
    body.omega = std::hypot(body.omega, more.omega);
    body.damping += more.damping;
  };
  for (const Penalty& penalty : penalties_) add(penalty.bound());
  for (const Pressing& pressing : pressing_) add(pressing.penalty.bound());
  return body;
}

void PlaneContact::lower_gaps(const Vec3& x, double t, std::vector<double>& smallest) const {
  for (std::size_t p = 0; p < penalties_.size(); ++p)
    smallest[p] = std::min(smallest[p], penalties_[p].gap(x));
  for (std::size_t p = 0; p < pressing_.size(); ++p) {
    double& least = smallest[penalties_.size() + p];
    least = std::min(least, pressing_[p].surface.gap(x, t));
  }
}

}  // namespace mss

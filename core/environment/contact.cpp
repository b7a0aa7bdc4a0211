#include "core/environment/contact.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace mss {

namespace {

/// An impulse over mass, and the time between it and the end of the step, by which it changes the position.
struct Push {
  double normal = 0;  ///< [m/s]
  double lever = 0;   ///< [s]
  bool rests = false;
};

/// The parabola's impact with the plane; `start` and `end` are the gaps of the step, `a` its acceleration.
Push impact(const Plane& plane, double start, double end, double a, double dt) {
  const double w = (end - start) / dt - a * dt / 2;  // at the beginning
  const double arrival = start > 0 ? std::sqrt(std::max(0.0, w * w - 2 * a * start)) : std::max(0.0, -w);
  const double hop = 2 * plane.restitution * arrival;  // its duration times -a
  if (a < 0 && hop < -a * dt) return {.rests = true};
  // The root of start + w time + a time^2 / 2 = 0 on the descending branch, in the form without cancellation.
  const double time = start > 0 && arrival > w ? std::min(dt, 2 * start / (arrival - w)) : 0;
  return {.normal = (1 + plane.restitution) * arrival, .lever = dt - time};
}

}  // namespace

bool collide_impulse(const Plane& plane, const Motion& before, double dt, Motion& after) {
  const double end = plane.gap(after.x);
  const double speed = plane.normal.dot(after.v);
  if (end > 0 || (end == 0 && speed >= 0) || (after.v.isZero(0) && after.x == before.x)) return false;
  Push push = impact(plane, plane.gap(before.x), end, (speed - plane.normal.dot(before.v)) / dt, dt);
  if (push.rests) {  // the impulse that moves it from `end` to the plane also stops it
    push.normal = std::max(0.0, -speed);
    push.lever = push.normal > 0 ? std::min(-end / push.normal, dt) : 0;
  }
  const Vec3 sliding = after.v - speed * plane.normal;
  const bool stuck = sliding.norm() <= plane.friction * push.normal;
  const Vec3 friction =
      stuck ? Vec3(-sliding) : Vec3(-plane.friction * push.normal / sliding.norm() * sliding);
  after.x += push.lever * (push.normal * plane.normal + friction);
  after.v += push.normal * plane.normal + friction;
  if (push.rests && stuck) {
    if (before.v.isZero(0)) after.x = before.x;  // it did not move at all
    after.v = Vec3::Zero();
  }
  if (const double gap = plane.gap(after.x); push.rests || gap < 0) after.x -= gap * plane.normal;
  return true;
}

double push_out_gap(const Plane& plane, const Vec3& before, double speed, double dt, double close) {
  const double gap = plane.gap(before);
  return gap < -close ? std::min(0.0, gap + speed * dt) : 0;
}

bool push_out(const Plane& plane, double gap, Motion& after) {
  const double missing = gap - plane.gap(after.x), speed = plane.normal.dot(after.v);
  if (missing <= 0 && speed >= 0) return false;
  after.x += std::max(0.0, missing) * plane.normal;
  after.v -= std::min(0.0, speed) * plane.normal;
  return true;
}

bool rebound(const Plane& plane, const Vec3& gravity, const FreeStep& step, bool may_leave,
             const Motion& before, Motion& after) {
  const double dt = step.dt, speed = plane.normal.dot(after.v);
  Motion free{before.x + dt * before.v + step.drift * dt * dt * gravity, before.v + dt * gravity};
  const bool leaves = may_leave && -plane.normal.dot(before.v) > 2 * gravity.norm() * dt &&
                      collide_impulse(plane, before, dt, free) && plane.normal.dot(free.v) > 0;
  const double speed_after = leaves ? plane.normal.dot(free.v) : 0;
  const Vec3 sliding = after.v - speed * plane.normal;
  const double slows = std::min(plane.friction * speed_after, sliding.norm());
  after.v += (speed_after - speed) * plane.normal - slows * sliding.stableNormalized();
  if (leaves) after.x += (plane.gap(free.x) - plane.gap(after.x)) * plane.normal;
  return leaves;
}

bool collide_moving(const MovingPlane& met, double gap, const PushOut& out, const Motion& before, double dt,
                    Motion& after) {
  const auto& [plane, velocity, moved] = met;
  Motion end{after.x, after.v - velocity};
  const Motion start{before.x + moved, before.v - velocity};
  const bool began_behind = gap < -out.close;
  const bool changed = plane.contact == ContactLaw::thesis ? collide_thesis(plane, start, end)
                       : began_behind ? push_out(plane, std::min(0.0, gap + out.speed * dt), end)
                                      : collide_impulse(plane, start, dt, end);
  if (changed) after = {end.x, end.v + velocity};
  return changed;
}

bool sticks(const Plane& plane, const Motion& motion, const Vec3& acceleration, double close) {
  if (!motion.v.isZero(0) || std::abs(plane.gap(motion.x)) > close) return false;
  const double lift = plane.normal.dot(acceleration);
  return lift < 0 && (acceleration - lift * plane.normal).norm() <= -plane.friction * lift;
}

bool collide_thesis(const Plane& plane, const Motion& before, Motion& after) {
  const double start = plane.gap(before.x), end = plane.gap(after.x);
  const bool behind = start < -0.01 * (start - end);  // by more than rounding
  if (end > 0 || end >= start || behind) return false;
  const Vec3 gained = after.v - before.v;
  if (after.v.norm() > 2 * gained.norm()) {
    after.x -= 2 * end * plane.normal;
    after.v = plane.restitution * (after.v - 2 * plane.normal.dot(after.v) * plane.normal);
    return true;
  }
  const double support = std::max(0.0, -plane.normal.dot(gained));
  const Vec3 pull = gained - plane.normal.dot(gained) * plane.normal;
  after.x = before.x + std::max(0.0, start / (start - end)) * (after.x - before.x);
  after.v = support * (plane.normal - plane.friction * pull.stableNormalized());
  return true;
}

namespace {

constexpr double layer_share = 0.01;  ///< l over a cell's size
constexpr double rate_share = 20;     ///< the losses' rate over omega

/// D(v, L) and its derivatives, for a speed v >= 0.
struct Drag {
  double over_speed = 0;  ///< -D / v
  double by_speed = 0;    ///< -dD/dv
  double by_limit = 0;    ///< -dD/dL
};
Drag drag(double speed, double limit, double rate) {
  if (limit <= 0) return {};
  const double viscous = limit / rate, size = std::hypot(speed, viscous);
  const double share = speed / size, rest = viscous / size;
  return {limit / size, limit / size * rest * rest, share * share * share};
}

/// N(d) / omega^2, its slope and its integral.
struct Spring {
  double force = 0, slope = 0, energy = 0;
};
Spring spring(double depth, double layer) {
  if (depth <= 0) return {};
  if (depth <= layer)
    return {depth * depth / (2 * layer), depth / layer, depth * depth * depth / (6 * layer)};
  return {depth - layer / 2, 1, depth * (depth - layer) / 2 + layer * layer / 6};
}

}  // namespace

/// Terms of the force and its derivatives.
struct Penalty::Parts {
  double speed = 0;          ///< n.v
  Vec3 slip = Vec3::Zero();  ///< the rest of v
  double slope = 0;          ///< dN/dd
  double pressure = 0;       ///< p
  Drag loss{}, friction{};   ///< D of both
};

Penalty::Penalty(const Plane& plane, const SpectralBound& body, double gravity, double cell_size)
    : plane_(plane),
      omega_(std::max(body.omega, std::sqrt(2 * gravity / (layer_share * cell_size)))),
      layer_(layer_share * cell_size),
      loss_((1 - plane.restitution * plane.restitution) / (1 + plane.restitution * plane.restitution)),
      rate_(rate_share * omega_) {}

Penalty Penalty::on(const MovingPlane& other) const {
  Penalty penalty = *this;
  penalty.plane_ = other.plane;
  penalty.velocity_ = other.velocity;
  return penalty;
}

Penalty::Parts Penalty::parts(const Motion& motion) const {
  const Spring n = spring(-gap(motion.x), layer_);
  const double press = omega_ * omega_ * n.force;
  const Vec3 v = motion.v - velocity_;
  Parts parts{.speed = plane_.normal.dot(v), .slope = omega_ * omega_ * n.slope};
  parts.slip = v - parts.speed * plane_.normal;
  parts.loss = drag(std::abs(parts.speed), loss_ * press, rate_);
  parts.pressure = press - parts.loss.over_speed * parts.speed;
  parts.friction = drag(parts.slip.norm(), plane_.friction * parts.pressure, rate_);
  return parts;
}

Vec3 Penalty::acceleration(const Motion& motion) const {
  const Parts parts = this->parts(motion);
  return parts.pressure * plane_.normal - parts.friction.over_speed * parts.slip;
}

Eigen::Matrix3d Penalty::tangent(const Motion& motion, const TangentCoefficients& sum) const {
  const Parts p = parts(motion);
  const Vec3 along = p.slip.stableNormalized();
  const double by_depth = p.slope * (1 - std::copysign(loss_ * p.loss.by_limit, p.speed));
  // The force p n + t(p, v) changes with p along n and, as friction is proportional to it, against the slip.
  Vec3 by_pressure = plane_.normal;
  if (sum.kind == Tangent::exact) by_pressure -= plane_.friction * p.friction.by_limit * along;
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - plane_.normal * plane_.normal.transpose();
  return (sum.stiffness * by_depth + sum.damping * p.loss.by_speed) * by_pressure *
             plane_.normal.transpose() +
         sum.damping * (p.friction.over_speed * across +
                        (p.friction.by_speed - p.friction.over_speed) * along * along.transpose());
}

double Penalty::potential(const Vec3& x) const { return omega_ * omega_ * spring(-gap(x), layer_).energy; }

SpectralBound Penalty::bound() const {
  return {.omega = omega_, .damping = loss_ > 0 || plane_.friction > 0 ? rate_ : 0};
}

std::vector<Vec3> split_by_plane(const std::vector<Plane>& planes, const std::vector<std::size_t>& on,
                                 const Vec3& free, const Vec3& given) {
  std::vector<Vec3> parts(planes.size(), Vec3::Zero());
  if (on.size() == 1) parts[on[0]] = free.cwiseProduct(given);
  if (on.size() < 2) return parts;
  Eigen::MatrixXd normals(3, on.size());
  for (std::size_t i = 0; i < on.size(); ++i)
    normals.col(Eigen::Index(i)) = free.cwiseProduct(planes[on[i]].normal);
  Vec3 rest = free.cwiseProduct(given);
  const Eigen::VectorXd pressures = normals.completeOrthogonalDecomposition().solve(rest);
  rest -= normals * pressures;
  std::vector<double> shares;
  double sum = 0;
  for (std::size_t i = 0; i < on.size(); ++i) {
    shares.push_back(planes[on[i]].friction * std::max(0.0, pressures[Eigen::Index(i)]));
    sum += shares.back();
  }
  for (std::size_t i = 0; i < on.size(); ++i) {
    const double share = sum > 0 ? shares[i] / sum : 1 / double(on.size());
    parts[on[i]] = pressures[Eigen::Index(i)] * normals.col(Eigen::Index(i)) + share * rest;
  }
  return parts;
}

}  // namespace mss

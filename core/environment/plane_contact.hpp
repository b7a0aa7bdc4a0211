#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "core/environment/contact.hpp"

namespace mss {

/// The planes and obstacles of an environment and what they do to one particle, or one vertex of a surface,
/// each by its own law (contact.hpp). In indices obstacles follow planes; what is said of planes holds for
/// them. Times are those of the step's end, or of the moment [s].
class PlaneContact {
 public:
  /// `body`: the spectrum of what collides, without planes; `cell_size` h [m].
  PlaneContact(const Environment& environment, const SpectralBound& body, double cell_size);

  /// True if planes act at the end of steps: those of the laws `impulse` and `thesis`.
  bool has_collisions() const { return collisions() > 0; }
  /// Longest step that resolves the motion of what collides, 2 over its angular frequency [s].
  double resolved_step() const { return 2 / omega_; }
  /// Longest step in which gravity moves what collides by no more than 1/4000 of a cell; infinite without it
  /// [s].
  double fall_step() const { return fall_step_; }
  /// True if planes act by forces: those of the law `penalty`.
  bool has_penalties() const { return penalties() > 0; }

  /// Whether a particle that a step of dt took from before() to x is behind or on a plane that acts at the
  /// end of steps, or has met such an obstacle: otherwise none does anything.
  template <class Before>
  bool touches(Before&& before, const Vec3& x, double t, double dt) const {
    return std::any_of(colliding_.begin(), colliding_.end(),
                       [&](const Plane& plane) { return plane.gap(x) <= 0; }) ||
           (!obstacles_.empty() && meets_obstacle({before(), x, t, dt}));
  }
  /// Whether, but for rounding, it is neither behind such a plane nor on one and moving into it.
  bool is_free(const Motion& motion, double t, double dt) const;
  /// How many such planes there are; below they have indices in the environment's order.
  std::size_t collisions() const { return colliding_.size() + obstacles_.size(); }
  /// Whether one of them moves, or a penalty's obstacle does, at a time or later.
  bool moves(double t) const;
  /// Applies the collisions of a step of dt that took a particle from `before` to `after`. False if nothing
  /// changed. Calls give(plane, dv) for every change of velocity.
  ///
  /// In a wedge one plane may push a particle into another, so all are applied again until none acts. From
  /// the second round on, a plane is skipped if the particle, but for rounding, is neither behind it nor
  /// moves towards it: that is where the plane has just put it. What begins the step behind a plane of the
  /// law `impulse` is pushed out slowly, see push_out_gap(), or `at_once`.
  template <class Give>
  bool collide(const Motion& before, double t, double dt, Motion& after, Give&& give,
               bool at_once = false) const {
    constexpr int most_rounds = 8;
    bool any = false;
    for (int round = 0; round < most_rounds; ++round) {
      bool changed = false;
      for (std::size_t p = 0; p < collisions(); ++p) {
        const Vec3 v = after.v;
        if ((round > 0 && is_free(p, after, t, dt)) || !apply(p, before, t, dt, at_once, after)) continue;
        give(p, Vec3(after.v - v));
        changed = true;
      }
      any |= changed;
      if (!changed || collisions() == 1) break;
    }
    return any;
  }
  /// The same for a particle that is free along some axes alone (1 in `free`): `after` is where collide() has
  /// taken it but along the others. What is left of the way out of planes, and of the velocity into them, is
  /// taken along the free part of their normals. `goal`: where collide() would have it. Calls give(plane,
  /// dv).
  template <class Give>
  void collide_held(const Vec3& free, double t, const Vec3& goal, Motion& after, Give&& give) const {
    constexpr double least = 1e-6;
    for (std::size_t p = 0; p < collisions(); ++p) {
      const auto& [plane, velocity, moved] = plane_at(p, goal, t);
      const Vec3 n = free.cwiseProduct(plane.normal);
      const double missing = std::min(0.0, plane.gap(goal)) - plane.gap(after.x);
      if (plane.contact != ContactLaw::impulse || n.norm() < least || !(missing > 1e-12 * cell_size_))
        continue;
      after.x += missing / n.squaredNorm() * n;
      const double into = plane.normal.dot(after.v - velocity);
      if (!(into < 0)) continue;
      const Vec3 dv = -into / n.squaredNorm() * n;
      after.v += dv;
      give(p, dv);
    }
  }
  /// The plane of the law `impulse` on which a particle at rest stays under an acceleration, if there is one.
  std::optional<std::size_t> sticks_to(const Vec3& x, double t, const Vec3& acceleration) const;

  std::size_t penalties() const { return penalties_.size() + pressing_.size(); }
  /// The plane on which a force [N] presses a particle most; none where it is on none, or pulled off.
  std::optional<std::size_t> carries(const Vec3& x, double t, const Vec3& force) const;

  /// Whether a penalty plane pushes what is at x.
  bool presses(const Vec3& x, double t) const {
    return std::any_of(penalties_.begin(), penalties_.end(),
                       [&](const Penalty& penalty) { return penalty.gap(x) < 0; }) ||
           std::any_of(pressing_.begin(), pressing_.end(),
                       [&](const Pressing& pressing) { return pressing.surface.gap(x, t) < 0; });
  }
  /// Force over mass of one of them, by index in the environment's order [m/s^2].
  Vec3 acceleration(std::size_t penalty, const Motion& motion, double t) const {
    const Penalty at = penalty_at(penalty, motion.x, t);
    return at.gap(motion.x) < 0 ? at.acceleration(motion) : Vec3(Vec3::Zero());
  }
  /// Sums over penalty planes: force over mass [m/s^2],
  Vec3 acceleration(const Motion& motion, double t) const;
  /// the tangent of a particle of that mass [kg],
  Eigen::Matrix3d tangent(const Motion& motion, double t, const TangentCoefficients& sum, double mass) const;
  /// and the springs' energy over mass [m^2/s^2], added to a potential.
  void add_potential(const Vec3& x, double t, double& over_mass) const;

  /// A bound on the spectrum of a body that may touch the penalty planes, from the body's own.
  SpectralBound with_penalties(SpectralBound body) const;

  /// For every penalty plane the smallest gap of a particle [m].
  template <class Real>
  std::vector<double> smallest_gaps(const std::vector<std::ptrdiff_t>& sites, const Field<Real>& x,
                                    double t) const {
    std::vector<double> smallest(penalties(), std::numeric_limits<double>::infinity());
    for (const std::ptrdiff_t site : sites) lower_gaps(x.at(site), t, smallest);
    return smallest;
  }
  /// The same of points.
  std::vector<double> smallest_gaps(const std::vector<Vec3>& points, double t) const {
    std::vector<double> smallest(penalties(), std::numeric_limits<double>::infinity());
    for (const Vec3& point : points) lower_gaps(point, t, smallest);
    return smallest;
  }

 private:
  /// An obstacle of the law `penalty`.
  struct Pressing {
    ObstacleSurface surface;
    Penalty penalty;  ///< on any plane
  };
  bool apply(std::size_t p, const Motion& before, double t, double dt, bool at_once, Motion& after) const {
    if (p >= colliding_.size())
      return apply(obstacles_[p - colliding_.size()], before, t, dt, at_once, after);
    const Plane& plane = colliding_[p];
    if (plane.contact == ContactLaw::thesis) return collide_thesis(plane, before, after);
    if (at_once) return collide_impulse(plane, before, dt, after);
    const double gap =
        push_out_gap(plane, before.x, push_out_rate * cell_size_, dt, behind_by_rounding * cell_size_);
    return gap < 0 ? push_out(plane, gap, after) : collide_impulse(plane, before, dt, after);
  }
  bool apply(const ObstacleSurface& obstacle, const Motion& before, double t, double dt, bool at_once,
             Motion& after) const;
  bool is_free(std::size_t p, const Motion& motion, double t, double dt) const {
    const double close = 1e-9 * cell_size_;
    const auto& [plane, velocity, moved] = plane_at(p, motion.x, t);
    return plane.gap(motion.x) > -close && plane.normal.dot(motion.v - velocity) * dt > -close;
  }
  bool meets_obstacle(const Way& way) const;
  /// A plane, or that where an obstacle is nearest to x.
  MovingPlane plane_at(std::size_t p, const Vec3& x, double t) const {
    if (p < colliding_.size()) return {colliding_[p]};
    return obstacles_[p - colliding_.size()].plane(x, t, 0);
  }
  Penalty penalty_at(std::size_t p, const Vec3& x, double t) const {
    if (p < penalties_.size()) return penalties_[p];
    const Pressing& pressing = pressing_[p - penalties_.size()];
    return pressing.penalty.on(pressing.surface.plane(x, t, 0));
  }
  /// Calls visit(penalty) for those that push what is at x.
  template <class Visit>
  void for_each_pressing(const Vec3& x, double t, Visit&& visit) const {
    for (const Penalty& penalty : penalties_)
      if (penalty.gap(x) < 0) visit(penalty);
    for (const Pressing& pressing : pressing_)
      if (pressing.surface.gap(x, t) < 0) visit(pressing.penalty.on(pressing.surface.plane(x, t, 0)));
  }
  void lower_gaps(const Vec3& x, double t, std::vector<double>& smallest) const;

  double omega_, cell_size_, fall_step_;
  std::vector<Plane> colliding_;
  std::vector<ObstacleSurface> obstacles_;  ///< that act at the end of steps
  std::vector<Penalty> penalties_;
  std::vector<Pressing> pressing_;
};

}  // namespace mss

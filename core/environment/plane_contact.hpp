#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

#include "core/environment/contact.hpp"

namespace mss {

/// The planes of an environment and what they do to one particle, or one vertex of a surface, each by its own
/// law (contact.hpp).
class PlaneContact {
 public:
  /// `body`: the spectrum of what collides, without planes; `cell_size` h [m].
  PlaneContact(const Environment& environment, const SpectralBound& body, double cell_size);

  /// True if planes act at the end of steps: those of the laws `impulse` and `thesis`.
  bool has_collisions() const { return !colliding_.empty(); }
  /// Longest step that resolves the motion of what collides, 2 over its angular frequency [s].
  double resolved_step() const { return 2 / omega_; }
  /// Longest step in which gravity moves what collides by no more than 1/4000 of a cell; infinite without it
  /// [s].
  double fall_step() const { return fall_step_; }
  /// True if planes act by forces: those of the law `penalty`.
  bool has_penalties() const { return !penalties_.empty(); }

  /// Whether a particle at x is behind or on a plane that acts at the end of steps: in front none does.
  bool touches(const Vec3& x) const {
    return std::any_of(colliding_.begin(), colliding_.end(),
                       [&](const Plane& plane) { return plane.gap(x) <= 0; });
  }
  /// Whether, but for rounding, it is neither behind such a plane nor on one and moving into it.
  bool is_free(const Motion& motion, double dt) const;
  /// How many such planes there are; below they have indices in the environment's order.
  std::size_t collisions() const { return colliding_.size(); }
  /// Applies the collisions of a step of dt that took a particle from `before` to `after`. False if nothing
  /// changed. Calls give(plane, dv) for every change of velocity.
  ///
  /// In a wedge one plane may push a particle into another, so all are applied again until none acts. From
  /// the second round on, a plane is skipped if the particle, but for rounding, is neither behind it nor
  /// moves towards it: that is where the plane has just put it. What begins the step behind a plane of the
  /// law `impulse` is pushed out slowly, see push_out_gap(), or `at_once`.
  template <class Give>
  bool collide(const Motion& before, double dt, Motion& after, Give&& give, bool at_once = false) const {
    constexpr int most_rounds = 8;
    bool any = false;
    for (int round = 0; round < most_rounds; ++round) {
      bool changed = false;
      for (std::size_t p = 0; p < colliding_.size(); ++p) {
        const Vec3 v = after.v;
        if ((round > 0 && is_free(colliding_[p], after, dt)) ||
            !apply(colliding_[p], before, dt, at_once, after))
          continue;
        give(p, Vec3(after.v - v));
        changed = true;
      }
      any |= changed;
      if (!changed || colliding_.size() == 1) break;
    }
    return any;
  }
  /// The same for a particle that is free along some axes alone (1 in `free`): `after` is where collide() has
  /// taken it but along the others. What is left of the way out of planes, and of the velocity into them, is
  /// taken along the free part of their normals. `goal`: where collide() would have it. Calls give(plane,
  /// dv).
  template <class Give>
  void collide_held(const Vec3& free, const Vec3& goal, Motion& after, Give&& give) const {
    constexpr double least = 1e-6;
    for (std::size_t p = 0; p < colliding_.size(); ++p) {
      const Plane& plane = colliding_[p];
      const Vec3 n = free.cwiseProduct(plane.normal);
      const double missing = std::min(0.0, plane.gap(goal)) - plane.gap(after.x);
      if (plane.contact != ContactLaw::impulse || n.norm() < least || !(missing > 1e-12 * cell_size_))
        continue;
      after.x += missing / n.squaredNorm() * n;
      const double into = plane.normal.dot(after.v);
      if (!(into < 0)) continue;
      const Vec3 dv = -into / n.squaredNorm() * n;
      after.v += dv;
      give(p, dv);
    }
  }
  /// The plane of the law `impulse` on which a particle at rest stays under an acceleration, if there is one.
  std::optional<std::size_t> sticks_to(const Vec3& x, const Vec3& acceleration) const;

  std::size_t penalties() const { return penalties_.size(); }
  /// The plane on which a force [N] presses a particle most; none where it is on none, or pulled off.
  std::optional<std::size_t> carries(const Vec3& x, const Vec3& force) const;

  /// Whether a penalty plane pushes what is at x.
  bool presses(const Vec3& x) const {
    return std::any_of(penalties_.begin(), penalties_.end(),
                       [&](const Penalty& penalty) { return penalty.gap(x) < 0; });
  }
  /// Force over mass of one of them, by index in the environment's order [m/s^2].
  Vec3 acceleration(std::size_t penalty, const Motion& motion) const {
    return penalties_[penalty].gap(motion.x) < 0 ? penalties_[penalty].acceleration(motion)
                                                 : Vec3(Vec3::Zero());
  }
  /// Sums over penalty planes: force over mass [m/s^2],
  Vec3 acceleration(const Motion& motion) const;
  /// the tangent of a particle of that mass [kg],
  Eigen::Matrix3d tangent(const Motion& motion, const TangentCoefficients& sum, double mass) const;
  /// and the springs' energy over mass [m^2/s^2], added to a potential.
  void add_potential(const Vec3& x, double& over_mass) const;

  /// A bound on the spectrum of a body that may touch the penalty planes, from the body's own.
  SpectralBound with_penalties(SpectralBound body) const;

  /// For every penalty plane the smallest gap of a particle [m].
  template <class Real>
  std::vector<double> smallest_gaps(const std::vector<std::ptrdiff_t>& sites, const Field<Real>& x) const {
    std::vector<double> smallest(penalties_.size(), std::numeric_limits<double>::infinity());
    for (const std::ptrdiff_t site : sites)
      for (std::size_t p = 0; p < penalties_.size(); ++p)
        smallest[p] = std::min(smallest[p], penalties_[p].gap(x.at(site)));
    return smallest;
  }
  /// The same of points.
  std::vector<double> smallest_gaps(const std::vector<Vec3>& points) const {
    std::vector<double> smallest(penalties_.size(), std::numeric_limits<double>::infinity());
    for (const Vec3& point : points)
      for (std::size_t p = 0; p < penalties_.size(); ++p)
        smallest[p] = std::min(smallest[p], penalties_[p].gap(point));
    return smallest;
  }

 private:
  bool apply(const Plane& plane, const Motion& before, double dt, bool at_once, Motion& after) const {
    if (plane.contact == ContactLaw::thesis) return collide_thesis(plane, before, after);
    if (at_once) return collide_impulse(plane, before, dt, after);
    const double gap =
        push_out_gap(plane, before.x, push_out_rate * cell_size_, dt, behind_by_rounding * cell_size_);
    return gap < 0 ? push_out(plane, gap, after) : collide_impulse(plane, before, dt, after);
  }
  bool is_free(const Plane& plane, const Motion& motion, double dt) const {
    const double close = 1e-9 * cell_size_;
    return plane.gap(motion.x) > -close && plane.normal.dot(motion.v) * dt > -close;
  }

  double omega_, cell_size_, fall_step_;
  std::vector<Plane> colliding_;
  std::vector<Penalty> penalties_;
};

}  // namespace mss

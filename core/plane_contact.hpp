#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "core/contact.hpp"

namespace mss {

/// The planes of an environment and what they do to one particle, or one vertex of a surface, each by its own
/// law (contact.hpp).
class PlaneContact {
 public:
  /// `body`: the spectrum of what collides, without planes; `cell_size` h [m].
  PlaneContact(const Environment& environment, const SpectralBound& body, double cell_size);

  /// True if planes act at the end of steps: those of the laws `impulse` and `thesis`.
  bool has_collisions() const { return !colliding_.empty(); }
  /// True if planes act by forces: those of the law `penalty`.
  bool has_penalties() const { return !penalties_.empty(); }

  /// Whether a particle at x is behind or on a plane that acts at the end of steps: in front none does.
  bool touches(const Vec3& x) const {
    return std::any_of(colliding_.begin(), colliding_.end(),
                       [&](const Plane& plane) { return plane.gap(x) <= 0; });
  }
  /// Whether, but for rounding, it is neither behind such a plane nor on one and moving into it.
  bool is_free(const Motion& motion, double dt) const;
  /// Applies the collisions of a step of dt that took a particle from `before` to `after`. False if nothing
  /// changed.
  bool collide(const Motion& before, double dt, Motion& after) const;
  /// Whether a particle at rest on a plane of the law `impulse` stays there under an acceleration.
  bool sticks(const Motion& motion, const Vec3& acceleration) const;

  /// Whether a penalty plane pushes what is at x.
  bool presses(const Vec3& x) const {
    return std::any_of(penalties_.begin(), penalties_.end(),
                       [&](const Penalty& penalty) { return penalty.gap(x) < 0; });
  }
  /// Sums over penalty planes: force over mass [m/s^2],
  Vec3 acceleration(const Motion& motion) const;
  /// the tangent of a particle of that mass [kg],
  Eigen::Matrix3d tangent(const Motion& motion, const TangentSum& sum, double mass) const;
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
  double cell_size_;
  std::vector<Plane> colliding_;
  std::vector<Penalty> penalties_;
};

}  // namespace mss

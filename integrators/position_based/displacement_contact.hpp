#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "core/base/record.hpp"
#include "core/base/state.hpp"
#include "core/body/body.hpp"
#include "core/environment/plane_bounds.hpp"
#include "core/kernels/sweep.hpp"
#include "core/system/plane_impulses.hpp"

namespace mss {

/// Contact inside the passes of a method whose unknowns are displacements u = x - x_n: every particle near a
/// plane keeps the impulses that planes have given it in the step, times the step, as multipliers [kg m].
/// After every colour, along a plane's normal,
///   lam_n = max(0, lam_n - gap / w),   lam_t = cut(lam_t - u_t / w, mu lam_n),   u += w (change of lam),
/// with w the particle's inverse mass: the particle leaves the plane if it pulls, and sticks while the
/// impulse that this takes lies in Coulomb's cone. Mueller et al., Detailed rigid body simulation with
/// extended position-based dynamics, CGF 39 (2020) 101, with cut() after the sum of all passes in place of
/// each.
template <class Real>
class DisplacementContact {
 public:
  /// All must outlive it. The method's arrays have `size` numbers; `index`: of every particle in them. What
  /// planes give is added to `impulses`, unless that is nullptr.
  DisplacementContact(const PlaneBounds& bounds, const Body& body, std::ptrdiff_t size,
                      const std::vector<std::ptrdiff_t>& index, PlaneImpulses* impulses);

  /// Begins a step of dt that ends at time t, from x: multipliers are zero. Particles within a cell's size of
  /// a plane, now or where u takes them, are near it. `v`: velocities at its beginning.
  void begin_step(double t, double dt, const ConstStreams<Real>& x, const ConstStreams<Real>& v,
                  const ConstStreams<Real>& u);
  /// Whether a plane has pushed a particle since the last step began.
  bool pushes() const;
  /// The plane that a particle comes to in this step, faster than gravity makes it in two, while no plane
  /// pushed it in the step before; nothing: none.
  std::optional<Plane> impact(double dt) const;
  /// Applies planes to the particles near them whose z is `first` or the next.
  void project(int first, const ConstStreams<Real>& x, const Streams<Real>& u);
  /// To all.
  void project(const ConstStreams<Real>& x, const Streams<Real>& u);
  /// Moves any particle that is behind a plane nonetheless onto it.
  void put_in_front(const ConstStreams<Real>& x, const Streams<Real>& u);
  /// The same at the end of the passes of a step of dt; multipliers are impulses then.
  void end_passes(double dt, const ConstStreams<Real>& x, const Streams<Real>& u);
  /// After velocities have followed from a step: what a plane has stopped leaves it as restitution says.
  void rebound(const FreeStep& step, State<Real>& state) const;
  /// Which particles planes have pushed since the last step began. See core/base/record.hpp.
  void remember(Record& record);

  /// A particle near a plane.
  struct Near {
    std::size_t particle;
    std::ptrdiff_t index;
    Vec3 inverse_mass;               ///< by axis [1/kg]
    std::vector<double> normal{};    ///< multipliers, by plane
    std::vector<Vec3> tangential{};  ///< along free axes
    std::vector<double> gap{};       ///< that planes ask for, 0 or less [m]
    std::vector<MovingPlane> met{};  ///< obstacles', in this step
    Motion before{};                 ///< at the beginning of the step
    bool was_pushed = false;         ///< in the step before
  };
  /// The particle at an index; nullptr if it is not near a plane.
  Near* near(std::ptrdiff_t index) const { return near_at_[std::size_t(index)]; }
  /// By what an index bounds a particle in this step.
  MovingPlane plane(const Near& near, std::size_t p) const {
    const std::size_t planes = bounds_.planes().size();
    return p < planes ? MovingPlane{bounds_.planes()[p]} : near.met[p - planes];
  }
  /// The same of all indices; `scratch` is where they are, if there are obstacles.
  const std::vector<Plane>& planes(const Near& near, std::vector<Plane>& scratch) const {
    if (near.met.empty()) return bounds_.planes();
    scratch = bounds_.planes();
    for (const MovingPlane& met : near.met) scratch.push_back(met.plane);
    return scratch;
  }
  /// How far what touches a particle at x has come in this step: the nearest obstacle, or a plane, which
  /// rests.
  Vec3 way(const Near& near, const Vec3& x) const {
    MovingPlane nearest;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t p = 0; !near.met.empty() && p < bounds_.size(); ++p) {
      const MovingPlane met = plane(near, p);
      if (const double gap = met.plane.gap(x) - near.gap[p]; gap < least) least = gap, nearest = met;
    }
    return nearest.moved;
  }

 private:
  static bool is_pushed(const Near& near);
  /// Calls moved(particle, plane, by) for every move.
  template <class Moved>
  void move_in_front(const ConstStreams<Real>& x, const Streams<Real>& u, Moved&& moved);
  void project(Near& near, const ConstStreams<Real>& x, const Streams<Real>& u) const;
  void project(Near& near, std::size_t plane, const Vec3& x, Vec3& u) const;

  const PlaneBounds& bounds_;
  double t_ = 0, dt_ = 0;
  const Body& body_;
  const std::vector<std::ptrdiff_t>& index_;
  PlaneImpulses* impulses_;
  std::vector<Vec3> inverse_masses_;           ///< of every particle
  std::vector<std::vector<Near>> near_;        ///< by z
  std::vector<Near*> near_at_;                 ///< by index
  std::vector<std::ptrdiff_t> pushed_before_;  ///< indices
};

}  // namespace mss

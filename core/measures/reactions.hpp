#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/environment/obstacle.hpp"
#include "core/springs/solid_system.hpp"

namespace mss {

/// Forces by which boundary conditions, planes and obstacles act on a body [N], in the environment's order.
struct Reactions {
  std::vector<Vec3> holds{}, planes{}, obstacles{};
  std::vector<Vec3> torques{};  ///< of obstacles about their centres [N m]

  bool is_finite() const;
  /// See core/base/record.hpp.
  void remember(Record& record);
};

/// Calls visit(name, force) for each as files name them: hold_0, ... plane_0, ... obstacle_0,
/// obstacle_0_torque, ...
void for_each(const Reactions& reactions, const std::function<void(const std::string&, const Vec3&)>& visit);

/// Calls visit(name, number [N]) for each of their components: hold_0_x, hold_0_y, hold_0_z, ...
void for_each_component(const Reactions& reactions,
                        const std::function<void(const std::string&, double)>& visit);

/// Finds the reactions on a solid.
///
/// A hold's are those of the moment: what it takes to move its particles as it prescribes against the forces
/// on them. A particle of several holds counts for the one that it obeys. A penalty plane's are the forces of
/// the moment too. Other planes act by impulses: their forces are means since begin(), zero if no time has
/// passed. So it is with obstacles; the torques of impulses are those that they would have where the
/// particles are now.
template <class Real>
class ReactionGauge {
 public:
  /// The system must outlive it; `environment` is the system's.
  ReactionGauge(SolidSystem<Real>& system, const Environment& environment);

  /// Means begin at time t [s].
  void begin(double t);
  /// The reactions at a state, which may also be of a system that wraps the gauge's and adds forces. All
  /// ranks must call it.
  Reactions read(System<Real>& driven, const State<Real>& state);
  /// See core/base/record.hpp.
  void remember(Record& record);

 private:
  void add_holds(System<Real>& driven, const State<Real>& state, std::vector<Vec3>& forces);
  std::vector<Vec3> impulses() const;
  std::vector<Wrench> penalties(const State<Real>& state) const;
  Vec3 mean_torque(std::size_t impulse, const Vec3& about, const State<Real>& state) const;
  void keep_given();

  SolidSystem<Real>& system_;
  std::vector<ContactLaw> laws_;            ///< by plane, then by obstacle
  std::vector<ObstacleSurface> obstacles_;  ///< the last of these
  std::size_t holds_;
  HeldSites held_;
  Field<Real> force_;
  double begun_ = 0;                       ///< [s]
  std::vector<Vec3> given_{};              ///< until then, by plane that acts by impulses [N s]
  std::vector<Field<double>> given_at_{};  ///< the same by site, of obstacles alone
};

}  // namespace mss

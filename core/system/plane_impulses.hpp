#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/field.hpp"

namespace mss {

class Record;

/// What planes of the laws `impulse` and `thesis` have given the particles of a body in all steps so far:
/// impulses [N s], by plane in the environment's order, and by site, so that sums do not depend on threads.
/// They are never set back; those of a while are a difference. Along held axes planes give nothing: there
/// the hold carries the particle.
///
/// Functions of a site may be called for different sites at once.
class PlaneImpulses {
 public:
  PlaneImpulses(std::size_t planes, std::ptrdiff_t sites);

  std::size_t planes() const { return given_.size(); }
  /// The impulse of a plane on the particle at a site [N s].
  Vec3 at(std::size_t plane, std::ptrdiff_t site) const;

  void add(std::size_t plane, std::ptrdiff_t site, const Vec3& impulse) {
    given_[plane].set(site, given_[plane].at(site) + impulse);
  }

  /// What sticks to a plane when accelerations are evaluated has none, because the plane holds it by a force
  /// [N]: it does until the next evaluation, while velocities change,
  void hold(std::size_t plane, std::ptrdiff_t site, const Vec3& force);
  void let_go(std::ptrdiff_t site) {
    if (held_by_[std::size_t(site)] != nothing) finish(site);
  }
  /// namely for so long [s]. A method need not say that if its steps have one acceleration.
  void hold_for(double seconds);
  /// Ends a step of dt [s].
  void end_step(double dt);
  /// See core/base/record.hpp.
  void remember(Record& record);

 private:
  static constexpr std::uint32_t nothing = UINT32_MAX;
  Vec3 pending(std::ptrdiff_t site) const {
    return (kicked_ - held_since_[std::size_t(site)]) * force_.at(site);
  }
  void finish(std::ptrdiff_t site);

  std::vector<Field<double>> given_;
  Field<double> force_;                 ///< on what is held
  std::vector<std::uint32_t> held_by_;  ///< plane, by site
  std::vector<double> held_since_;      ///< by the clock below, by site
  double kicked_ = 0;                   ///< for how long accelerations have changed velocities [s]
  bool is_told_ = false;                ///< in this step
};

}  // namespace mss

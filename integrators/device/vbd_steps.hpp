#pragma once

#include "core/base/record.hpp"
#include "integrators/device/displaced_steps.hpp"

namespace mss {

/// Steps of vertex block descent, see integrators/position_based/vbd.cpp: particles in the order in which
/// VbdSolver moves them, from its guesses, with its semi-iteration.
template <class Real>
class VbdSteps final : public DisplacedSteps<Real> {
 public:
  explicit VbdSteps(const IntegratorOptions& options);
  void begin(DeviceSystem<Real>& system) override;
  void reset() override { has_step_before_ = false; }
  void remember(DeviceSystem<Real>& system, Record& record) override;

 private:
  using Vectors = typename DeviceSystem<Real>::Vectors;

  void displace(DeviceSystem<Real>& system, double t) override;
  void begin_passes(DeviceSystem<Real>& system) override;
  void pass(DeviceSystem<Real>& system) override;
  void descend(DeviceSystem<Real>& system);
  void shorten_guess(DeviceSystem<Real>& system, const Vec3& normal);
  double objective(const SpringSystem<Real>& springs, const Field<Real>& x, const Field<Real>& target,
                   const Field<Real>& u) const;

  double squared_radius_;  ///< of a pass
  double weight_ = 1;      ///< w_k of Chebyshev's semi-iteration
  int passes_done_ = 0;    ///< of this step
  std::optional<SitesByColour> particles_;
  DeviceMemory particle_list_;
  Vectors target_, drift_;  ///< drift_: dt v of the step before
  bool has_step_before_ = false;
  Vectors last_, one_before_;  ///< u_{k-1}, u_{k-2}
};

}  // namespace mss

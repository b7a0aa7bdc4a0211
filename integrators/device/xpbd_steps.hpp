#pragma once

#include "integrators/device/displaced_steps.hpp"

namespace mss {

/// Steps of XPBD, see integrators/position_based/xpbd.cpp: springs and cells as compliant constraints, in the
/// order in which XpbdSolver projects them.
template <class Real>
class XpbdSteps final : public DisplacedSteps<Real> {
 public:
  explicit XpbdSteps(const IntegratorOptions& options);
  void begin(DeviceSystem<Real>& system) override;

 private:
  void displace(DeviceSystem<Real>& system, double t) override;
  void begin_passes(DeviceSystem<Real>& system) override;
  void pass(DeviceSystem<Real>& system) override;

  bool keeps_multipliers_;
  std::optional<SitesByColour> cells_;
  DeviceMemory cell_list_, constraints_, multipliers_;
};

}  // namespace mss

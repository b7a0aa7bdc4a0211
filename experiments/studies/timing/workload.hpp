#pragma once

#include "core/body/body.hpp"

namespace mss::studies::timing {

/// The workload: a full cube of this edge and material, whatever the number of cells.
struct TimingWorkload {
  static constexpr double edge = 1;        ///< [m]
  static constexpr double density = 1000;  ///< [kg/m^3]
  static constexpr ElasticConstants material{.young = 1e5, .poisson = 0.3};
  static constexpr double face_share = 0.5;
  static constexpr double damping_ratio = 0.05;
  static constexpr double gravity = -9.81;  ///< along z [m/s^2]
  static constexpr double stretch = 1.01;   ///< of the initial state along z, so that springs are loaded
  static constexpr double dt = 1e-5;        ///< [s]; a fiftieth of the stability limit at n = 100
};

/// The body of the workload with n cells per edge.
BodyConfig timing_cube(int n);

}  // namespace mss::studies::timing

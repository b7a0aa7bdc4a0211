// Apart from the study, so that the debug build of the thesis's loops is of the same body.
#include "experiments/studies/timing/workload.hpp"

namespace mss::studies::timing {

BodyConfig timing_cube(int n) {
  const double h = TimingWorkload::edge / n;
  return {.voxels = VoxelGrid::box(n, n, n),
          .cell_size = h,
          .density = TimingWorkload::density,
          .springs = calibrate(TimingWorkload::material, h, TimingWorkload::face_share),
          .damping = {.law = Damping::Law::ratio, .zeta = TimingWorkload::damping_ratio}};
}

}  // namespace mss::studies::timing

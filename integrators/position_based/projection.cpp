#include "integrators/position_based/projection.hpp"

#include "core/kernels/instruction_sets.hpp"

namespace mss {

// projection_baseline.cpp, projection_v3.cpp and projection_v4.cpp
template <class Real>
ProjectionKernel<Real> projection_baseline();
template <class Real>
ProjectionKernel<Real> projection_v3();
template <class Real>
ProjectionKernel<Real> projection_v4();

template <class Real>
const std::vector<ProjectionKernel<Real>>& projection_kernels() {
  static const std::vector<ProjectionKernel<Real>> kernels =
      runnable_copies(projection_baseline<Real>, projection_v3<Real>, projection_v4<Real>);
  return kernels;
}

template const std::vector<ProjectionKernel<float>>& projection_kernels();
template const std::vector<ProjectionKernel<double>>& projection_kernels();

}  // namespace mss

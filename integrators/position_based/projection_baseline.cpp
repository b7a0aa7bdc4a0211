// One copy of the projection; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_baseline
#include "integrators/position_based/projection_kernel.hpp"

namespace mss {

template <class Real>
ProjectionKernel<Real> projection_baseline() {
  return MSS_ISA::make_projection_kernel<Real>("baseline");
}
template ProjectionKernel<float> projection_baseline();
template ProjectionKernel<double> projection_baseline();

}  // namespace mss

// One copy of the projection; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_v3
#include "integrators/position_based/projection_kernel.hpp"

namespace mss {

template <class Real>
ProjectionKernel<Real> projection_v3() {
  return MSS_ISA::make_projection_kernel<Real>("x86-64-v3");
}
template ProjectionKernel<float> projection_v3();
template ProjectionKernel<double> projection_v3();

}  // namespace mss

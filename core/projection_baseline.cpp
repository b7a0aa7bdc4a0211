// One copy of the projection; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_baseline
#include "core/projection_kernel.hpp"

namespace mss {

ProjectionKernel<float> projection_baseline_float() {
  return MSS_ISA::make_projection_kernel<float>("baseline");
}
ProjectionKernel<double> projection_baseline_double() {
  return MSS_ISA::make_projection_kernel<double>("baseline");
}

}  // namespace mss

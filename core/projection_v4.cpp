// One copy of the projection; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_v4
#include "core/projection_kernel.hpp"

namespace mss {

ProjectionKernel<float> projection_v4_float() { return MSS_ISA::make_projection_kernel<float>("x86-64-v4"); }
ProjectionKernel<double> projection_v4_double() {
  return MSS_ISA::make_projection_kernel<double>("x86-64-v4");
}

}  // namespace mss

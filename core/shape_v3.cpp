// One copy of the loops of shape matching; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_v3
#include "core/shape_kernel.hpp"

namespace mss {

ShapeKernel<float> shape_v3_float() { return MSS_ISA::make_shape_kernel<float>("x86-64-v3"); }
ShapeKernel<double> shape_v3_double() { return MSS_ISA::make_shape_kernel<double>("x86-64-v3"); }

}  // namespace mss

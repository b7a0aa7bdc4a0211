// One copy of the loops of shape matching; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_v4
#include "core/shape_kernel.hpp"

namespace mss {

ShapeKernel<float> shape_v4_float() { return MSS_ISA::make_shape_kernel<float>("x86-64-v4"); }
ShapeKernel<double> shape_v4_double() { return MSS_ISA::make_shape_kernel<double>("x86-64-v4"); }

}  // namespace mss

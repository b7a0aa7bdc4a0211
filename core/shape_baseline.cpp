// One copy of the loops of shape matching; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_baseline
#include "core/shape_kernel.hpp"

namespace mss {

ShapeKernel<float> shape_baseline_float() { return MSS_ISA::make_shape_kernel<float>("baseline"); }
ShapeKernel<double> shape_baseline_double() { return MSS_ISA::make_shape_kernel<double>("baseline"); }

}  // namespace mss

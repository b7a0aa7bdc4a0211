// One copy of the loops of shape matching; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_v4
#include "integrators/position_based/shape_kernel.hpp"

namespace mss {

ShapeKernel shape_v4() { return MSS_ISA::make_shape_kernel("x86-64-v4"); }

}  // namespace mss

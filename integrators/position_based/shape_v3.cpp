// One copy of the loops of shape matching; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_v3
#include "integrators/position_based/shape_kernel.hpp"

namespace mss {

ShapeKernel shape_v3() { return MSS_ISA::make_shape_kernel("x86-64-v3"); }

}  // namespace mss

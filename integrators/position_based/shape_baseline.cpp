// One copy of the loops of shape matching; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_baseline
#include "integrators/position_based/shape_kernel.hpp"

namespace mss {

ShapeKernel shape_baseline() { return MSS_ISA::make_shape_kernel("baseline"); }

}  // namespace mss

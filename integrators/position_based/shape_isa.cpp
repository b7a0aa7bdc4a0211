// Compiled once per instruction set, see core/kernels/dispatch.hpp.
#include "integrators/position_based/shape_loops.hpp"

namespace mss {

template <>
ShapeKernel kernel_copy<ShapeKernel, InstructionSet::MSS_INSTRUCTION_SET>() {
  return MSS_ISA::make_shape_kernel(MSS_ISA_NAME);
}

}  // namespace mss

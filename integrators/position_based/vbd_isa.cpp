// Compiled once per instruction set and precision, see core/kernels/dispatch.hpp.
#include "integrators/position_based/vbd_loops.hpp"

namespace mss {

template <>
VbdKernel<MSS_REAL> kernel_copy<VbdKernel<MSS_REAL>, InstructionSet::MSS_INSTRUCTION_SET>() {
  return MSS_ISA::make_vbd_kernel<MSS_REAL>(MSS_ISA_NAME);
}

}  // namespace mss

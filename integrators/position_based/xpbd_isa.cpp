// Compiled once per instruction set and precision, see core/kernels/dispatch.hpp.
#include "integrators/position_based/xpbd_loops.hpp"

namespace mss {

template <>
XpbdKernel<MSS_REAL> kernel_copy<XpbdKernel<MSS_REAL>, InstructionSet::MSS_INSTRUCTION_SET>() {
  return MSS_ISA::make_xpbd_kernel<MSS_REAL>(MSS_ISA_NAME);
}

}  // namespace mss

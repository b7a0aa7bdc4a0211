// Compiled once per instruction set and precision, see core/kernels/dispatch.hpp.
#include "core/kernels/sweep_loops.hpp"

namespace mss {

template <>
SweepKernel<MSS_REAL> kernel_copy<SweepKernel<MSS_REAL>, InstructionSet::MSS_INSTRUCTION_SET>() {
  return MSS_ISA::make_sweep_kernel<MSS_REAL>(MSS_ISA_NAME);
}

}  // namespace mss

// Compiled once per instruction set, see core/kernels/dispatch.hpp.
#include "integrators/reduction/reduction_loops.hpp"

namespace mss {

template <>
ReductionKernels kernel_copy<ReductionKernels, InstructionSet::MSS_INSTRUCTION_SET>() {
  return MSS_ISA::make_reduction_kernels(MSS_ISA_NAME);
}

}  // namespace mss

// Compiled once per instruction set, see core/kernels/dispatch.hpp.
#include "integrators/linear/rest_loops.hpp"

namespace mss {

template <>
RestKernels kernel_copy<RestKernels, InstructionSet::MSS_INSTRUCTION_SET>() {
  return MSS_ISA::make_rest_kernels(MSS_ISA_NAME);
}

}  // namespace mss

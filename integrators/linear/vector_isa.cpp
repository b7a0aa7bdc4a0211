// Compiled once per instruction set, see core/kernels/dispatch.hpp.
#include "integrators/linear/vector_loops.hpp"

namespace mss {

template <>
VectorKernels kernel_copy<VectorKernels, InstructionSet::MSS_INSTRUCTION_SET>() {
  return MSS_ISA::make_vector_kernels(MSS_ISA_NAME);
}

}  // namespace mss

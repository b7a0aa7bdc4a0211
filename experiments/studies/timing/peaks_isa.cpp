// Compiled once per instruction set, see core/kernels/dispatch.hpp.
#include "experiments/studies/timing/peak_loops.hpp"

namespace mss {

template <>
studies::timing::PeakLoops kernel_copy<studies::timing::PeakLoops, InstructionSet::MSS_INSTRUCTION_SET>() {
  return MSS_ISA::make_peak_loops(MSS_ISA_NAME);
}

}  // namespace mss

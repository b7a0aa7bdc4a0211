// One copy of the loops; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_v3
#include "experiments/studies/timing/peak_kernel.hpp"

namespace mss::studies::timing {

PeakLoops peaks_v3() { return MSS_ISA::make_peak_loops("x86-64-v3"); }

}  // namespace mss::studies::timing

// One copy of the loops; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_v4
#include "experiments/studies/timing/peak_kernel.hpp"

namespace mss::studies::timing {

PeakLoops peaks_v4() { return MSS_ISA::make_peak_loops("x86-64-v4"); }

}  // namespace mss::studies::timing

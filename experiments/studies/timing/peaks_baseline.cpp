// One copy of the loops; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_baseline
#include "experiments/studies/timing/peak_kernel.hpp"

namespace mss::studies::timing {

PeakLoops peaks_baseline() { return MSS_ISA::make_peak_loops("baseline"); }

}  // namespace mss::studies::timing

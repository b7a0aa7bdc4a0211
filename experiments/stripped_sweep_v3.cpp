// CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA stripped_v3
#include "experiments/stripped_sweep_isa.hpp"

namespace mss {

Sweep<float> stripped_v3_float(Stripped of) { return MSS_ISA::stripped_sweep<float>(of); }
Sweep<double> stripped_v3_double(Stripped of) { return MSS_ISA::stripped_sweep<double>(of); }

}  // namespace mss

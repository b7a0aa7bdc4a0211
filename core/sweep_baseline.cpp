// One copy of the sweep; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_baseline
#include "core/sweep_kernel.hpp"

namespace mss {

SweepKernel<float> sweep_baseline_float() { return MSS_ISA::make_kernel<float>("baseline"); }
SweepKernel<double> sweep_baseline_double() { return MSS_ISA::make_kernel<double>("baseline"); }

}  // namespace mss

// One copy of the sweep; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_v3
#include "core/sweep_kernel.hpp"

namespace mss {

SweepKernel<float> sweep_v3_float() { return MSS_ISA::make_kernel<float>("x86-64-v3"); }
SweepKernel<double> sweep_v3_double() { return MSS_ISA::make_kernel<double>("x86-64-v3"); }

}  // namespace mss

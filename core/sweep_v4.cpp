// One copy of the sweep; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_v4
#include "core/sweep_kernel.hpp"

namespace mss {

SweepKernel<float> sweep_v4_float() { return MSS_ISA::make_kernel<float>("x86-64-v4"); }
SweepKernel<double> sweep_v4_double() { return MSS_ISA::make_kernel<double>("x86-64-v4"); }

}  // namespace mss

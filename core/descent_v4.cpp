// One copy of the descent; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_v4
#include "core/descent_kernel.hpp"

namespace mss {

DescentKernel<float> descent_v4_float() { return MSS_ISA::make_descent_kernel<float>("x86-64-v4"); }
DescentKernel<double> descent_v4_double() { return MSS_ISA::make_descent_kernel<double>("x86-64-v4"); }

}  // namespace mss

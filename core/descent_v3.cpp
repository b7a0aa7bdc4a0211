// One copy of the descent; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_v3
#include "core/descent_kernel.hpp"

namespace mss {

DescentKernel<float> descent_v3_float() { return MSS_ISA::make_descent_kernel<float>("x86-64-v3"); }
DescentKernel<double> descent_v3_double() { return MSS_ISA::make_descent_kernel<double>("x86-64-v3"); }

}  // namespace mss

// One copy of the descent; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_baseline
#include "core/descent_kernel.hpp"

namespace mss {

DescentKernel<float> descent_baseline_float() { return MSS_ISA::make_descent_kernel<float>("baseline"); }
DescentKernel<double> descent_baseline_double() { return MSS_ISA::make_descent_kernel<double>("baseline"); }

}  // namespace mss

// One copy of the descent; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_v3
#include "integrators/position_based/descent_kernel.hpp"

namespace mss {

template <class Real>
DescentKernel<Real> descent_v3() {
  return MSS_ISA::make_descent_kernel<Real>("x86-64-v3");
}
template DescentKernel<float> descent_v3();
template DescentKernel<double> descent_v3();

}  // namespace mss

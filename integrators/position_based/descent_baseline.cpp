// One copy of the descent; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_baseline
#include "integrators/position_based/descent_kernel.hpp"

namespace mss {

template <class Real>
DescentKernel<Real> descent_baseline() {
  return MSS_ISA::make_descent_kernel<Real>("baseline");
}
template DescentKernel<float> descent_baseline();
template DescentKernel<double> descent_baseline();

}  // namespace mss

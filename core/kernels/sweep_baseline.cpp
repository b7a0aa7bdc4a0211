// One copy of the sweep; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_baseline
#include "core/kernels/sweep_kernel.hpp"

namespace mss {

template <class Real>
SweepKernel<Real> sweep_baseline() {
  return MSS_ISA::make_kernel<Real>("baseline");
}
template SweepKernel<float> sweep_baseline();
template SweepKernel<double> sweep_baseline();

}  // namespace mss

// One copy of the sweep; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_v4
#include "core/kernels/sweep_kernel.hpp"

namespace mss {

template <class Real>
SweepKernel<Real> sweep_v4() {
  return MSS_ISA::make_kernel<Real>("x86-64-v4");
}
template SweepKernel<float> sweep_v4();
template SweepKernel<double> sweep_v4();

}  // namespace mss

#include "integrators/position_based/descent.hpp"

#include "core/kernels/instruction_sets.hpp"

namespace mss {

// descent_baseline.cpp, descent_v3.cpp and descent_v4.cpp
template <class Real>
DescentKernel<Real> descent_baseline();
template <class Real>
DescentKernel<Real> descent_v3();
template <class Real>
DescentKernel<Real> descent_v4();

template <class Real>
const std::vector<DescentKernel<Real>>& descent_kernels() {
  static const std::vector<DescentKernel<Real>> kernels =
      runnable_copies(descent_baseline<Real>, descent_v3<Real>, descent_v4<Real>);
  return kernels;
}

template const std::vector<DescentKernel<float>>& descent_kernels();
template const std::vector<DescentKernel<double>>& descent_kernels();

}  // namespace mss

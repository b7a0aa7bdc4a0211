#include "core/kernels/sweep.hpp"

#include "core/kernels/instruction_sets.hpp"

namespace mss {

// sweep_baseline.cpp, sweep_v3.cpp and sweep_v4.cpp
template <class Real>
SweepKernel<Real> sweep_baseline();
template <class Real>
SweepKernel<Real> sweep_v3();
template <class Real>
SweepKernel<Real> sweep_v4();

template <class Real>
const std::vector<SweepKernel<Real>>& sweep_kernels() {
  static const std::vector<SweepKernel<Real>> kernels =
      runnable_copies(sweep_baseline<Real>, sweep_v3<Real>, sweep_v4<Real>);
  return kernels;
}

template const std::vector<SweepKernel<float>>& sweep_kernels();
template const std::vector<SweepKernel<double>>& sweep_kernels();

}  // namespace mss

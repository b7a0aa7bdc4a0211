#include "core/sweep.hpp"

#include <type_traits>

namespace mss {

SweepKernel<float> sweep_baseline_float();
SweepKernel<double> sweep_baseline_double();
#if defined(__x86_64__)
SweepKernel<float> sweep_v3_float();
SweepKernel<double> sweep_v3_double();
SweepKernel<float> sweep_v4_float();
SweepKernel<double> sweep_v4_double();
#endif

namespace {

template <class Real>
SweepKernel<Real> choose(SweepKernel<float> (*single)(), SweepKernel<double> (*dbl)()) {
  if constexpr (std::is_same_v<Real, float>)
    return single();
  else
    return dbl();
}

template <class Real>
std::vector<SweepKernel<Real>> runnable_kernels() {
  std::vector<SweepKernel<Real>> kernels{choose<Real>(sweep_baseline_float, sweep_baseline_double)};
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    kernels.push_back(choose<Real>(sweep_v3_float, sweep_v3_double));
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512cd"))
    kernels.push_back(choose<Real>(sweep_v4_float, sweep_v4_double));
#endif
  return kernels;
}

}  // namespace

template <class Real>
const std::vector<SweepKernel<Real>>& sweep_kernels() {
  static const std::vector<SweepKernel<Real>> kernels = runnable_kernels<Real>();
  return kernels;
}

template const std::vector<SweepKernel<float>>& sweep_kernels();
template const std::vector<SweepKernel<double>>& sweep_kernels();

}  // namespace mss

#include "core/descent.hpp"

#include <type_traits>

namespace mss {

DescentKernel<float> descent_baseline_float();
DescentKernel<double> descent_baseline_double();
#if defined(__x86_64__)
DescentKernel<float> descent_v3_float();
DescentKernel<double> descent_v3_double();
DescentKernel<float> descent_v4_float();
DescentKernel<double> descent_v4_double();
#endif

namespace {

template <class Real>
DescentKernel<Real> choose(DescentKernel<float> (*single)(), DescentKernel<double> (*dbl)()) {
  if constexpr (std::is_same_v<Real, float>)
    return single();
  else
    return dbl();
}

template <class Real>
std::vector<DescentKernel<Real>> runnable_kernels() {
  std::vector<DescentKernel<Real>> kernels{choose<Real>(descent_baseline_float, descent_baseline_double)};
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    kernels.push_back(choose<Real>(descent_v3_float, descent_v3_double));
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512cd"))
    kernels.push_back(choose<Real>(descent_v4_float, descent_v4_double));
#endif
  return kernels;
}

}  // namespace

template <class Real>
const std::vector<DescentKernel<Real>>& descent_kernels() {
  static const std::vector<DescentKernel<Real>> kernels = runnable_kernels<Real>();
  return kernels;
}

template const std::vector<DescentKernel<float>>& descent_kernels();
template const std::vector<DescentKernel<double>>& descent_kernels();

}  // namespace mss

#include "core/projection.hpp"

#include <type_traits>

namespace mss {

ProjectionKernel<float> projection_baseline_float();
ProjectionKernel<double> projection_baseline_double();
#if defined(__x86_64__)
ProjectionKernel<float> projection_v3_float();
ProjectionKernel<double> projection_v3_double();
ProjectionKernel<float> projection_v4_float();
ProjectionKernel<double> projection_v4_double();
#endif

namespace {

template <class Real>
ProjectionKernel<Real> choose(ProjectionKernel<float> (*single)(), ProjectionKernel<double> (*dbl)()) {
  if constexpr (std::is_same_v<Real, float>)
    return single();
  else
    return dbl();
}

template <class Real>
std::vector<ProjectionKernel<Real>> runnable_kernels() {
  std::vector<ProjectionKernel<Real>> kernels{
      choose<Real>(projection_baseline_float, projection_baseline_double)};
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    kernels.push_back(choose<Real>(projection_v3_float, projection_v3_double));
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512cd"))
    kernels.push_back(choose<Real>(projection_v4_float, projection_v4_double));
#endif
  return kernels;
}

}  // namespace

template <class Real>
const std::vector<ProjectionKernel<Real>>& projection_kernels() {
  static const std::vector<ProjectionKernel<Real>> kernels = runnable_kernels<Real>();
  return kernels;
}

template const std::vector<ProjectionKernel<float>>& projection_kernels();
template const std::vector<ProjectionKernel<double>>& projection_kernels();

}  // namespace mss

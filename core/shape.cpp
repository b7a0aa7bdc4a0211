#include <type_traits>

#include "core/shape_sums.hpp"

namespace mss {

ShapeKernel<float> shape_baseline_float();
ShapeKernel<double> shape_baseline_double();
#if defined(__x86_64__)
ShapeKernel<float> shape_v3_float();
ShapeKernel<double> shape_v3_double();
ShapeKernel<float> shape_v4_float();
ShapeKernel<double> shape_v4_double();
#endif

namespace {

template <class Real>
ShapeKernel<Real> choose(ShapeKernel<float> (*single)(), ShapeKernel<double> (*dbl)()) {
  if constexpr (std::is_same_v<Real, float>)
    return single();
  else
    return dbl();
}

template <class Real>
std::vector<ShapeKernel<Real>> runnable_kernels() {
  std::vector<ShapeKernel<Real>> kernels{choose<Real>(shape_baseline_float, shape_baseline_double)};
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    kernels.push_back(choose<Real>(shape_v3_float, shape_v3_double));
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512cd"))
    kernels.push_back(choose<Real>(shape_v4_float, shape_v4_double));
#endif
  return kernels;
}

}  // namespace

template <class Real>
const std::vector<ShapeKernel<Real>>& shape_kernels() {
  static const std::vector<ShapeKernel<Real>> kernels = runnable_kernels<Real>();
  return kernels;
}

template const std::vector<ShapeKernel<float>>& shape_kernels();
template const std::vector<ShapeKernel<double>>& shape_kernels();

}  // namespace mss

#include "integrators/linear/vector_kernels.hpp"

namespace mss {

VectorKernels vector_kernels_baseline();
#if defined(__x86_64__)
VectorKernels vector_kernels_v3();
VectorKernels vector_kernels_v4();
#endif

namespace {

VectorKernels fastest() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512cd"))
    return vector_kernels_v4();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return vector_kernels_v3();
#endif
  return vector_kernels_baseline();
}

}  // namespace

const VectorKernels& vector_kernels() {
  static const VectorKernels kernels = fastest();
  return kernels;
}

}  // namespace mss

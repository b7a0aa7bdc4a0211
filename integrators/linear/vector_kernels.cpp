#include "integrators/linear/vector_kernels.hpp"

#include "core/kernels/instruction_sets.hpp"

namespace mss {

VectorKernels vector_kernels_baseline();
VectorKernels vector_kernels_v3();
VectorKernels vector_kernels_v4();

const VectorKernels& vector_kernels() {
  static const VectorKernels kernels =
      runnable_copies(vector_kernels_baseline, vector_kernels_v3, vector_kernels_v4).back();
  return kernels;
}

}  // namespace mss

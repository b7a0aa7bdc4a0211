#include "core/kernels/instruction_sets.hpp"
#include "integrators/position_based/shape_sums.hpp"

namespace mss {

ShapeKernel shape_baseline();
ShapeKernel shape_v3();
ShapeKernel shape_v4();

const std::vector<ShapeKernel>& shape_kernels() {
  static const std::vector<ShapeKernel> kernels = runnable_copies(shape_baseline, shape_v3, shape_v4);
  return kernels;
}

}  // namespace mss

// One copy of the vector kernels; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_v4
#include "integrators/linear/vector_kernels_copy.hpp"

namespace mss {

VectorKernels vector_kernels_v4() { return MSS_ISA::make_vector_kernels("x86-64-v4"); }

}  // namespace mss

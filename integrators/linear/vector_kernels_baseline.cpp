// One copy of the vector kernels; CMakeLists.txt compiles this file for its instruction set.
#define MSS_ISA isa_baseline
#include "integrators/linear/vector_kernels_copy.hpp"

namespace mss {

VectorKernels vector_kernels_baseline() { return MSS_ISA::make_vector_kernels("baseline"); }

}  // namespace mss

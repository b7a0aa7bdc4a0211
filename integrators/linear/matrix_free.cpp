// Block-Jacobi preconditioned conjugate gradients that build no matrix.
#include "integrators/linear/matrix_free.hpp"

namespace mss {

LinearSolverInfo matrix_free() {
  return {.name = "matrix_free",
          .summary = "conjugate gradients, block-Jacobi, products through the structured sweep",
          .products_only = true,
          .in_ranks = true,
          .make = [](double tolerance) { return std::make_unique<MatrixFree>(tolerance); }};
}

}  // namespace mss

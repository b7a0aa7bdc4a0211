#pragma once

#include <memory>
#include <string>

#include "core/system/system.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// Supernodal sparse Cholesky factorisation with nested dissection; the only place that names CHOLMOD.
///
/// One thread: CHOLMOD's own OpenMP loops and the BLAS threads beneath them compete for cores (a body of 7^3
/// cells factors three times slower with the defaults), and one thread gives the same bits everywhere.
class Cholesky {
 public:
  Cholesky();
  ~Cholesky();
  Cholesky(const Cholesky&) = delete;
  Cholesky& operator=(const Cholesky&) = delete;

  /// Factors a symmetric matrix, of which the lower triangle is read. Analyses the first one, and those whose
  /// pattern is not the last one's. Status ok or not_positive_definite.
  Status factor(const SparseMatrix& matrix);

  /// Solves with the last factor: a vector, or a matrix whose columns are right-hand sides.
  template <class Dense>
  void solve(const Dense& rhs, Dense& solution) {
    if (rhs.size() == 0)
      solution.resizeLike(rhs);
    else
      solution = Eigen::Map<const Dense>(solve(rhs.data(), rhs.rows(), rhs.cols()), rhs.rows(), rhs.cols());
  }

 private:
  const double* solve(const double* rhs, Eigen::Index rows, Eigen::Index columns);

  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

/// As in "3.0.14 of SuiteSparse 5.12.0, OpenBLAS 0.3.21".
std::string cholmod_version();

/// The processor whose kernels OpenBLAS chose for this one, as in "SkylakeX"; rounding in CHOLMOD depends on
/// it.
std::string blas_kernels();

}  // namespace mss

#pragma once

#include <Eigen/Core>
#include <functional>

#include "integrators/integrator.hpp"

namespace mss {

/// A square matrix A that only multiplies: out = A in, of `rows` numbers each.
struct LinearMap {
  Eigen::Index rows = 0;
  std::function<void(const double* in, double* out)> apply;
};

/// How long to search.
struct KrylovSearch {
  Eigen::Index wanted;  ///< eigenpairs
  Eigen::Index space;   ///< dimension of the Krylov space, at most that of the matrix
  Eigen::Index most_restarts;
  double tolerance;  ///< of the residual, relative to the eigenvalue
};

/// What a search has found, the largest first. Status ok, or linear_stalled and nothing else.
template <class Vector, class Matrix>
struct Eigenpairs {
  Status status = Status::ok;
  Vector values{};
  Matrix vectors{};  ///< columns of norm 1; shape rows x wanted
};

/// The largest eigenvalues of a symmetric matrix by implicitly restarted Lanczos (Spectra). Equal ones may be
/// found once only.
Eigenpairs<Eigen::VectorXd, Eigen::MatrixXd> lanczos(const LinearMap& a, const KrylovSearch& search);

/// The eigenvalues of largest absolute value of any matrix by implicitly restarted Arnoldi (Spectra).
Eigenpairs<Eigen::VectorXcd, Eigen::MatrixXcd> arnoldi(const LinearMap& a, const KrylovSearch& search);

}  // namespace mss

#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>

#include "integrators/integrator.hpp"

namespace mss {

/// Columns to columns: y = A x, both of shape unknowns x columns; y is resized.
using BlockMap = std::function<void(const Eigen::MatrixXd& x, Eigen::MatrixXd& y)>;

/// What is wanted of a symmetric matrix A.
struct LowestSearch {
  Eigen::Index unknowns = 0;
  Eigen::Index count = 1;             ///< eigenpairs
  double relative = 0, absolute = 0;  ///< found where |A x - value x| <= relative |value| + absolute
  /// The search ends early where no eigenvalue below this seems left.
  double below = std::numeric_limits<double>::infinity();
};

struct LowestPairs {
  Status status = Status::ok;   ///< or linear_stalled
  Eigen::VectorXd values{};     ///< ascending
  Eigen::MatrixXd vectors{};    ///< orthonormal columns
  Eigen::VectorXd residuals{};  ///< norms: an eigenvalue of A is so near to each value
};

/// The lowest eigenpairs of A in the orthogonal complement of the orthonormal columns `found`: locally
/// optimal block preconditioned conjugate gradients, from a random block, always the same. `preconditioner`
/// is symmetric, positive definite and near the inverse of A. The block is larger than the count, so that
/// equal eigenvalues are found together. Knyazev, SIAM J. Sci. Comput. 23 (2001) 517; with the orthonormal
/// basis of Hetmaniuk and Lehoucq, J. Comput. Phys. 218 (2006) 324. Empty where the search ends early.
LowestPairs lowest_pairs(const BlockMap& a, const BlockMap& preconditioner, const Eigen::MatrixXd& found,
                         const LowestSearch& search);

}  // namespace mss

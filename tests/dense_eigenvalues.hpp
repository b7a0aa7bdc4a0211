#pragma once

#include <Eigen/Dense>

namespace mss::testing {

// Compiled once: each of Eigen's solvers takes as long to compile as a file of tests.

/// Of a symmetric matrix, ascending.
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a);

/// Of A x = lambda B x, ascending; A is symmetric, B symmetric and positive definite.
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Of any square matrix, in no order.
Eigen::VectorXcd any_eigenvalues(const Eigen::MatrixXd& a);

/// Of B^-1 A.
Eigen::VectorXcd any_eigenvalues(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

}  // namespace mss::testing

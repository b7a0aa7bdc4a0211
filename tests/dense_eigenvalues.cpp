#include "tests/dense_eigenvalues.hpp"

namespace mss::testing {

Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(a, b, Eigen::EigenvaluesOnly)
      .eigenvalues();
}

Eigen::VectorXcd any_eigenvalues(const Eigen::MatrixXd& a) {
  return Eigen::EigenSolver<Eigen::MatrixXd>(a, false).eigenvalues();
}

Eigen::VectorXcd any_eigenvalues(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return any_eigenvalues(Eigen::MatrixXd(b.inverse() * a));
}

}  // namespace mss::testing

// The only source that names Spectra: its templates take long to compile.
#include "integrators/analysis/spectra.hpp"

#include <Spectra/GenEigsSolver.h>
#include <Spectra/SymEigsSolver.h>

namespace mss {

namespace {

class Operator {
 public:
  using Scalar = double;
  explicit Operator(const LinearMap& map) : map_(map) {}

  Eigen::Index rows() const { return map_.rows; }
  Eigen::Index cols() const { return map_.rows; }
  void perform_op(const double* in, double* out) const { map_.apply(in, out); }

 private:
  const LinearMap& map_;
};

template <class Found, class Solver>
Found search_with(const LinearMap& a, const KrylovSearch& search, Spectra::SortRule rule) {
  Operator op(a);
  Solver solver(op, search.wanted, search.space);
  solver.init();
  const Eigen::Index converged = solver.compute(rule, search.most_restarts, search.tolerance);
  if (solver.info() != Spectra::CompInfo::Successful || converged < search.wanted)
    return {.status = Status::linear_stalled};
  return {.values = solver.eigenvalues(), .vectors = solver.eigenvectors()};
}

}  // namespace

Eigenpairs<Eigen::VectorXd, Eigen::MatrixXd> lanczos(const LinearMap& a, const KrylovSearch& search) {
  using Found = Eigenpairs<Eigen::VectorXd, Eigen::MatrixXd>;
  return search_with<Found, Spectra::SymEigsSolver<Operator>>(a, search, Spectra::SortRule::LargestAlge);
}

Eigenpairs<Eigen::VectorXcd, Eigen::MatrixXcd> arnoldi(const LinearMap& a, const KrylovSearch& search) {
  using Found = Eigenpairs<Eigen::VectorXcd, Eigen::MatrixXcd>;
  return search_with<Found, Spectra::GenEigsSolver<Operator>>(a, search, Spectra::SortRule::LargestMagn);
}

}  // namespace mss

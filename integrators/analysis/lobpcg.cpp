#include "integrators/analysis/lobpcg.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <random>
#include <vector>

#include "integrators/linear/one_thread.hpp"

namespace mss {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Products of tall matrices by the BLAS, which is several times faster than Eigen built for any processor.
MatrixXd transposed_times(const MatrixXd& a, const MatrixXd& b) {
  MatrixXd c = MatrixXd::Zero(a.cols(), b.cols());
  if (c.size() > 0)
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, int(a.cols()), int(b.cols()), int(a.rows()), 1,
                a.data(), int(a.rows()), b.data(), int(b.rows()), 0, c.data(), int(c.rows()));
  return c;
}

/// c = a b + keep c.
void multiply(double factor, const MatrixXd& a, const MatrixXd& b, double keep, MatrixXd& c) {
  if (a.cols() > 0 && b.cols() > 0)
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, int(a.rows()), int(b.cols()), int(a.cols()),
                factor, a.data(), int(a.rows()), b.data(), int(b.rows()), keep, c.data(), int(c.rows()));
}

MatrixXd times(const MatrixXd& a, const MatrixXd& b) {
  MatrixXd c(a.rows(), b.cols());
  multiply(1, a, b, 0, c);
  return c;
}

MatrixXd side_by_side(const MatrixXd& a, const MatrixXd& b) {
  MatrixXd both(b.rows(), a.cols() + b.cols());
  both.leftCols(a.cols()) = a;
  both.rightCols(b.cols()) = b;
  return both;
}

/// Makes the columns of w orthonormal and orthogonal to those of the others, and drops what is nothing new.
/// Twice is enough; by eigenvectors of w^T w (Stathopoulos and Wu, SIAM J. Sci. Comput. 23 (2002) 2165).
void orthonormalise(const std::vector<const MatrixXd*>& others, MatrixXd& w) {
  constexpr double nothing_new = 1e-12;
  for (int pass = 0; pass < 2 && w.cols() > 0; ++pass) {
    for (Index i = 0; i < w.cols(); ++i) w.col(i).normalize();
    for (const MatrixXd* other : others) multiply(-1, *other, transposed_times(*other, w), 1, w);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> gram(transposed_times(w, w));
    const VectorXd& values = gram.eigenvalues();
    const Index dropped = (values.array() <= nothing_new * std::max(1e-12, values.maxCoeff())).count(),
                kept = w.cols() - dropped;
    w = times(
        w, gram.eigenvectors().rightCols(kept) * values.tail(kept).cwiseSqrt().cwiseInverse().asDiagonal());
  }
}

MatrixXd random_block(Index rows, Index columns) {
  std::minstd_rand generator;  // of the standard: the same everywhere
  return MatrixXd::NullaryExpr(rows, columns, [&] { return double(generator()) / 2147483647 - 0.5; });
}

/// Of the new block and its directions in the old basis [X P W]: the Ritz vectors, and what `active` ones
/// have outside the old X.
MatrixXd combination(const MatrixXd& ritz_vectors, Index block, const std::vector<Index>& active) {
  const MatrixXd x = ritz_vectors.leftCols(block);
  MatrixXd p = x(Eigen::all, active);
  p.topRows(block).setZero();
  orthonormalise({&x}, p);
  return side_by_side(x, p);
}

bool none_below(double limit, double value, double residual) {
  constexpr double trusted = 0.03;  // of the value: it has settled near the lowest
  return value - residual > limit && residual < trusted * value;
}

/// The larger the block, the faster it converges.
Index block_size(const LowestSearch& search) {
  return std::min(search.unknowns / 3, search.count + std::max<Index>(3, search.count / 3));
}

}  // namespace

LowestPairs lowest_pairs(const BlockMap& a, const BlockMap& preconditioner, const MatrixXd& found,
                         const LowestSearch& search) {
  constexpr int most_iterations = 150;
  const OneThread one_thread;
  MatrixXd w, aw, s(search.unknowns, 0), as = s;  // s: [X P], as: A s
  preconditioner(random_block(search.unknowns, block_size(search)), w);
  orthonormalise({&found}, w);
  const Index block = w.cols();
  std::vector<Index> active;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    a(w, aw);
    s = side_by_side(s, w);
    as = side_by_side(as, aw);
    const MatrixXd h = transposed_times(s, as);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> ritz((h + h.transpose()) / 2);
    const VectorXd values = ritz.eigenvalues().head(block);
    const MatrixXd c = combination(ritz.eigenvectors(), block, active);
    s = times(s, c);
    as = times(as, c);
    MatrixXd r = as.leftCols(block) - s.leftCols(block) * values.asDiagonal();
    const VectorXd residuals = r.colwise().norm();
    if (none_below(search.below, values[0], residuals[0])) return {};
    active.clear();
    for (Index i = 0; i < block; ++i)
      if (residuals[i] > search.relative * std::abs(values[i]) + search.absolute) active.push_back(i);
    if (active.empty() || active.front() >= search.count)
      return {.values = values.head(search.count),
              .vectors = s.leftCols(search.count),
              .residuals = residuals.head(search.count)};
    preconditioner(r(Eigen::all, active), w);
    orthonormalise({&found, &s}, w);
  }
  return {.status = Status::linear_stalled};
}

}  // namespace mss

#include "integrators/analysis/modes.hpp"

#include <Spectra/SymEigsShiftSolver.h>
#include <Spectra/SymEigsSolver.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "integrators/linear/linear_solver.hpp"
#include "integrators/linear/unknowns.hpp"

namespace mss {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double tolerance = 1e-11;
constexpr Index most_restarts = 1000;

/// x -> (A - shift)^-1 x with A = M^-1/2 K M^-1/2, in the orthogonal complement of what has been found.
class ShiftedInverse {
 public:
  using Scalar = double;
  ShiftedInverse(SolidSystem<double>& system, LinearSolver& solver, const VectorXd& roots, Work& work)
      : unknowns_(tangents_of(system).unknowns()),
        solver_(solver),
        roots_(roots),
        work_(work),
        in_(system.size()),
        out_(system.size()) {}

  Index rows() const { return roots_.size(); }
  Index cols() const { return roots_.size(); }
  void set_shift(double) {}  // the solver is prepared with it
  void perform_op(const double* x_in, double* y_out) const {
    y_ = Eigen::Map<const VectorXd>(x_in, rows());
    leave_out_found();
    y_.array() *= roots_.array();
    scatter(unknowns_, y_, in_);
    const Status solved = solver_.solve(in_, out_, work_);
    if (status == Status::ok) status = solved;
    gather(unknowns_, out_, y_);
    y_.array() *= roots_.array();
    leave_out_found();
    Eigen::Map<VectorXd>(y_out, rows()) = y_;
  }

  MatrixXd found{};                    ///< orthonormal columns
  mutable Status status = Status::ok;  ///< the first that was not ok

 private:
  void leave_out_found() const {
    if (found.cols() > 0) y_ -= found * (found.transpose() * y_);
  }

  const std::vector<FreeDof>& unknowns_;
  LinearSolver& solver_;
  const VectorXd& roots_;
  Work& work_;
  mutable Field<double> in_, out_;
  mutable VectorXd y_;
};

/// x -> (A + shift) x, with M^-1/2 (K + weight C) M^-1/2 for A.
class Product {
 public:
  using Scalar = double;
  Product(SolidSystem<double>& system, const State<double>& state, const VectorXd& roots, Work& work,
          const TangentCoefficients& sum, double shift = 0)
      : tangents_(tangents_of(system)),
        state_(state),
        roots_(roots),
        work_(work),
        sum_(sum),
        shift_(shift),
        in_(system.size()),
        out_(system.size()) {}

  Index rows() const { return roots_.size(); }
  Index cols() const { return roots_.size(); }
  void perform_op(const double* x_in, double* y_out) const {
    const Eigen::Map<const VectorXd> x(x_in, rows());
    y_ = x.array() / roots_.array();
    scatter(tangents_.unknowns(), y_, in_);
    tangents_.product(state_.t, state_.x, state_.v, sum_, in_, out_);
    ++work_.products;
    gather(tangents_.unknowns(), out_, y_);
    Eigen::Map<VectorXd>(y_out, rows()) = y_.array() / roots_.array() + shift_ * x.array();
  }
  /// x.A x.
  double quotient(const VectorXd& x) const {
    VectorXd y(rows());
    perform_op(x.data(), y.data());
    return x.dot(y);
  }

 private:
  Tangents<double>& tangents_;
  const State<double>& state_;
  const VectorXd& roots_;
  Work& work_;
  TangentCoefficients sum_;
  double shift_;
  mutable Field<double> in_, out_;
  mutable VectorXd y_;
};

const TangentCoefficients stiffness{.stiffness = 1, .kind = Tangent::elastic};

struct Pair {
  double value;  ///< omega^2
  VectorXd vector;
};

void sort(std::vector<Pair>& pairs) {
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.value < b.value; });
}

/// Eigenvalues within `rounding` of 0 belong to rigid motions.
Modes to_modes(SolidSystem<double>& system, std::vector<Pair> pairs, const VectorXd& roots, double rounding) {
  Modes result;
  for (Pair& pair : pairs) {
    if (pair.value < -10 * rounding) return {.status = Status::not_positive_definite, .modes = {}};
    pair.vector.array() /= roots.array();
    Field<double> shape(system.size());
    scatter(tangents_of(system).unknowns(), pair.vector, shape);
    result.modes.push_back({pair.value > rounding ? std::sqrt(pair.value) : 0, std::move(shape)});
  }
  return result;
}

/// All of them, for a body so small that this is cheapest.
std::vector<Pair> dense_pairs(SolidSystem<double>& system, const State<double>& state,
                              const VectorXd& roots) {
  SparseMatrix k = tangents_of(system).pattern();
  tangents_of(system).values(state.t, state.x, state.v, {.stiffness = 1, .kind = Tangent::elastic}, k);
  const MatrixXd a = roots.cwiseInverse().asDiagonal() * MatrixXd(k) * roots.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(a);
  std::vector<Pair> pairs;
  for (Index i = 0; i < roots.size(); ++i)
    pairs.push_back({eigen.eigenvalues()[i], eigen.eigenvectors().col(i)});
  return pairs;
}

/// Lanczos until the rest contains nothing slower than the slowest `count` found.
Status find_slowest(ShiftedInverse& inverse, double shift, Index count, std::vector<Pair>& found) {
  for (;;) {
    const Index left = inverse.rows() - Index(found.size());
    const Index wanted = std::min(count, left - 1);
    if (wanted < 1) return Status::ok;
    Spectra::SymEigsShiftSolver<ShiftedInverse> lanczos(inverse, wanted, std::min(3 * wanted + 20, left),
                                                        shift);
    lanczos.init();
    const Index converged = lanczos.compute(Spectra::SortRule::LargestMagn, most_restarts, tolerance);
    if (inverse.status != Status::ok) return inverse.status;
    if (lanczos.info() != Spectra::CompInfo::Successful || converged < wanted) return Status::linear_stalled;
    const VectorXd values = lanczos.eigenvalues();
    const MatrixXd vectors = lanczos.eigenvectors();
    const bool complete =
        Index(found.size()) >= count && values.minCoeff() >= found[std::size_t(count - 1)].value * (1 - 1e-9);
    if (complete) return Status::ok;
    for (Index i = 0; i < converged; ++i) found.push_back({values[i], vectors.col(i)});
    sort(found);
    inverse.found.resize(inverse.rows(), Index(found.size()));
    for (std::size_t i = 0; i < found.size(); ++i) inverse.found.col(Index(i)) = found[i].vector;
  }
}

/// Particles of bodies whose matrix is factored: Lanczos solves with one matrix about a hundred times, so
/// that a factorisation pays in larger bodies than for a single solve.
constexpr std::size_t most_factored = 20000;

}  // namespace

Modes slowest_modes(SolidSystem<double>& system, const State<double>& state, int count, Work& work) {
  const VectorXd roots = root_masses(system);
  const Index wanted = std::min<Index>(count, roots.size());
  if (wanted == 0) return {};
  const double fastest = system.spectral_bound().omega;
  std::vector<Pair> found;
  if (roots.size() <= 100 || 3 * wanted + 20 >= roots.size()) {
    found = dense_pairs(system, state, roots);
  } else {
    const double shift = -1e-6 * fastest * fastest;  // K alone is singular without holds
    const bool large = system.particles().size() > most_factored;
    const auto solver = find_linear_solver(large ? "multigrid" : "cholmod").make(1e-12);
    const TangentCoefficients sum{.mass = -shift, .stiffness = 1, .kind = Tangent::elastic};
    Status status = solver->prepare(system, state.t, state.x, state.v, sum, work);
    ShiftedInverse inverse(system, *solver, roots, work);
    if (status == Status::ok) status = find_slowest(inverse, shift, wanted, found);
    if (status != Status::ok) return {.status = status, .modes = {}};
  }
  found.resize(std::size_t(wanted));
  return to_modes(system, std::move(found), roots, 1e-13 * fastest * fastest);
}

Modes fastest_mode(SolidSystem<double>& system, const State<double>& state, Work& work) {
  const VectorXd roots = root_masses(system);
  if (roots.size() == 0) return {};
  if (roots.size() <= 100) {
    std::vector<Pair> all = dense_pairs(system, state, roots);
    return to_modes(system, {all.back()}, roots, 0);
  }
  Product product(system, state, roots, work, stiffness);
  Spectra::SymEigsSolver<Product> lanczos(product, 1, 30);
  lanczos.init();
  lanczos.compute(Spectra::SortRule::LargestAlge, most_restarts, 1e-9);
  if (lanczos.info() != Spectra::CompInfo::Successful) return {.status = Status::linear_stalled, .modes = {}};
  return to_modes(system, {{lanczos.eigenvalues()[0], lanczos.eigenvectors().col(0)}}, roots, 0);
}

RayleighQuotients largest_quotient(SolidSystem<double>& system, const State<double>& state, double weight,
                                   Work& work) {
  const VectorXd roots = root_masses(system);
  if (roots.size() == 0) return {};
  const SpectralBound bound = system.spectral_bound();
  // Lanczos converges to the largest absolute value: the shift makes that the largest eigenvalue.
  const double shift = bound.omega * bound.omega + std::abs(weight) * bound.damping;
  const TangentCoefficients sum{.damping = weight, .stiffness = 1, .kind = Tangent::elastic};
  Product product(system, state, roots, work, sum, shift);
  Spectra::SymEigsSolver<Product> lanczos(product, 1, std::min<Index>(30, roots.size()));
  lanczos.init();
  lanczos.compute(Spectra::SortRule::LargestAlge, most_restarts, 1e-9);
  if (lanczos.info() != Spectra::CompInfo::Successful) return {.status = Status::linear_stalled};
  const VectorXd q = lanczos.eigenvectors().col(0);
  const TangentCoefficients damping{.damping = 1, .kind = Tangent::elastic};
  return {.stiffness = Product(system, state, roots, work, stiffness).quotient(q),
          .damping = Product(system, state, roots, work, damping).quotient(q)};
}

}  // namespace mss

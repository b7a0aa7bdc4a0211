#include "integrators/analysis/modes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>

#include "integrators/analysis/lobpcg.hpp"
#include "integrators/analysis/scaled_tangent.hpp"
#include "integrators/analysis/spectra.hpp"
#include "integrators/linear/cholmod.hpp"
#include "integrators/linear/unknowns.hpp"
#include "integrators/linear/v_cycle.hpp"

namespace mss {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index most_restarts = 1000;

/// Multigrid is faster where its coarsest lattice still resolves the body across, which converges fast, and
/// planes of particles across are so large that the factor fills in. Above `most_factored` that needs too
/// much memory in any case. `mss_bench --benchmark_filter=modes` compares them.
bool is_for_multigrid(const SolidSystem<double>& system) {
  constexpr std::size_t enough = 2000, most_factored = 100000;
  constexpr int slenderness = 5;
  if (!system.cells() || !system.cells()->body().config().is_solid()) return false;
  if (system.particles().size() <= enough) return false;
  const auto cells = system.cells()->body().config().voxels.size();
  const auto [least, most] = std::minmax_element(cells.begin(), cells.end());
  return slenderness * *least >= *most || system.particles().size() > most_factored;
}

bool by_multigrid(const SolidSystem<double>& system, ModeSearch search) {
  return search == ModeSearch::multigrid || (search == ModeSearch::automatic && is_for_multigrid(system));
}

/// Pairs of A = M^-1/2 K M^-1/2: squared frequencies and orthonormal columns.
struct Pairs {
  VectorXd values;
  MatrixXd vectors;

  Index count() const { return values.size(); }
  /// Adds others and sorts all.
  void add(const VectorXd& other_values, const MatrixXd& other_vectors) {
    VectorXd all(count() + other_values.size());
    all << values, other_values;
    MatrixXd columns(other_vectors.rows(), all.size());
    columns.leftCols(count()) = vectors;
    columns.rightCols(other_values.size()) = other_vectors;
    std::vector<Index> order(std::size_t(all.size()));
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](Index i, Index j) { return all[i] < all[j]; });
    values = all(order);
    vectors = columns(Eigen::all, order);
  }
  /// Keeps the first.
  void keep(Index wanted) {
    values.conservativeResize(wanted);
    vectors.conservativeResize(Eigen::NoChange, wanted);
  }
};

/// All of them, for a body so small that this is cheapest.
Pairs dense_pairs(const ScaledTangent& tangent) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(MatrixXd(tangent.matrix(0, 1)));
  return {eigen.eigenvalues(), eigen.eigenvectors()};
}

/// No eigenvalue of A is larger.
double squared_bound(const SolidSystem<double>& system) { return std::pow(system.spectral_bound().omega, 2); }

/// K alone is singular without holds.
double shift_for(const SolidSystem<double>& system) { return 1e-6 * squared_bound(system); }

/// The lowest pairs in the orthogonal complement of what has been found; none where none is below a value.
using Search = std::function<LowestPairs(const MatrixXd& found, Index count, double below)>;

/// Lanczos with the inverse of A + shift.
class FactoredSearch {
 public:
  FactoredSearch(const ScaledTangent& tangent, double shift) : shift_(shift) {
    SparseMatrix matrix = tangent.matrix(0, 1);
    matrix.diagonal().array() += shift;
    status = cholesky_.factor(matrix);
  }

  LowestPairs lowest(const MatrixXd& found, Index count, Work& work) {
    const Index rows = found.rows(), left = rows - found.cols(), wanted = std::min(count, left - 1);
    VectorXd rhs, solution;
    const auto inverse = [&](const double* in, double* out) {
      rhs = Eigen::Map<const VectorXd>(in, rows);
      rhs -= found * (found.transpose() * rhs);
      cholesky_.solve(rhs, solution);
      ++work.linear_solves;
      solution -= found * (found.transpose() * solution);
      Eigen::Map<VectorXd>(out, rows) = shift_ * solution;
    };
    const auto pairs = lanczos({rows, inverse}, {.wanted = wanted,
                                                 .space = std::min(3 * wanted + 20, left),
                                                 .most_restarts = most_restarts,
                                                 .tolerance = 1e-11});
    if (pairs.status != Status::ok) return {.status = pairs.status};
    return {.values = shift_ * (pairs.values.cwiseInverse().array() - 1), .vectors = pairs.vectors};
  }

  Status status;  ///< of the factorisation

 private:
  double shift_;
  Cholesky cholesky_;
};

/// LOBPCG with a V-cycle for A + shift.
class MultigridSearch {
 public:
  MultigridSearch(SolidSystem<double>& system, const State<double>& state, ScaledTangent& tangent, Work& work)
      : unknowns_(tangents_of(system).unknowns()),
        tangent_(tangent),
        work_(work),
        rounding_(1e-14 * squared_bound(system)),
        mask_(mask_of_unknowns(system)),
        in_(system.size()),
        out_(system.size()) {
    const TangentCoefficients sum{.mass = shift_for(system), .stiffness = 1, .kind = Tangent::projected};
    status = v_cycle_.prepare(system, state.t, state.x, state.v, sum, mask_);
  }

  LowestPairs lowest(const MatrixXd& found, Index count, double below) {
    constexpr Index most_together = 40;
    return lowest_pairs([this](const MatrixXd& x, MatrixXd& y) { tangent_.multiply(0, 1, x, y, work_); },
                        [this](const MatrixXd& r, MatrixXd& z) { precondition(r, z); }, found,
                        {.unknowns = tangent_.unknowns(),
                         .count = std::min(count, most_together),
                         .relative = 1e-8,
                         .absolute = rounding_,
                         .below = below});
  }

  Status status;  ///< of the preparation

 private:
  void precondition(const MatrixXd& r, MatrixXd& z) {
    z.resize(r.rows(), r.cols());
    for (Index i = 0; i < r.cols(); ++i) {
      column_ = r.col(i).cwiseProduct(tangent_.roots());
      scatter(unknowns_, column_, in_);
      v_cycle_.apply(in_, column_.norm(), out_);
      gather(unknowns_, out_, column_);
      z.col(i) = column_.cwiseProduct(tangent_.roots());
    }
  }

  const std::vector<FreeDof>& unknowns_;
  ScaledTangent& tangent_;
  Work& work_;
  double rounding_;  ///< of a product
  Field<double> mask_, in_, out_;
  VectorXd column_;
  VCycle v_cycle_;
};

/// Searches until what is left has nothing slower than the slowest `count` found.
Status find_slowest(const Search& lowest, Index count, Pairs& found) {
  found.keep(0);
  while (found.count() < found.vectors.rows() - 1) {
    const bool enough = found.count() >= count;
    const double slower =
        enough ? found.values[count - 1] * (1 - 1e-9) : std::numeric_limits<double>::infinity();
    const LowestPairs next = lowest(found.vectors, enough ? 1 : count - found.count(), slower);
    if (next.status != Status::ok) return next.status;
    if (enough && (next.values.size() == 0 || next.values[0] >= slower)) break;
    found.add(next.values, next.vectors);
  }
  return Status::ok;
}

Status find_by_multigrid(SolidSystem<double>& system, const State<double>& state, ScaledTangent& tangent,
                         Index count, Work& work, Pairs& found) {
  MultigridSearch search(system, state, tangent, work);
  if (search.status != Status::ok) return search.status;
  return find_slowest(
      [&](const MatrixXd& known, Index wanted, double below) { return search.lowest(known, wanted, below); },
      count, found);
}

Status find_factored(double shift, ScaledTangent& tangent, Index count, Work& work, Pairs& found) {
  FactoredSearch search(tangent, shift);
  ++work.factorisations;
  if (search.status != Status::ok) return search.status;
  return find_slowest(
      [&](const MatrixXd& known, Index wanted, double) { return search.lowest(known, wanted, work); }, count,
      found);
}

/// Eigenvalues within `rounding` of 0 belong to rigid motions.
Modes to_modes(ScaledTangent& tangent, const Pairs& pairs, double rounding, Work& work) {
  Modes result;
  MatrixXd residuals;
  tangent.multiply(0, 1, pairs.vectors, residuals, work);
  residuals -= pairs.vectors * pairs.values.asDiagonal();
  for (Index i = 0; i < pairs.count(); ++i) {
    const double value = pairs.values[i];
    if (value < -10 * rounding) return {.status = Status::not_positive_definite, .modes = {}};
    const bool rigid = value <= rounding;
    if (!rigid) result.error = std::max(result.error, residuals.col(i).norm() / (2 * value));
    result.modes.push_back({rigid ? 0 : std::sqrt(value),
                            tangent.to_field(pairs.vectors.col(i).cwiseQuotient(tangent.roots()))});
  }
  return result;
}

/// The largest eigenvalue of M^-1/2 (K + weight C) M^-1/2 + shift, to nine digits: its error is of the order
/// of the residual squared.
Eigenpairs<VectorXd, MatrixXd> largest_pair(ScaledTangent& tangent, double weight, double shift, Work& work) {
  const Index rows = tangent.unknowns();
  MatrixXd x, y;
  const auto product = [&](const double* in, double* out) {
    x = Eigen::Map<const VectorXd>(in, rows);
    tangent.multiply(weight, 1, x, y, work);
    Eigen::Map<VectorXd>(out, rows) = y + shift * x;
  };
  return lanczos(
      {rows, product},
      {.wanted = 1, .space = std::min<Index>(30, rows), .most_restarts = most_restarts, .tolerance = 1e-6});
}

}  // namespace

Modes slowest_modes(SolidSystem<double>& system, const State<double>& state, int count, Work& work,
                    ModeSearch search) {
  ScaledTangent tangent(system, state);
  const Index unknowns = tangent.unknowns(), wanted = std::min<Index>(count, unknowns);
  if (wanted == 0) return {};
  Pairs found{VectorXd(0), MatrixXd(unknowns, 0)};
  if (unknowns <= 100 || 3 * wanted + 20 >= unknowns) {
    found = dense_pairs(tangent);
  } else {
    Status status = Status::linear_stalled;
    if (by_multigrid(system, search)) status = find_by_multigrid(system, state, tangent, wanted, work, found);
    if (status == Status::linear_stalled && search != ModeSearch::multigrid)
      status = find_factored(shift_for(system), tangent, wanted, work, found);
    if (status != Status::ok) return {.status = status, .modes = {}};
  }
  found.keep(wanted);
  return to_modes(tangent, found, 1e-13 * squared_bound(system), work);
}

Modes fastest_mode(SolidSystem<double>& system, const State<double>& state, Work& work) {
  ScaledTangent tangent(system, state);
  if (tangent.unknowns() == 0) return {};
  if (tangent.unknowns() <= 100) {
    const Pairs all = dense_pairs(tangent);
    return to_modes(tangent, {all.values.tail(1), all.vectors.rightCols(1)}, 0, work);
  }
  const auto fastest = largest_pair(tangent, 0, 0, work);
  if (fastest.status != Status::ok) return {.status = fastest.status, .modes = {}};
  return to_modes(tangent, {fastest.values, fastest.vectors}, 0, work);
}

RayleighQuotients largest_quotient(ScaledTangent& tangent, const SpectralBound& bound, double weight,
                                   Work& work) {
  if (tangent.unknowns() == 0) return {};
  // Lanczos converges to the largest absolute value: the shift makes that the largest eigenvalue.
  const double shift = bound.omega * bound.omega + std::abs(weight) * bound.damping;
  const auto largest = largest_pair(tangent, weight, shift, work);
  if (largest.status != Status::ok) return {.status = largest.status};
  const auto quotient = [&](double damping, double stiffness) {
    MatrixXd image;
    tangent.multiply(damping, stiffness, largest.vectors, image, work);
    return image.col(0).dot(largest.vectors.col(0));
  };
  return {.stiffness = quotient(0, 1), .damping = quotient(1, 0)};
}

}  // namespace mss

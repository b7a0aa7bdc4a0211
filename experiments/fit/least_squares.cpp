#include "experiments/fit/least_squares.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

namespace mss::fit {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double difference = 0.01;    ///< step of forward differences, in coordinates
constexpr double first_region = 1.6;   ///< a factor of five, where coordinates are logarithms
constexpr double telling_step = 1e-3;  ///< shorter ones say more of rounding than of the model

/// The model between evaluations: transformed values that are linear in the coordinates.
class LinearModel {
 public:
  explicit LinearModel(const std::vector<Target>& targets) : targets_(targets) {}

  /// Nothing of values whose sign is not the measured one's, where logarithms are taken.
  bool transform(const VectorXd& values, VectorXd& z) const {
    z.resize(values.size());
    for (Eigen::Index i = 0; i < z.size(); ++i) {
      const Target& target = targets_[std::size_t(i)];
      if (!target.logarithmic) {
        z[i] = values[i] / target.uncertainty;
      } else {
        if (std::isfinite(values[i]) && !(values[i] / target.measured > 0)) return false;
        z[i] = std::log(values[i] / target.measured);
      }
    }
    return true;
  }
  VectorXd residuals(const VectorXd& z) const {
    VectorXd r(z.size());
    for (Eigen::Index i = 0; i < z.size(); ++i) {
      const auto& [measured, uncertainty, logarithmic] = targets_[std::size_t(i)];
      r[i] = logarithmic ? -measured * std::expm1(z[i]) / uncertainty : measured / uncertainty - z[i];
    }
    return r;
  }
  /// Derivatives of the residuals, from those of z.
  MatrixXd jacobian(const VectorXd& z, const MatrixXd& of_z) const {
    MatrixXd j = -of_z;
    for (Eigen::Index i = 0; i < z.size(); ++i) {
      const auto& [measured, uncertainty, logarithmic] = targets_[std::size_t(i)];
      if (logarithmic) j.row(i) *= measured * std::exp(z[i]) / uncertainty;
    }
    return j;
  }

 private:
  const std::vector<Target>& targets_;
};

/// The step d from z, low <= d <= high, that makes the model's sum of squares least: projected
/// Levenberg-Marquardt, which costs no evaluation.
VectorXd best_step(const LinearModel& model, const VectorXd& z, const MatrixXd& j, const VectorXd& low,
                   const VectorXd& high) {
  constexpr int most = 200;
  VectorXd d = VectorXd::Zero(j.cols());
  double damping = 1e-6;
  VectorXd r = model.residuals(z);
  for (int n = 0; n < most && damping < 1e12; ++n) {
    const MatrixXd a = model.jacobian(z + j * d, j);
    const VectorXd slope = a.transpose() * r;
    MatrixXd h = a.transpose() * a;
    VectorXd free_slope = slope;
    for (Eigen::Index k = 0; k < d.size(); ++k) {
      h(k, k) += damping * std::max(h(k, k), 1e-30);
      const bool bound = (d[k] <= low[k] && slope[k] > 0) || (d[k] >= high[k] && slope[k] < 0);
      if (!bound) continue;
      h.row(k).setZero();
      h.col(k).setZero();
      h(k, k) = 1;
      free_slope[k] = 0;
    }
    const VectorXd next = (d - h.ldlt().solve(free_slope)).cwiseMax(low).cwiseMin(high);
    const VectorXd found = model.residuals(z + j * next);
    const double change = (next - d).cwiseAbs().maxCoeff();
    const bool is_better = found.allFinite() && found.squaredNorm() <= r.squaredNorm();
    if (is_better) {
      d = next;
      r = found;
    }
    if (change < 1e-10) break;
    damping *= is_better ? 0.1 : 10;
  }
  return d;
}

class Solver {
 public:
  explicit Solver(const LeastSquaresProblem& problem)
      : problem_(problem), model_(problem.targets), region_(first_region) {}

  LeastSquaresResult solve() {
    if (!begin()) return result_;
    while (!is_over()) step();
    result_.jacobian = model_.jacobian(z_, j_);
    return result_;
  }

 private:
  Eigen::Index size() const { return problem_.start.size(); }

  std::vector<Evaluation> evaluate(const std::vector<Trial>& trials) {
    std::vector<Evaluation> found = problem_.evaluate(trials);
    for (const Evaluation& one : found) result_.evaluations += one.share;
    return found;
  }
  void note(const std::string& kind, const VectorXd& u, double chi2, bool accepted,
            const std::string& trouble) {
    result_.steps.push_back({kind, u, result_.evaluations, chi2, accepted, trouble});
  }

  /// Trials beside u for differences, away from the bounds.
  std::vector<Trial> beside(const VectorXd& u) const {
    std::vector<Trial> trials;
    for (Eigen::Index k = 0; k < size(); ++k) {
      trials.push_back({u, int(k)});
      trials.back().u[k] += u[k] + difference <= problem_.high[k] ? difference : -difference;
    }
    return trials;
  }

  /// Columns of which a trial failed stay as they are.
  void take_differences(const std::vector<Trial>& trials, const std::vector<Evaluation>& found,
                        std::size_t first) {
    for (Eigen::Index k = 0; k < size(); ++k) {
      const Evaluation& one = found[first + std::size_t(k)];
      const Trial& trial = trials[first + std::size_t(k)];
      VectorXd z;
      std::string trouble = one.problem;
      if (trouble.empty() && !model_.transform(one.values, z)) trouble = wrong_sign;
      note("difference", trial.u, std::numeric_limits<double>::quiet_NaN(), false, trouble);
      if (!trouble.empty()) continue;
      for (Eigen::Index i = 0; i < z.size(); ++i) {
        touched_(i, k) = std::isfinite(z[i]) ? 1 : 0;
        j_(i, k) = touched_(i, k) != 0 ? (z[i] - z_[i]) / (trial.u[k] - result_.u[k]) : 0;
      }
    }
    of_differences_ = result_.u;
    is_fresh_ = true;
    misprediction_ = worst_misprediction_ = 0;
  }

  bool begin() {
    std::vector<Trial> trials{{problem_.start}};
    for (Trial& trial : beside(problem_.start)) trials.push_back(std::move(trial));
    const std::vector<Evaluation> found = evaluate(trials);
    result_.u = problem_.start;
    result_.values = found[0].values;
    result_.problem = found[0].problem;
    if (problem_.stopped()) return end(Ended::interrupted);
    if (result_.problem.empty() && !model_.transform(found[0].values, z_)) result_.problem = wrong_sign;
    if (!result_.problem.empty()) return end(Ended::failed_at_start);
    result_.chi2 = model_.residuals(z_).squaredNorm();
    note("start", result_.u, result_.chi2, true, "");
    j_ = touched_ = MatrixXd::Zero(z_.size(), size());
    take_differences(trials, found, 1);
    for (std::size_t k = 0; k + 1 < found.size(); ++k)
      if (!found[k + 1].problem.empty()) {
        result_.problem = found[k + 1].problem;
        return end(Ended::failed_at_start);
      }
    result_.undetermined = undetermined_coordinates(model_.jacobian(z_, j_), problem_.targets);
    return result_.undetermined.empty() || end(Ended::undetermined);
  }

  bool end(Ended how) {
    result_.ended = how;
    is_over_ = true;
    return false;
  }
  bool is_over() {
    if (!is_over_ && problem_.stopped()) end(Ended::interrupted);
    if (!is_over_ && result_.evaluations + 1 > problem_.most_evaluations) end(Ended::too_many_evaluations);
    return is_over_;
  }

  bool is_inside_region(const VectorXd& d) const { return d.cwiseAbs().maxCoeff() < 0.99 * region_; }

  bool is_small(const VectorXd& d) const {
    if (d.cwiseAbs().maxCoeff() <= problem_.least_step) return true;
    const double gain = result_.chi2 - model_.residuals(z_ + j_ * d).squaredNorm();
    return z_.size() > size() && is_inside_region(d) && gain <= negligible_change(problem_, result_.chi2);
  }

  void step() {
    const VectorXd low = (problem_.low - result_.u).cwiseMax(-region_),
                   high = (problem_.high - result_.u).cwiseMin(region_);
    const VectorXd d = best_step(model_, z_, j_, low, high);
    if (is_small(d)) return settle(d);
    try_step(d);
  }

  /// The secants say that nothing is left to do. Where they have not predicted well, or are far from the
  /// differences that they began with, intervals from them may be a tenth too wide or narrow: differences
  /// then.
  void settle(const VectorXd& d) {
    constexpr double doubtful = 0.3, not_exact = 0.03, far = 1;
    const double moved = (result_.u - of_differences_).cwiseAbs().maxCoeff();
    const bool is_in_region = is_inside_region(d), is_exact = worst_misprediction_ < not_exact || moved < far,
               are_good = misprediction_ < doubtful && is_exact;
    if ((is_in_region && are_good) || is_fresh_) {
      end(is_in_region ? Ended::converged : Ended::stalled);
      return;
    }
    refresh();
  }

  void refresh() {
    const std::vector<Trial> trials = beside(result_.u);
    const std::vector<Evaluation> found = evaluate(trials);
    if (problem_.stopped()) return;
    take_differences(trials, found, 0);
    region_ = std::max(region_, 0.1);
  }

  void try_step(const VectorXd& d) {
    const VectorXd u = result_.u + d;
    const Evaluation found = evaluate({{u}}).front();
    if (problem_.stopped()) return;
    const double length = d.cwiseAbs().maxCoeff();
    VectorXd z;
    std::string trouble = found.problem;
    if (trouble.empty() && !model_.transform(found.values, z)) trouble = wrong_sign;
    if (!trouble.empty()) {
      note("step", u, std::numeric_limits<double>::quiet_NaN(), false, trouble);
      region_ = length / 2;
      is_cut_short_ = true;
      return;
    }
    const double chi2 = model_.residuals(z).squaredNorm(),
                 predicted = model_.residuals(z_ + j_ * d).squaredNorm();
    const bool is_better = chi2 < result_.chi2;
    const double gain = (result_.chi2 - chi2) / std::max(result_.chi2 - predicted, 1e-300);
    note("step", u, chi2, is_better, "");
    const bool is_level = std::abs(chi2 - result_.chi2) <= negligible_change(problem_, result_.chi2);
    level_ = is_level && !is_cut_short_ ? level_ + 1 : 0;
    take_secant(d, z);
    if (is_better) {
      result_.u = u;
      result_.values = found.values;
      result_.chi2 = chi2;
      z_ = z;
      rejected_ = 0;
      if (gain > 0.75 && length > 0.99 * region_) region_ *= 2;
    } else {
      region_ = length / 2;
      if (++rejected_ == 2 && !is_fresh_ && level_ < 2) refresh();
    }
    if (level_ == 2) end(Ended::converged);  // along what the targets hardly tell
  }

  void take_secant(const VectorXd& d, const VectorXd& z) {
    const VectorXd moved = z - z_, missed = moved - j_ * d;
    if (d.cwiseAbs().maxCoeff() > telling_step) misprediction_ = missed.norm() / moved.norm();
    worst_misprediction_ = std::max(worst_misprediction_, misprediction_);
    is_fresh_ = false;
    for (Eigen::Index i = 0; i < z.size(); ++i) {
      const Eigen::RowVectorXd along = touched_.row(i).cwiseProduct(d.transpose());
      if (const double square = along.squaredNorm(); square > 0) j_.row(i) += missed[i] / square * along;
    }
  }

  static constexpr const char* wrong_sign = "a value has the other sign than the measured one";

  const LeastSquaresProblem& problem_;
  LinearModel model_;
  LeastSquaresResult result_;
  VectorXd z_;
  MatrixXd j_;                      ///< derivatives of z
  MatrixXd touched_;                ///< 1 where a coordinate changes a target
  VectorXd of_differences_;         ///< where the last ones were taken
  double region_;                   ///< longest step of a coordinate
  double misprediction_ = 0;        ///< of the last step, over what it changed
  double worst_misprediction_ = 0;  ///< since the differences
  bool is_fresh_ = false;           ///< no step since the differences
  int rejected_ = 0;                ///< in a row
  int level_ = 0;                   ///< steps in a row that changed chi2 by nothing that matters
  bool is_cut_short_ = false;       ///< a trial failed: steps may be small for that alone
  bool is_over_ = false;
};

}  // namespace

namespace {
/// What was measured, over its uncertainties.
double size_of(const std::vector<Target>& targets) {
  double square = 0;
  for (const Target& target : targets) square += std::pow(target.measured / target.uncertainty, 2);
  return std::sqrt(square);
}
}  // namespace

double negligible_change(const LeastSquaresProblem& problem, double chi2) {
  const double degrees = double(problem.targets.size()) - double(problem.start.size());
  return degrees > 0 ? std::pow(problem.least_share, 2) * chi2 / degrees : 0;
}

std::vector<int> undetermined_coordinates(const MatrixXd& jacobian, const std::vector<Target>& targets) {
  constexpr double no_effect = 1e-5;  // of all that was measured, for a change by a factor of e
  constexpr double parallel = 2e-3;   // columns so near to each other differ by errors of differences
  constexpr double takes_part = 0.3;
  std::vector<int> found;
  for (Eigen::Index k = 0; k < jacobian.cols(); ++k)
    if (!(jacobian.col(k).norm() > no_effect * size_of(targets))) found.push_back(int(k));
  if (!found.empty() || jacobian.cols() == 0) return found;
  const MatrixXd scaled = jacobian.colwise().normalized();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scaled.transpose() * scaled);
  if (eigen.eigenvalues()[0] > parallel * parallel) return found;
  for (Eigen::Index k = 0; k < jacobian.cols(); ++k)
    if (std::abs(eigen.eigenvectors()(k, 0)) > takes_part) found.push_back(int(k));
  return found;
}

MatrixXd covariance_of(const MatrixXd& jacobian, double chi2) {
  const double variance = chi2 / double(jacobian.rows() - jacobian.cols());
  return variance * (jacobian.transpose() * jacobian).inverse();
}

LeastSquaresResult solve_least_squares(const LeastSquaresProblem& problem) { return Solver(problem).solve(); }

}  // namespace mss::fit

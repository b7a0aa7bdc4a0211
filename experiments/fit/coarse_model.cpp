#include "experiments/fit/coarse_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mss::fit {

namespace {

using Eigen::VectorXd;

/// Both models at the same coordinates.
struct Evaluated {
  VectorXd u, values, coarse;
  double chi2 = std::numeric_limits<double>::infinity();
};

class ByCoarseModel {
 public:
  ByCoarseModel(const LeastSquaresProblem& problem, const LeastSquaresProblem& coarse)
      : problem_(problem), coarse_(coarse) {}

  LeastSquaresResult solve() {
    result_ = solve_least_squares(coarse_);
    for (TriedStep& step : result_.steps) {
      step.kind = "coarse: " + step.kind;
      step.evaluations = 0;
    }
    result_.evaluations = 0;
    result_.values.resize(0);  // they are the coarse model's
    if (!has_solution(result_.ended)) return result_;
    VectorXd u = result_.u;
    while (try_at(u)) u = next();
    if (best_.u.size() == 0) return result_;
    result_.u = best_.u;
    result_.values = best_.values;
    result_.chi2 = best_.chi2;
    return result_;
  }

 private:
  /// Of the coarse model.
  static bool has_solution(Ended ended) {
    return ended == Ended::converged || ended == Ended::too_many_evaluations || ended == Ended::stalled;
  }

  double chi2_of(const VectorXd& values) const {
    double sum = 0;
    for (std::size_t i = 0; i < problem_.targets.size(); ++i) {
      const Target& target = problem_.targets[i];
      sum += std::pow((target.measured - values[Eigen::Index(i)]) / target.uncertainty, 2);
    }
    return sum;
  }
  bool end(Ended how) {
    result_.ended = how;
    is_over_ = true;
    return false;
  }

  /// Evaluates both models there; false where that ends the search.
  bool try_at(const VectorXd& u) {
    if (is_over_) return false;
    const Evaluation fine = problem_.evaluate({{u}}).front();
    result_.evaluations += fine.share;
    if (problem_.stopped()) return end(Ended::interrupted);
    const Evaluation coarse = coarse_.evaluate({{u}}).front();
    if (coarse_.stopped()) return end(Ended::interrupted);
    const std::string& trouble = fine.problem.empty() ? coarse.problem : fine.problem;
    Evaluated found{u, fine.values, coarse.values};
    if (trouble.empty()) found.chi2 = chi2_of(fine.values);
    return take(found, trouble);
  }

  bool take(const Evaluated& found, const std::string& trouble) {
    const bool is_first = best_.u.size() == 0, is_better = found.chi2 < best_.chi2;
    const bool is_level = !is_first && std::isinf(region_) &&
                          std::abs(found.chi2 - best_.chi2) <= negligible_change(problem_, best_.chi2);
    result_.steps.push_back({"step", found.u, result_.evaluations,
                             trouble.empty() ? found.chi2 : std::numeric_limits<double>::quiet_NaN(),
                             is_better, trouble});
    if (is_first && !trouble.empty()) {
      result_.u = found.u;
      result_.problem = trouble;
      return end(Ended::failed_at_start);
    }
    if (is_better)
      best_ = found;
    else
      region_ = (found.u - best_.u).cwiseAbs().maxCoeff() / 2;
    if (is_level) return end(Ended::converged);
    return result_.evaluations + 1 <= problem_.most_evaluations || end(Ended::too_many_evaluations);
  }

  /// The coarse model's values with what the costly one had more where it was evaluated last.
  Evaluation corrected(Evaluation found) const {
    for (std::size_t k = 0; k < problem_.targets.size() && found.problem.empty(); ++k) {
      const auto i = Eigen::Index(k);
      if (problem_.targets[k].logarithmic)
        found.values[i] *= best_.values[i] / best_.coarse[i];
      else
        found.values[i] += best_.values[i] - best_.coarse[i];
    }
    return found;
  }

  LeastSquaresProblem surrogate() const {
    LeastSquaresProblem problem = coarse_;
    problem.start = best_.u;
    problem.low = problem_.low.cwiseMax((best_.u.array() - region_).matrix());
    problem.high = problem_.high.cwiseMin((best_.u.array() + region_).matrix());
    problem.evaluate = [this](const std::vector<Trial>& trials) {
      std::vector<Evaluation> found = coarse_.evaluate(trials);
      for (Evaluation& one : found) one = corrected(std::move(one));
      return found;
    };
    return problem;
  }

  /// Where the corrected coarse model fits best; ends the search where that is no step.
  VectorXd next() {
    const LeastSquaresResult found = solve_least_squares(surrogate());
    if (coarse_.stopped()) end(Ended::interrupted);
    if (found.jacobian.size() > 0) result_.jacobian = found.jacobian;
    if (is_over_) return best_.u;
    const double step = (found.u - best_.u).cwiseAbs().maxCoeff();
    if (!has_solution(found.ended) || (step == 0 && found.ended != Ended::converged)) {
      end(Ended::stalled);
    } else if (step <= problem_.least_step ||
               best_.chi2 - found.chi2 <= negligible_change(problem_, found.chi2)) {
      end(step < 0.99 * region_ ? Ended::converged : Ended::stalled);
    }
    return found.u;
  }

  const LeastSquaresProblem& problem_;
  const LeastSquaresProblem& coarse_;
  LeastSquaresResult result_;
  Evaluated best_;
  double region_ = std::numeric_limits<double>::infinity();  ///< longest step of a coordinate
  bool is_over_ = false;
};

}  // namespace

LeastSquaresResult solve_by_coarse_model(const LeastSquaresProblem& problem,
                                         const LeastSquaresProblem& coarse) {
  return ByCoarseModel(problem, coarse).solve();
}

}  // namespace mss::fit

#pragma once

#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiments/advise/reference_levels.hpp"

namespace mss::advise {

/// The methods that advice chooses among: all that move a material, and numbers of iterations that pay.
std::vector<std::string> tried_methods();
/// A candidate in half the step, or a quarter of the tolerance: for what it does so by luck it errs more.
Candidate at_half_step(Candidate candidate);

/// For a run that nothing ends early.
inline bool to_its_end(const SampledRun&) { return true; }

/// Candidates that would take so much longer than the cheapest so far are dropped.
inline constexpr double cost_margin = 1.3;

/// The search for the cheapest candidate: lattices that keep the error, then methods for them.
class Search {
 public:
  Search(SceneFamily& family, const AdviseRequest& request, Progress& progress)
      : state_(family, request, progress), references_(state_) {}

  Advice find();
  Advice grid(int finest_level, int reference_level, bool pruned);

 private:
  /// What ends a trial early.
  struct Limits {
    double error = std::numeric_limits<double>::infinity();
    double cost = std::numeric_limits<double>::infinity();
  };
  enum class Result { meets, inaccurate, folds, costly, impossible };

  Result run(const Candidate& candidate, const Limits& limits);
  Result simulate(const Candidate& candidate, const Limits& limits);
  Result try_lattice(const Candidate& lattice);
  Limits worth() const { return {request().error + references_.uncertainty(), cost_margin * best_cost()}; }
  double least_cost(const Candidate& candidate) const;

  std::vector<Candidate> fillings(int level) const;
  std::vector<Candidate> find_lattices();
  int coarsest_plain();
  std::vector<std::vector<Candidate>> methods(const Candidate& lattice);
  void try_methods(const Candidate& lattice);
  void try_threads();
  void remeasure_cheapest(double worth = cost_margin);
  bool search();
  void check();
  bool passes_check(const Candidate& candidate);
  void verify_best();
  bool reconsider();
  bool compute_checking_reference();
  void refute_trials();
  bool folds(const Trajectory& trajectory) const;
  bool runs_well(Trial& trial);
  void check_with_elements();
  struct Motion {
    Trajectory trajectory;
    double cost;  ///< seconds charged for stepping per simulated second
  };
  std::optional<Motion> elements_at(int level);
  void decide_undecided(const ErrorEstimator& estimator, double uncertainty);
  void explain_budget();

  void try_reduced();
  std::optional<std::size_t> cheapest() const;
  std::string why_taken_or_left(bool (*is_such)(const Candidate&)) const;
  bool is_tied(std::size_t trial, std::size_t cheapest) const;
  bool wastes_threads(std::size_t trial, std::size_t cheapest) const;
  std::vector<std::size_t> as_cheap() const;
  std::optional<std::size_t> best() const;
  void judge_at_half_step(std::size_t trial);
  double best_cost() const;
  double error_of(const Candidate& candidate, const ErrorEstimator& estimator);
  bool stopped() { return state_.stopped(); }
  Advice result();

  const SceneFamily& family() const { return state_.family; }
  const AdviseRequest& request() const { return state_.request; }
  std::vector<Trial>& trials() { return state_.trials; }
  const std::vector<Trial>& trials() const { return state_.trials; }

  SearchState state_;
  ReferenceLevels references_;
  std::optional<ErrorEstimator> checking_;      ///< of a reference that the search did not use
  std::map<Lattice, double> checked_lattices_;  ///< their errors by it
  Advice advice_;                               ///< but for its trials
};

}  // namespace mss::advise

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "experiments/advise/reference_levels.hpp"

namespace mss::advise {

/// The search for the most accurate candidate that fits into a frame's budget, stays stable and folds no
/// cell, as engines ask: its error is said, not required. For every method it finds the smallest cells
/// that fit, then runs the best of them for long as `mss run` would.
class FrameSearch {
 public:
  FrameSearch(SceneFamily& family, const AdviseRequest& request, Progress& progress)
      : state_(family, request, progress), references_(state_) {}

  Advice find();

 private:
  using Chain = std::vector<Candidate>;
  std::vector<Candidate> lattices() const;
  std::optional<Candidate> in_cells(Candidate method, int level, double share_of_safe);
  double first_cost(const Candidate& method, int level, double share_of_safe);
  void fit(const Candidate& method, double share_of_safe = 1);
  int finest_fitting(const Candidate& method, double share_of_safe);
  bool run(const Candidate& candidate);
  void try_lattices();
  void try_methods(const Candidate& lattice);
  void judge_at_half_step(std::size_t trial);
  void remeasure();
  bool lasts(std::size_t trial);
  bool runs_clean(std::size_t trial);
  void verify_lattice();
  void verify();
  double judged(const Trial& trial) const;
  double least_jacobian() const;
  bool can_rank() const;
  std::optional<std::size_t> best() const;
  std::vector<std::size_t> ranked() const;
  std::vector<std::size_t> as_accurate() const;
  std::string why_nothing() const;
  Advice result();

  const SceneFamily& family() const { return state_.family; }
  double budget() const { return *state_.request.budget; }
  std::vector<Trial>& trials() { return state_.trials; }
  const std::vector<Trial>& trials() const { return state_.trials; }
  bool stopped() { return state_.stopped(); }

  SearchState state_;
  ReferenceLevels references_;
  int around_ = 0;  ///< a level near which cells fit
  Advice advice_;
};

}  // namespace mss::advise

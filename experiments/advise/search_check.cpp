// Whether what the search of `mss advise` found holds: against a finer reference, in half the step, run as
// `mss run` runs it, and beside finite elements.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/advise/search.hpp"
#include "experiments/simulation/simulation.hpp"

namespace mss::advise {

/// Shorter steps err less; where they err more, and too much, a candidate met the error by luck.
void Search::judge_at_half_step(std::size_t trial) {
  const Candidate half = at_half_step(trials()[trial].candidate);
  const auto settings = family().settings(half);
  const auto is_half = [&](const Trial& other) {
    return other.share > 0.999 && family().settings(other.candidate) == settings;
  };
  auto found = std::find_if(trials().begin(), trials().end(), is_half);
  if (found == trials().end()) {
    run(half, {});
    found = trials().end() - 1;
  }
  const bool fails = found->verdict == Verdict::failed || found->verdict == Verdict::folds ||
                     found->verdict == Verdict::impossible || !std::isfinite(found->error);
  Trial& judged = trials()[trial];
  judged.error_at_half_step = fails ? std::numeric_limits<double>::infinity() : found->error;
  if (stopped() || judged_error(judged) <= request().error) return;
  judged.meets = false;
  judged.verdict = Verdict::fluke;
}

/// Whether a candidate runs as it should, as `mss run` runs it: its rows may show a fold that samples missed,
/// and energy from nowhere, whatever it is of that errs little. The verdict says what is wrong.
bool Search::runs_well(Trial& trial) {
  const Scene scene = family().scene(trial.candidate);
  const SimulationResult result = mss::simulate(scene, state_.progress);
  for (const SeriesRow& row : result.series) {
    trial.min_jacobian = std::min(trial.min_jacobian, row.min_jacobian);
    trial.max_stretch = std::max(trial.max_stretch, row.max_stretch);
  }
  const bool folds = trial.min_jacobian <= 0 && !references_.folds();
  trial.meets = !folds && !result.gain;
  if (folds) trial.verdict = Verdict::folds;
  if (folds || !result.gain) return trial.meets;
  trial.verdict = Verdict::unclean;
  trial.problem = fmt::format("energy came from nowhere, {:.3g} percent of that at play",
                              100 * result.gain->gained / result.gain->at_play);
  return false;
}

double Search::error_of(const Candidate& candidate, const ErrorEstimator& estimator) {
  return estimator.error_of(state_.sample(family().scene(candidate), to_its_end).trajectory);
}

/// Trials that were too close to the requested error, if they are cheaper than the best.
void Search::decide_undecided(const ErrorEstimator& estimator, double uncertainty) {
  const double before = best_cost();
  bool others = false;
  for (Trial& trial : trials())
    if (!stopped() && trial.verdict == Verdict::undecided && trial.share == 1 && trial.cost < before &&
        error_of(trial.candidate, estimator) + uncertainty / 2 <= request().error) {
      trial.meets = others = true;
      trial.verdict = Verdict::meets;
    }
  if (others) remeasure_cheapest();
}

/// Errors by references that were refuted say nothing.
void Search::refute_trials() {
  for (Trial& trial : trials()) {
    if (!std::isfinite(trial.error)) continue;
    trial.meets = false;
    trial.error = trial.error_at_half_step = no_value;
    trial.verdict = Verdict::refuted;
  }
}

/// Computes a reference that was not used in the search, unless one would take too long, or fails. False if
/// it refutes those that were: then it is one of them, and what was found by them is worth nothing.
bool Search::compute_checking_reference() {
  const int finest = references_.finest().level, level = references_.checking_level();
  if (level == 0) return true;
  auto finer = references_.compute(level);
  if (!finer) return true;
  trials()[finer->trial].verdict = Verdict::checking_reference;
  const double by = double(level) / finest;
  checking_.emplace(request().of, references_.extrapolated()
                                      ? extrapolate(references_.finest().trajectory, finer->trajectory, by)
                                      : finer->trajectory);
  const double change = checking_->error_of(references_.estimator()->reference());
  if (change > references_.allowed_uncertainty()) {
    checking_.reset();
    references_.add(std::move(*finer));
    refute_trials();
    return false;
  }
  decide_undecided(*checking_, change / (by * by - 1));
  return true;
}

/// Candidates are not advised whose error against a reference that was not used in the search is too large,
/// or that fold or gain energy as `mss run` runs them.
void Search::check() {
  verify_best();
  if (stopped()) return;
  const auto chosen = best();
  const bool was_run_once = chosen && trials()[*chosen].costs.empty();
  if (!reconsider() && !was_run_once) return;
  remeasure_cheapest();
  verify_best();
}

/// Runs candidates again that were dropped for costing more than one that was rejected since. True if one
/// meets the error.
bool Search::reconsider() {
  std::vector<Candidate> dropped;
  for (const Trial& trial : trials())
    if ((trial.verdict == Verdict::costly || trial.verdict == Verdict::too_costly_to_run) &&
        trial.estimated_cost <= best_cost())
      dropped.push_back(trial.candidate);
  bool any = false;
  for (const Candidate& candidate : dropped)
    any = (!stopped() && run(candidate, worth()) == Result::meets) || any;
  return any;
}

/// Whether the lattice of a candidate is as accurate as requested against the checking reference. What its
/// cells err no method reduces: where they err too much, all candidates of that lattice fail.
bool Search::passes_check(const Candidate& candidate) {
  const Lattice lattice = lattice_of(candidate);
  if (!checked_lattices_.contains(lattice))
    checked_lattices_[lattice] = error_of(references_.accurate(candidate), *checking_);
  const double error = checked_lattices_[lattice];
  if (error <= request().error || stopped()) return true;
  for (Trial& trial : trials()) {
    if (!trial.meets || lattice_of(trial.candidate) != lattice) continue;
    trial.meets = false;
    trial.verdict = Verdict::fails_check;
    trial.checked_error = error;
  }
  return false;
}

void Search::verify_best() {
  while (const auto chosen = best()) {
    if (stopped()) return;
    if (checking_ && !passes_check(trials()[*chosen].candidate)) continue;
    if (std::isnan(trials()[*chosen].error_at_half_step)) {
      judge_at_half_step(*chosen);
      continue;
    }
    Trial& trial = trials()[*chosen];
    if (!runs_well(trial) || stopped()) continue;
    if (!checking_) return;
    trial.checked_error = advice_.checked_error = error_of(trial.candidate, *checking_);
    if (trial.checked_error <= request().error) return;
    trial.meets = false;
    trial.verdict = Verdict::fails_check;
  }
}

/// The motion of corotational elements; nothing, and the problem is recorded, if they fail or take longer
/// than a reference may.
std::optional<Search::Motion> Search::elements_at(int level) {
  std::string& problem = advice_.elements.problem;
  try {
    Candidate elements = family().candidate(level);
    elements.model = "corotational";
    elements.threads = family().given().solve.threads;
    Scene scene = family().scene(references_.accurate(elements));
    scene.solve.sleep = {};
    state_.progress.report(0.9, fmt::format("finite elements of {:.4g} m", family().cell_size(level)));
    SampledRun run = state_.sample(scene, [&](const SampledRun& so_far) {
      return so_far.cost() * scene.solve.duration < request().patience && !stopped();
    });
    if (run.status == Status::ok && !run.ended_early) return Motion{std::move(run.trajectory), run.cost()};
    problem = run.ended_early ? "they would take longer than --patience" : to_string(run.status);
  } catch (const InputError& error) {
    problem = error.what();
  }
  return std::nullopt;
}

void Search::check_with_elements() {
  if (!advice_.best || !family().takes_elements() || stopped()) return;
  const Candidate advised = trials()[*advice_.best].candidate;
  const std::optional<Motion> coarse = elements_at(advised.level);
  const std::optional<Motion> fine = coarse ? elements_at(2 * advised.level) : std::nullopt;
  if (!fine) return;
  const ErrorEstimator estimator(request().of, fine->trajectory);
  advice_.elements = {.level = 2 * advised.level,
                      .error = error_of(advised, estimator),
                      .uncertainty = estimator.error_of(coarse->trajectory) / 3,
                      .cost = coarse->cost,
                      .cost_of_finer = fine->cost};
}

}  // namespace mss::advise

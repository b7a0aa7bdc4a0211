// The search of `mss advise`: lattices that keep the error, then methods for them; costlier ones are not run
// to their end.
#include "experiments/advise/search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "experiments/advise/advise.hpp"
#include "experiments/harness/experiment.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/simulation/reduced_model.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/simulation.hpp"
#include "integrators/linear/linear_solver.hpp"
#include "reference/fem/solid_law.hpp"

namespace mss::advise {

namespace {

constexpr const char* nothing_meets =
    "nothing that was tried meets the error; more --patience tries finer cells";

/// A candidate in a sentence.
std::string description(const SceneFamily& family, const Trial& trial) {
  const Candidate& c = trial.candidate;
  return fmt::format("cells of {:.4g} m, {}, {}, {}: {} in {:.3g} ms a frame", family.cell_size(c.level),
                     c.model, c.integrator, to_string(c.precision), percent(trial.error),
                     trial.cost * to_frame);
}

bool is_matched(const Candidate& candidate) { return candidate.match.has_value(); }
bool is_reduced(const Candidate& candidate) { return reduction_named(candidate.model).has_value(); }
bool serves_all_motions(const Candidate& candidate) { return !serves_some_motions(candidate); }

std::string restricted_name(const SceneFamily& family, const Candidate& c) {
  return fmt::format("{}, cells of {:.4g} m", c.match ? "\"" + to_string(*c.match) + "\"" : c.model,
                     family.cell_size(c.level));
}

/// Of trials that meet the error, among those of some candidates.
std::optional<std::size_t> cheapest_of(const std::vector<Trial>& trials, bool (*is_such)(const Candidate&)) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < trials.size(); ++i)
    if (trials[i].meets && is_such(trials[i].candidate) && (!best || trials[i].cost < trials[*best].cost))
      best = i;
  return best;
}

/// How many evaluations of the force a step of an implicit method takes at least, in the smallest bodies.
double least_forces(const Candidate& candidate) {
  constexpr double factorisation = 30, general_factorisation = 300, iterations = 6, per_iteration = 3;
  const IntegratorInfo& method = find_integrator(candidate.integrator);
  if (method.linear_algebra == LinearAlgebra::own_factors) return general_factorisation;
  if (const std::size_t colon = method.name.find(':'); method.implicit && colon != std::string::npos)
    return per_iteration * std::stod(method.name.substr(colon + 1));
  if (!method.nonlinear_solver.empty() || method.linear_algebra == LinearAlgebra::own_products)
    return iterations;
  return find_linear_solver(candidate.linear_solver).products_only ? iterations : factorisation;
}

}  // namespace

bool serves_some_motions(const Candidate& candidate) {
  return is_matched(candidate) || is_reduced(candidate);
}

/// Not `verlet`, which is semi-implicit Euler in other variables.
std::vector<std::string> tried_methods() {
  std::vector<std::string> names = moving_families({});
  names.erase(std::remove(names.begin(), names.end(), "verlet"), names.end());
  for (const char* name :
       {"backward_euler/lbfgs:2", "backward_euler/lbfgs:3", "tr_bdf2/lbfgs:3", "tr_bdf2/lbfgs:5"})
    if (std::find(names.begin(), names.end(), name) == names.end()) names.emplace_back(name);
  return names;
}

Candidate at_half_step(Candidate candidate) {
  if (candidate.dt) *candidate.dt /= 2;
  candidate.tolerance /= 4;
  return candidate;
}

Search::Result Search::run(const Candidate& candidate, const Limits& limits) {
  Result result = Result::impossible;
  const bool possible = state_.attempt(candidate, [&] {
    if (const double least = least_cost(candidate); least > limits.cost) {
      trials().push_back({.candidate = candidate, .verdict = Verdict::too_costly_to_run});
      trials().back().estimated_cost = least;
      trials().back().best_before = best_cost();
      result = Result::costly;
    } else {
      result = simulate(candidate, limits);
    }
  });
  if (!possible && trials().back().verdict == Verdict::out_of_memory) return Result::costly;
  return result;
}

Search::Result Search::simulate(const Candidate& candidate, const Limits& limits) {
  constexpr double soon = 0.005;            // [s]; shorter times are uncertain,
  constexpr std::size_t few_intervals = 4;  // and so are fewer intervals,
  constexpr double far_too_costly = 10;     // unless they are this many times the limit
  const ErrorEstimator& estimator = *references_.estimator();
  Result result = Result::meets;
  double error = 0;
  const auto go_on = [&](const SampledRun& run) {
    if (estimator.known_early())
      error = std::max(error, estimator.error_at(run.trajectory, run.trajectory.samples.size() - 1));
    if (error > limits.error) result = Result::inaccurate;
    if (folds(run.trajectory)) result = Result::folds;
    const double times = run.total_seconds() > soon ? run.cost() / limits.cost : 0;
    if (times > (run.seconds.size() >= few_intervals ? 1 : far_too_costly)) result = Result::costly;
    return result == Result::meets && !stopped();
  };
  const Scene scene = family().scene(candidate);
  check_solve(scene);
  state_.progress.report(
      0.5, fmt::format("cells of {:.4g} m, {}", family().cell_size(candidate.level), candidate.integrator));
  const double most_seconds = far_too_costly * std::max(soon, limits.cost * state_.sampling.interval);
  const SampledRun run = state_.sample(scene, go_on, most_seconds);
  if (stopped()) return Result::impossible;
  if (run.ended_early && result == Result::meets) result = Result::costly;
  Trial trial{.candidate = candidate,
              .cost = run.cost(),
              .share = run.simulated / state_.sampling.duration(),
              .min_jacobian = run.trajectory.min_jacobian,
              .max_stretch = run.trajectory.max_stretch};
  trial.status = run.status;
  if (run.status != Status::ok)
    result = Result::inaccurate;
  else
    trial.error = run.ended_early && estimator.known_early() ? error : estimator.error_of(run.trajectory);
  if (result == Result::meets && folds(run.trajectory)) result = Result::folds;
  if (result == Result::meets && !references_.meets(trial.error)) result = Result::inaccurate;
  trial.meets = result == Result::meets;
  trial.estimated_cost = trial.cost;
  trial.best_before = best_cost();
  trial.verdict = trial.meets                             ? Verdict::meets
                  : result == Result::costly              ? Verdict::costly
                  : result == Result::folds               ? Verdict::folds
                  : run.status != Status::ok              ? Verdict::failed
                  : references_.is_undecided(trial.error) ? Verdict::undecided
                                                          : Verdict::inaccurate;
  trials().push_back(trial);
  return result;
}

std::optional<std::size_t> Search::cheapest() const {
  const std::optional<std::size_t> restricted = cheapest_of(trials(), serves_some_motions),
                                   other = cheapest_of(trials(), serves_all_motions);
  if (!restricted || !other) return other ? other : restricted;
  return worth_restricting * trials()[*restricted].cost <= trials()[*other].cost ? restricted : other;
}

/// Of candidates that serve some motions only; empty where none was tried.
std::string Search::why_taken_or_left(bool (*is_such)(const Candidate&)) const {
  const std::optional<std::size_t> such = cheapest_of(trials(), is_such);
  if (!such) {
    const Trial* nearest = nullptr;  // of those that ran furthest
    for (const Trial& trial : trials())
      if (is_such(trial.candidate) && std::isfinite(trial.error) &&
          (!nearest || std::pair(-trial.share, trial.error) < std::pair(-nearest->share, nearest->error)))
        nearest = &trial;
    const bool tried = std::any_of(trials().begin(), trials().end(),
                                   [&](const Trial& trial) { return is_such(trial.candidate); });
    if (!nearest) return tried ? "left; none has a known error, the table says why" : "";
    return fmt::format("left; the nearest, {}, errs by {} in {:.0f} % of the time: {}",
                       restricted_name(family(), nearest->candidate), percent(nearest->error),
                       100 * nearest->share, to_string(*nearest));
  }
  const std::optional<std::size_t> other = cheapest_of(trials(), serves_all_motions);
  const bool taken = advice_.best && is_such(trials()[*advice_.best].candidate);
  const std::string name = restricted_name(family(), trials()[taken ? *advice_.best : *such].candidate);
  if (!other)
    return fmt::format("{}: {}; no others were found to meet the error", taken ? "taken" : "left", name);
  const double cost = trials()[*such].cost;
  std::string text =
      fmt::format("{}: {}, the cheapest of them {:.2g} times as cheap as any that serve all motions",
                  taken ? "taken" : "left", name, trials()[*other].cost / cost);
  if (!taken && worth_restricting * cost > trials()[*other].cost)
    text += fmt::format(", and {:g} times is asked for", worth_restricting);
  return text;
}

double Search::best_cost() const {
  const auto best = cheapest();
  return best ? trials()[*best].cost : std::numeric_limits<double>::infinity();
}

/// What a candidate costs at least, in seconds per second. A force takes what it took the finest reference,
/// cell by cell. A method that chooses its steps still has to stop at every sample.
double Search::least_cost(const Candidate& candidate) const {
  if (references_.empty() || !find_integrator(candidate.integrator).implicit) return 0;
  const Candidate reference = references_.accurate(family().candidate(candidate.level));
  const double steps = state_.sampling.duration() / *reference.dt;
  const double force = references_.seconds_at(candidate.level) / steps;
  return force * least_forces(candidate) / candidate.dt.value_or(state_.sampling.interval);
}

/// What springs may be left out: of calibrated ones body diagonals, and the volume force where there is one.
/// Finite elements of the same material may fill the cells instead. Moduli of calibrated springs may be
/// matched.
std::vector<Candidate> Search::fillings(int level) const {
  std::vector<Candidate> all;
  for (const bool volume_force : {true, false})
    for (const double face_share : {0.5, 1.0}) {
      Candidate lattice = family().candidate(level);
      if (face_share != 0.5 && !family().is_calibrated()) continue;
      if (!volume_force && !family().has_volume_force()) continue;
      if (family().is_calibrated()) lattice.face_share = face_share;
      lattice.volume_force = lattice.volume_force && volume_force;
      all.push_back(lattice);
    }
  if (family().takes_elements())
    for (const SolidLaw& law : solid_laws()) {
      all.push_back(family().candidate(level));
      all.back().model = law.name;
    }
  using Of = FrequencyMatch::Of;
  if (family().is_calibrated() && family().given().body.is_solid())
    for (const Of of : {Of::bending, Of::torsion, Of::both, Of::modes}) {
      all.push_back(family().candidate(level));
      all.back().match = of;
      if (of == Of::both || of == Of::modes) all.back().face_share = 1;
    }
  return all;
}

Search::Result Search::try_lattice(const Candidate& lattice) {
  Result result = Result::impossible;
  state_.attempt(lattice, [&] {
    result =
        run(references_.accurate(lattice), {request().error + references_.uncertainty(), 4 * best_cost()});
  });
  return result;
}

/// The coarsest lattice of a reference that meets the error; where none does, a finer one, predicted from
/// errors that decrease with the square of the size of cells. 0 if there is none.
int Search::coarsest_plain() {
  constexpr double much = 4;  // a lattice is tried whether or not a reference could be made of it
  const std::vector<int> levels = all_levels();
  int coarsest = 0, missed = 0;
  for (const ReferenceLevels::Reference& reference : references_.all()) {
    const Trial& trial = trials()[reference.trial];
    if (trial.meets && coarsest == 0) coarsest = reference.level;
    if (!trial.meets && coarsest == 0) missed = reference.level;
  }
  const auto meets_at = [&](int level) {
    return !stopped() && try_lattice(family().candidate(level)) == Result::meets;
  };
  if (coarsest == 0) {
    const double error = trials()[references_.finest().trial].error;
    const double wanted = missed * std::sqrt(error / (request().error - references_.uncertainty()));
    for (const int level : levels) {
      if (references_.seconds_at(level) > much * request().patience) break;
      if (level > missed && level >= 0.95 * wanted && level <= 2 * wanted && meets_at(level)) return level;
    }
    return 0;
  }
  for (const int level : levels)
    if (level > missed && level < coarsest && meets_at(level)) return level;
  return coarsest;
}

/// For every filling the coarsest lattice that meets the error. The error of a coarser one is that of its
/// model, which no method reduces. Elements cost too much in cells where springs meet it, and may not in
/// larger ones. Where no cells as they are meet it, matched ones may.
std::vector<Candidate> Search::find_lattices() {
  const int plain_start = coarsest_plain(),
            start = plain_start != 0 ? plain_start : references_.finest().level;
  const std::vector<int> levels = all_levels();
  std::vector<Candidate> found;
  bool plain = true;  // the first filling, which meets the error at the start
  for (Candidate lattice : fillings(start)) {
    const auto result_at = [&](int level) {
      lattice.level = level;
      return stopped() ? Result::impossible : try_lattice(lattice);
    };
    if (std::exchange(plain, false) && plain_start != 0) {
      found.push_back(lattice);
      continue;
    }
    if (plain_start == 0 && !lattice.match) continue;
    auto at = std::find(levels.begin(), levels.end(), start);
    Result result = result_at(start);
    if (result == Result::inaccurate && at + 1 != levels.end()) result = result_at(*++at);
    while (result == Result::costly && at != levels.begin()) result = result_at(*--at);
    if (result != Result::meets) continue;
    while (at != levels.begin() && result_at(*(at - 1)) == Result::meets) --at;
    lattice.level = *at;
    found.push_back(lattice);
  }
  return found;
}

/// Methods for a lattice; within each, steps or tolerances from the longest on. Steps are frames over whole
/// numbers: at the end of a frame there is a picture.
std::vector<std::vector<Candidate>> Search::methods(const Candidate& lattice) {
  const SpectralBound bound = state_.family.bound(lattice);
  const double unit = safe_step("semi_implicit_euler", bound);
  std::vector<std::vector<Candidate>> all;
  const auto add = [&](Candidate c, double longest, double shortest) {
    std::vector<Candidate> chain;
    for (double dt = std::min(longest, state_.sampling.duration()); dt >= shortest || chain.empty();
         dt /= 2) {
      c.dt = frame_step(dt, state_.sampling);
      if (chain.empty() || *c.dt < 0.99 * *chain.back().dt) chain.push_back(c);
    }
    all.push_back(chain);
  };
  for (const Precision precision : {Precision::single, Precision::dbl})
    for (const std::string& name : tried_methods()) {
      const IntegratorInfo& method = find_integrator(name);
      Candidate c = lattice;
      c.precision = precision;
      c.integrator = name;
      if ((precision == Precision::single && (!method.make_single || lattice.model != spring_model)) ||
          (method.needs_springs() && lattice.model != spring_model))
        continue;
      if (method.stepping == Stepping::adaptive) {
        std::vector<Candidate> chain;
        c.dt.reset();
        for (const double tolerance : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
          c.tolerance = tolerance;
          chain.push_back(c);
        }
        all.push_back(chain);
      } else if (!method.nonlinear_solver.empty()) {
        add(c, frame, 4 * unit);
      } else if (method.implicit) {
        for (const char* solver : {"automatic", "matrix_free"}) {
          c.linear_solver = solver;
          add(c, frame, 4 * unit);
        }
      } else if (!method.limit) {
        add(c, frame, unit / 2);
      } else if (const double safe = safe_step(method.name, bound); safe > 0) {
        add(c, safe, safe / 8);
      }
    }
  return all;
}

/// Double precision is not tried where single meets the error or costs too much already.
void Search::try_methods(const Candidate& lattice) {
  std::set<std::string> settled;
  for (const std::vector<Candidate>& chain : methods(lattice)) {
    const bool is_double = chain.front().precision == Precision::dbl;
    if (is_double && settled.contains(chain.front().integrator)) continue;
    for (const Candidate& candidate : chain) {
      if (stopped()) return;
      const Result result = run(candidate, worth());
      if (result == Result::inaccurate || result == Result::folds) continue;
      if (!is_double && result != Result::impossible) settled.insert(candidate.integrator);
      break;  // shorter steps only cost more
    }
  }
}

/// Reduced bodies, whose error adds to that of their cells: of the largest cells that meet the error as they
/// are, and of the next smaller.
void Search::try_reduced() {
  constexpr std::size_t sizes = 2;
  if (family().given().model != spring_model) return;
  const std::vector<int> levels = all_levels();
  int start = references_.finest().level;
  for (const Trial& trial : trials())
    if (trial.meets && trial.candidate.model == spring_model && !is_matched(trial.candidate))
      start = std::min(start, trial.candidate.level);
  const auto from = std::find(levels.begin(), levels.end(), start);
  for (auto level = from; level != levels.end() && level < from + sizes; ++level)
    for (const char* model : {"modal", "modal_cubic", "modal_warped"}) {
      if (stopped()) return;
      Candidate reduced = family().candidate(*level);
      reduced.model = model;
      reduced.integrator = "reduced";
      reduced.precision = Precision::dbl;
      reduced.dt.reset();
      run(reduced, worth());
    }
}

/// More threads than one change no bit of a result and seldom save time: only the cheapest candidates are
/// tried with them.
void Search::try_threads() {
  constexpr std::size_t few = 3;
  if (family().given().solve.threads != 0) return;
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < trials().size(); ++i)
    if (trials()[i].meets && trials()[i].candidate.threads == 1 && !is_reduced(trials()[i].candidate))
      order.push_back(i);
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return trials()[a].cost < trials()[b].cost; });
  for (std::size_t i = 0; i < std::min(few, order.size()) && !stopped(); ++i) {
    Candidate candidate = trials()[order[i]].candidate;
    candidate.threads = 0;
    run(candidate, worth());
  }
}

/// Those that might be the cheapest once more, interleaved: single times of a busy machine mislead.
void Search::remeasure_cheapest(double worth) {
  constexpr int rounds = 7;
  std::vector<std::size_t> close;
  for (std::size_t i = 0; i < trials().size(); ++i)
    if (trials()[i].meets && trials()[i].cost <= worth * best_cost()) close.push_back(i);
  auto costs = measure_interleaved(rounds, close.size(), state_.progress, [&](std::size_t i) {
    return state_.sample(family().scene(trials()[close[i]].candidate), to_its_end).cost();
  });
  for (std::size_t i = 0; i < close.size(); ++i) {
    if (costs[i].empty()) continue;
    trials()[close[i]].cost = quartiles(costs[i]).median;
    trials()[close[i]].costs = std::move(costs[i]);
  }
}

/// Whether a trial may cost no more than the cheapest: by the lower quartile of rounds where both were run.
bool Search::is_tied(std::size_t trial, std::size_t cheapest) const {
  const std::vector<double>&a = trials()[trial].costs, &b = trials()[cheapest].costs;
  const double ratio =
      a.empty() || b.empty() ? trials()[trial].cost / trials()[cheapest].cost : quartiles_of_ratio(a, b).q1;
  return ratio <= 1 + cost_noise;
}

/// Whether it takes more threads for no less than one takes.
bool Search::wastes_threads(std::size_t trial, std::size_t cheapest) const {
  return trials()[trial].candidate.threads != 1 && trials()[cheapest].candidate.threads == 1;
}

/// Those that meet the error and cost as little as any, as far as the noise of times tells.
std::vector<std::size_t> Search::as_cheap() const {
  const auto least = cheapest();
  std::vector<std::size_t> all;
  for (std::size_t i = 0; least && i < trials().size(); ++i)
    if (trials()[i].meets &&
        serves_some_motions(trials()[i].candidate) == serves_some_motions(trials()[*least].candidate) &&
        (i == *least || (is_tied(i, *least) && !wastes_threads(i, *least))))
      all.push_back(i);
  return all;
}

/// Of these the most accurate.
std::optional<std::size_t> Search::best() const {
  const std::vector<std::size_t> all = as_cheap();
  if (all.empty()) return std::nullopt;
  return *std::min_element(all.begin(), all.end(), [&](std::size_t a, std::size_t b) {
    return judged_error(trials()[a]) < judged_error(trials()[b]);
  });
}

bool Search::folds(const Trajectory& trajectory) const {
  return trajectory.min_jacobian <= 0 && !references_.folds();
}

/// The nearest candidates on either side, where error and budget cannot be met together.
void Search::explain_budget() {
  const Trial nearest = trials()[*advice_.best];
  Candidate coarser = nearest.candidate;
  const double step_over_cell = coarser.dt.value_or(0) / family().cell_size(coarser.level);
  for (std::size_t i = reference_levels.size(); i-- > 0;) {
    const int level = reference_levels[i];
    if (level >= nearest.candidate.level || stopped()) continue;
    coarser.level = level;
    if (coarser.dt) coarser.dt = frame_step(step_over_cell * family().cell_size(level), state_.sampling);
    const std::size_t before = trials().size();
    run(coarser, {});
    if (trials().size() > before && trials().back().cost <= *request().budget) break;
  }
  verify_best();
  if (state_.was_stopped) return;
  advice_.best = best();
  if (!advice_.best) {
    advice_.explanation = nothing_meets;
    return;
  }
  advice_.within_budget = trials()[*advice_.best].cost <= *request().budget;
  if (advice_.within_budget) return;
  const Trial* within = nullptr;
  for (const Trial& trial : trials())
    if (trial.share > 0.999 && trial.cost <= *request().budget && std::isfinite(trial.error) &&
        trial.verdict != Verdict::folds && (within == nullptr || trial.error < within->error))
      within = &trial;
  advice_.explanation = fmt::format(
      "no way that was tried meets {} within {:.3g} ms a frame; nearest: {}; {}", percent(request().error),
      *request().budget * to_frame, description(family(), nearest),
      within == nullptr ? "nothing is that cheap" : "within the budget " + description(family(), *within));
}

Advice Search::result() {
  if (references_.estimator()) {
    advice_.about_matched = family().is_calibrated()
                                ? why_taken_or_left(is_matched)
                                : "not tried: springs are given, and E is what is matched";
    advice_.about_reduced = why_taken_or_left(is_reduced);
  }
  advice_.trials = std::move(state_.trials);
  advice_.stopped = state_.was_stopped;
  advice_.uncertainty = references_.uncertainty();
  if (references_.estimator()) {
    advice_.finest_level = references_.finest().level;
    advice_.reference_folds = references_.folds();
  }
  advice_.seconds = state_.watch.seconds();
  return std::move(advice_);
}

/// By the references so far. False if a finer one refutes them.
bool Search::search() {
  for (const Candidate& lattice : find_lattices()) try_methods(lattice);
  try_reduced();
  try_threads();
  if (!stopped()) remeasure_cheapest();
  if (stopped() || !cheapest()) return true;
  if (!compute_checking_reference()) return false;
  check();
  return true;
}

Advice Search::find() {
  bool accurate = false;
  do {
    accurate = references_.refine();
    if (references_.estimator()) references_.conclude();
  } while (accurate && !search());
  if (!accurate && !state_.was_stopped) advice_.explanation = references_.why_inaccurate();
  if (accurate) {
    if (!state_.was_stopped) advice_.best = best();
    if (!advice_.best && !state_.was_stopped) advice_.explanation = nothing_meets;
  }
  if (advice_.best) {
    advice_.within_budget = !request().budget || trials()[*advice_.best].cost <= *request().budget;
    if (!advice_.within_budget) explain_budget();
  }
  if (advice_.best) {
    for (const std::size_t tie : as_cheap())
      if (tie != *advice_.best) advice_.ties.push_back(tie);
    for (const std::size_t tie : advice_.ties) trials()[tie].verdict = Verdict::ties;
    trials()[*advice_.best].verdict = advice_.within_budget ? Verdict::advised : Verdict::cheapest;
    check_with_elements();
  }
  for (Trial& trial : trials())
    if (trial.verdict == Verdict::meets) trial.verdict = Verdict::meets_but_costlier;
  return result();
}

Advice Search::grid(int finest_level, int reference_level, bool pruned) {
  if (!references_.compute({reference_level / 2, reference_level * 3 / 4, reference_level})) {
    if (!state_.was_stopped) advice_.explanation = references_.why_grid_fails();
    return result();
  }
  for (const int level : all_levels()) {
    if (level > finest_level || stopped()) break;
    for (const Candidate& filling : fillings(level))
      state_.attempt(filling, [&] {
        for (const std::vector<Candidate>& chain : methods(filling))
          for (const Candidate& candidate : chain)
            if (!stopped())
              run(candidate, pruned
                                 ? Limits{.error = 1,
                                          .cost = std::min(10 * best_cost(), 40 * references_.cost_at(level))}
                                 : Limits{});
      });
  }
  try_threads();
  constexpr double misled = 2;  // by a single time
  if (!stopped()) remeasure_cheapest(misled);
  advice_.best = cheapest();
  if (!advice_.best && !state_.was_stopped) advice_.explanation = references_.why_grid_fails();
  advice_.within_budget = advice_.best && (!request().budget || best_cost() <= *request().budget);
  return result();
}

}  // namespace mss::advise

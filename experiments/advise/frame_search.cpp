// The search of `mss advise --of stability`: for every method the smallest cells that fit into a frame's
// budget.
#include "experiments/advise/frame_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "experiments/advise/advise.hpp"
#include "experiments/advise/search.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/simulation/diagnostics.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/simulation.hpp"

namespace mss::advise {

namespace {

/// Errors that differ by less are as good as equal: the reference is no better.
constexpr double error_noise = 0.1;
/// Candidates may take this share of a budget: the rest is for what else shares the machine's caches.
constexpr double used_share = 0.85;

/// Of errors, as judged; those that are not known come last.
double comparable(double error) {
  return std::isnan(error) ? std::numeric_limits<double>::infinity() : error;
}

}  // namespace

/// Springs that leave out what they may, touched by planes in every way. Without the volume force the
/// material is another one, so that it may be left out only where errors tell by how much.
std::vector<Candidate> FrameSearch::lattices() const {
  std::vector<Candidate> all;
  for (std::size_t contact = 0; contact < family().contacts().size(); ++contact)
    for (const bool volume_force : {true, false})
      for (const double face_share : {0.5, 1.0}) {
        Candidate lattice = family().candidate(1);
        lattice.contact = contact;
        lattice.precision = family().given().model == spring_model ? Precision::single : Precision::dbl;
        if (face_share != 0.5 && !family().is_calibrated()) continue;
        if (!volume_force && (!family().has_volume_force() || !can_rank())) continue;
        if (family().is_calibrated()) lattice.face_share = face_share;
        lattice.volume_force = lattice.volume_force && volume_force;
        all.push_back(lattice);
      }
  return all;
}

/// A method in cells of a level: with a limit its safe step, or a share of that; without one the step it has.
/// Nothing where the scene has no such cells.
std::optional<Candidate> FrameSearch::in_cells(Candidate method, int level, double share_of_safe) {
  method.level = level;
  std::optional<Candidate> candidate;
  state_.attempt(method, [&] {
    if (find_integrator(method.integrator).limit) {
      const double safe = safe_step(method.integrator, state_.family.bound(method));
      if (safe == 0) return;
      method.dt = frame_step(share_of_safe * std::min(safe, state_.sampling.duration()), state_.sampling);
    }
    check_solve(family().scene(method));
    candidate = method;
  });
  return candidate;
}

/// Of the first frames in cells of a level; infinite where they fail or cannot be.
double FrameSearch::first_cost(const Candidate& method, int level, double share_of_safe) {
  constexpr double enough = 0.01;  // [s] to time
  constexpr double frames = 2;
  constexpr double far_too_costly = 4;
  double cost = std::numeric_limits<double>::infinity();
  const std::size_t trials_before = trials().size();
  state_.attempt(method, [&] {
    const auto candidate = in_cells(method, level, share_of_safe);
    if (!candidate) return;
    const SampledRun run = state_.sample(
        family().scene(*candidate),
        [&](const SampledRun& so_far) {
          return (so_far.total_seconds() < enough || so_far.simulated < frames * frame) && !stopped();
        },
        std::max(enough, far_too_costly * budget() * state_.sampling.interval));
    if (run.status == Status::ok) cost = run.cost();
  });
  trials().resize(trials_before);  // what cannot be on the way
  return cost;
}

/// The finest level whose first frames fit; 0 if none does. From level to level costs grow with the number of
/// cells, where steps shrink with them once more, and with factors of matrices more than that: such methods
/// begin in much larger cells, as one step in small ones may take longer than all else.
int FrameSearch::finest_fitting(const Candidate& method, double share_of_safe) {
  constexpr int tries = 6;
  constexpr double most_growth = 2;
  const IntegratorInfo& info = find_integrator(method.integrator);
  const bool factors = info.implicit && info.nonlinear_solver.empty();
  const double growth = factors ? 5 : info.limit ? 4 : 3;
  const std::vector<int> levels = all_levels();
  const auto index_near = [&](double level) {
    return std::ptrdiff_t(std::upper_bound(levels.begin(), levels.end(), level + 0.01) - levels.begin()) - 1;
  };
  std::ptrdiff_t fits = -1, exceeds = std::ptrdiff_t(levels.size());
  std::ptrdiff_t at = std::max<std::ptrdiff_t>(0, index_near(std::max(1, factors ? around_ / 3 : around_)));
  for (int n = 0; n < tries && fits + 1 < exceeds && !stopped(); ++n) {
    const int level = levels[std::size_t(at)];
    const double cost = first_cost(method, level, share_of_safe);
    (cost <= used_share * budget() ? fits : exceeds) = at;
    const double wanted = std::pow(used_share * budget() / cost, 1 / growth);
    at = std::clamp(index_near(level * std::clamp(wanted, 1 / most_growth, most_growth)), fits + 1,
                    exceeds - 1);
  }
  return fits < 0 ? 0 : levels[std::size_t(fits)];
}

/// Runs the scene with a candidate; true if it fits, stays finite and unfolded.
bool FrameSearch::run(const Candidate& candidate) {
  constexpr std::size_t few_intervals = 8;
  constexpr double far_too_costly = 4, soon = 0.005;
  Verdict verdict = Verdict::meets;
  const auto go_on = [&](const SampledRun& so_far) {
    if (so_far.trajectory.min_jacobian <= least_jacobian()) verdict = Verdict::folds;
    if (so_far.seconds.size() >= few_intervals && so_far.total_seconds() > soon &&
        so_far.cost() > (1 + cost_noise) * budget())
      verdict = Verdict::over_budget;
    return verdict == Verdict::meets && !stopped();
  };
  state_.progress.report(
      0.5, fmt::format("cells of {:.4g} m, {}", family().cell_size(candidate.level), candidate.integrator));
  bool fits = false;
  state_.attempt(candidate, [&] {
    const SampledRun run =
        state_.sample(family().scene(candidate), go_on,
                      far_too_costly * std::max(soon, budget() * state_.sampling.interval));
    if (stopped()) return;
    if (run.trajectory.min_jacobian <= least_jacobian()) verdict = Verdict::folds;
    if (verdict == Verdict::meets && (run.ended_early || std::max(run.cost(), run.busiest()) > budget()))
      verdict = Verdict::over_budget;
    if (run.status != Status::ok) verdict = Verdict::failed;
    Trial trial{.candidate = candidate, .cost = run.cost(), .verdict = verdict};
    trial.share = run.simulated / state_.sampling.duration();
    trial.status = run.status;
    trial.min_jacobian = run.trajectory.min_jacobian;
    trial.max_stretch = run.trajectory.max_stretch;
    if (references_.estimator() && run.status == Status::ok)
      trial.error = references_.estimator()->error_of(run.trajectory);
    trial.meets = fits = verdict == Verdict::meets;
    trials().push_back(trial);
  });
  return fits;
}

/// Runs a method in the smallest cells that fit; where it folds there or costs more than at first, in the
/// next larger ones.
void FrameSearch::fit(const Candidate& method, double share_of_safe) {
  constexpr int tries = 3;
  const std::vector<int> levels = all_levels();
  auto level = std::find(levels.begin(), levels.end(), finest_fitting(method, share_of_safe));
  if (level == levels.end()) return;
  for (int n = 0; n < tries && !stopped(); ++n) {
    const auto candidate = in_cells(method, *level, share_of_safe);
    if (candidate && run(*candidate)) {
      around_ = *level;
      return;
    }
    if (level == levels.begin()) return;
    --level;
  }
}

/// Which springs, and which law of contact: by the method with one force a step.
void FrameSearch::try_lattices() {
  for (Candidate lattice : lattices()) {
    if (stopped()) return;
    lattice.integrator = "semi_implicit_euler";
    fit(lattice);
  }
}

/// All methods of fixed steps, at their safe step and half of it, or without a limit at 1, 2, 4 ... steps a
/// frame.
void FrameSearch::try_methods(const Candidate& lattice) {
  constexpr int most_steps = 32;
  constexpr double much_larger = 1.5;  // cells, which more steps a frame make larger yet
  const int fits_explicitly = around_;
  for (const std::string& name : tried_methods()) {
    const IntegratorInfo& method = find_integrator(name);
    if (method.stepping != Stepping::fixed || (method.needs_springs() && lattice.model != spring_model))
      continue;
    Candidate c = lattice;
    c.integrator = name;
    if (!method.make_single) c.precision = Precision::dbl;
    if (method.limit) {
      if (name != "semi_implicit_euler") fit(c);
      continue;
    }
    for (int steps = 1; steps <= most_steps && !stopped(); steps *= 2) {
      c.dt = frame / steps;
      if (*c.dt > state_.sampling.duration()) continue;
      const std::size_t before = trials().size();
      fit(c);
      if (trials().size() == before || much_larger * trials()[before].candidate.level < fits_explicitly)
        break;
    }
  }
}

/// Where corners of cells keep less of their volume, another landing would fold them; but half as much as in
/// the reference is enough.
double FrameSearch::least_jacobian() const {
  constexpr double nearly_folded = 0.1;
  if (references_.empty()) return nearly_folded;
  return std::clamp(references_.finest().trajectory.min_jacobian / 2, 0.0, nearly_folded);
}

/// Its error; where the reference is too uncertain to tell errors apart, the size of its cells in its place.
double FrameSearch::judged(const Trial& trial) const {
  if (!can_rank()) return family().cell_size(trial.candidate.level);
  return comparable(judged_error(trial));
}

bool FrameSearch::can_rank() const {
  constexpr double most_uncertain = 0.5;
  return references_.estimator() && references_.uncertainty() <= most_uncertain;
}

/// Those that fit, from the most accurate on.
std::vector<std::size_t> FrameSearch::ranked() const {
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < trials().size(); ++i)
    if (trials()[i].meets) all.push_back(i);
  std::stable_sort(all.begin(), all.end(),
                   [&](std::size_t a, std::size_t b) { return judged(trials()[a]) < judged(trials()[b]); });
  return all;
}

/// By what a candidate errs less than in half its step, it errs so by luck; and where it folds in that step,
/// it stays unfolded by luck.
void FrameSearch::judge_at_half_step(std::size_t trial) {
  const Candidate half = at_half_step(trials()[trial].candidate);
  double error = no_value;
  bool is_sound = false;
  state_.attempt(half, [&] {
    const SampledRun run = state_.sample(family().scene(half), [&](const SampledRun&) { return !stopped(); });
    is_sound = run.status == Status::ok && run.trajectory.min_jacobian > least_jacobian();
    if (run.status == Status::ok && references_.estimator())
      error = references_.estimator()->error_of(run.trajectory);
  });
  Trial& judged = trials()[trial];
  judged.ran_at_half_step = true;
  judged.error_at_half_step = is_sound ? error : std::numeric_limits<double>::infinity();
  if (is_sound) return;
  judged.meets = false;
  judged.verdict = Verdict::fluke;
}

/// Of those that err as little as any, the cheapest first.
std::vector<std::size_t> FrameSearch::as_accurate() const {
  std::vector<std::size_t> all = ranked();
  if (all.empty()) return all;
  const double most = (1 + error_noise) * judged(trials()[all.front()]);
  std::erase_if(all, [&](std::size_t i) { return judged(trials()[i]) > most; });
  std::stable_sort(all.begin(), all.end(),
                   [&](std::size_t a, std::size_t b) { return trials()[a].cost < trials()[b].cost; });
  return all;
}

std::optional<std::size_t> FrameSearch::best() const {
  const std::vector<std::size_t> all = as_accurate();
  return all.empty() ? std::nullopt : std::optional(all.front());
}

/// The best and its rivals once more, interleaved. Their upper quartile has to fit.
void FrameSearch::remeasure() {
  constexpr int rounds = 7;
  constexpr std::size_t most = 8;
  std::vector<std::size_t> close = as_accurate();
  if (close.size() > most) close.resize(most);
  auto costs = measure_interleaved(rounds, close.size(), state_.progress, [&](std::size_t i) {
    return state_.sample(family().scene(trials()[close[i]].candidate), [](const SampledRun&) { return true; })
        .cost();
  });
  for (std::size_t i = 0; i < close.size(); ++i) {
    Trial& trial = trials()[close[i]];
    if (costs[i].empty()) continue;
    const auto [median, q1, q3] = quartiles(costs[i]);
    trial.cost = median;
    trial.costs = std::move(costs[i]);
    trial.meets = q3 <= budget();
    if (!trial.meets) trial.verdict = Verdict::over_budget;
  }
}

/// Runs a candidate for long: bodies that lie on planes cost more than those that fall. False, and its
/// verdict says why, if its busiest frames exceed the budget, or it folds.
bool FrameSearch::lasts(std::size_t trial) {
  constexpr std::size_t lately = 8;  // intervals
  Scene scene = family().scene(trials()[trial].candidate);
  scene.solve.duration = std::max(scene.solve.duration, clean_seconds);
  state_.progress.report(0.8, fmt::format("{:.3g} s of {}", scene.solve.duration, scene.solve.integrator));
  const Sampling sampling = sampling_of(scene, state_.request.of);
  const SampledRun run = sample_scene(
      scene, sampling,
      [&](const SampledRun& so_far) {
        const std::size_t count = so_far.seconds.size();
        double spent = 0;
        for (std::size_t i = count - std::min(lately, count); i < count; ++i) spent += so_far.seconds[i];
        const double most = lately * budget() * so_far.simulated / double(count);
        return spent <= (1 + cost_noise) * most && so_far.trajectory.min_jacobian > least_jacobian() &&
               !stopped();
      },
      state_.request.charge);
  if (stopped()) return false;
  Trial& tried = trials()[trial];
  tried.status = run.status;
  tried.min_jacobian = std::min(tried.min_jacobian, run.trajectory.min_jacobian);
  tried.max_stretch = std::max(tried.max_stretch, run.trajectory.max_stretch);
  tried.busiest =
      run.ended_early ? run.seconds.back() * double(run.seconds.size()) / run.simulated : run.busiest();
  tried.verdict = run.status != Status::ok                      ? Verdict::failed
                  : tried.min_jacobian <= least_jacobian()      ? Verdict::folds
                  : run.ended_early || tried.busiest > budget() ? Verdict::over_budget
                                                                : Verdict::meets;
  return tried.meets = tried.verdict == Verdict::meets;
}

/// Whether `mss run` of a candidate for long has nothing to warn of.
bool FrameSearch::runs_clean(std::size_t trial) {
  Scene scene = family().scene(trials()[trial].candidate);
  scene.solve.duration = std::max(scene.solve.duration, clean_seconds);
  const SimulationResult result = simulate(scene, state_.progress);
  if (stopped()) return false;
  Trial& tried = trials()[trial];
  for (const SeriesRow& row : result.series) {
    tried.min_jacobian = std::min(tried.min_jacobian, row.min_jacobian);
    tried.max_stretch = std::max(tried.max_stretch, row.max_stretch);
  }
  const std::vector<std::string> warnings = diagnostics_of(scene, result);
  tried.meets = tried.min_jacobian > least_jacobian() && warnings.empty();
  if (tried.meets) return true;
  tried.verdict = tried.min_jacobian <= least_jacobian() ? Verdict::folds : Verdict::unclean;
  if (!warnings.empty()) tried.problem = warnings.front();
  return false;
}

/// Until the best has been run for long, which also settles which springs and contact there are.
void FrameSearch::verify_lattice() {
  while (const auto chosen = best()) {
    if (stopped() || lasts(*chosen)) return;
  }
}

/// Until the best has been run for long, in half its step, and timed beside its rivals.
void FrameSearch::verify() {
  std::set<std::size_t> clean;
  while (const auto chosen = best()) {
    if (stopped() || clean.contains(*chosen)) return;
    if (std::isnan(trials()[*chosen].busiest))
      lasts(*chosen);
    else if (trials()[*chosen].costs.empty())
      remeasure();
    else if (!trials()[*chosen].ran_at_half_step)
      judge_at_half_step(*chosen);
    else if (runs_clean(*chosen))
      clean.insert(*chosen);
  }
}

std::string FrameSearch::why_nothing() const {
  std::string text =
      fmt::format("nothing that was tried fits {:.3g} ms a frame, stable and unfolded", budget() * to_frame);
  const Trial* cheapest = nullptr;
  for (const Trial& trial : trials())
    if (trial.verdict == Verdict::over_budget && (cheapest == nullptr || trial.cost < cheapest->cost))
      cheapest = &trial;
  for (const Trial& trial : trials())
    if (trial.verdict == Verdict::unclean) return text + "; the nearest: " + trial.problem;
  if (cheapest != nullptr)
    text +=
        fmt::format("; the cheapest, {} in cells of {:.4g} m, takes {:.3g}", cheapest->candidate.integrator,
                    family().cell_size(cheapest->candidate.level), cheapest->cost * to_frame);
  return text + "; give a larger --budget, or a softer material";
}

Advice FrameSearch::result() {
  advice_.trials = std::move(state_.trials);
  advice_.stopped = state_.was_stopped;
  if (references_.estimator()) {
    advice_.uncertainty = references_.uncertainty();
    advice_.finest_level = references_.finest().level;
    advice_.reference_folds = references_.folds();
  }
  advice_.errors_rank = can_rank();
  advice_.seconds = state_.watch.seconds();
  return std::move(advice_);
}

Advice FrameSearch::find() {
  references_.refine_with_patience();
  if (references_.estimator()) references_.conclude_without_request();
  const std::size_t first = trials().size();
  try_lattices();
  verify_lattice();
  const auto lattice = best();
  if (lattice && !stopped()) {
    const Candidate cheapest = trials()[*lattice].candidate;  // a copy: trials grow meanwhile
    try_methods(cheapest);
  }
  verify();
  if (!state_.was_stopped) advice_.best = best();
  advice_.within_budget = advice_.best.has_value();
  if (!advice_.best && !state_.was_stopped) advice_.explanation = why_nothing();
  for (std::size_t i = first; i < trials().size(); ++i) {
    Trial& trial = trials()[i];
    if (!advice_.best || !trial.meets) continue;
    trial.verdict = Verdict::fits;
    const bool is_tied = i != *advice_.best &&
                         judged(trial) <= (1 + error_noise) * judged(trials()[*advice_.best]) &&
                         trial.cost <= (1 + cost_noise) * trials()[*advice_.best].cost;
    if (is_tied) advice_.ties.push_back(i);
  }
  if (advice_.best) trials()[*advice_.best].verdict = Verdict::advised;
  return result();
}

}  // namespace mss::advise

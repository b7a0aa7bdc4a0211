// The search of `mss advise`: lattices that keep the error, then methods for them, dearer ones never to their
// end.
#include "experiments/advise/advise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/advise/search.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/statistics.hpp"
#include "experiments/simulation/simulation.hpp"

namespace mss::advise {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

constexpr const char* nothing_meets =
    "nothing that was tried meets the error; more --patience tries finer cells";
constexpr const char* too_close = "too close to what is asked to be sure";

/// A candidate in a sentence.
std::string tell(const SceneFamily& family, const Trial& trial) {
  const Candidate& c = trial.candidate;
  return fmt::format("cells of {:.4g} m, {}, {}: {} in {:.3g} ms a frame", family.cell_size(c.level),
                     c.integrator, c.precision == Precision::single ? "single" : "double",
                     percent(trial.error), trial.cost * 1e3 / frames_per_second);
}

/// How many evaluations of the force a step of an implicit method takes at least, in the smallest bodies.
double least_forces(const Candidate& candidate) {
  constexpr double factorisation = 30, general_factorisation = 300, iterations = 6;
  if (candidate.integrator == "cvode_bdf_klu") return general_factorisation;
  const bool iterates = candidate.linear_solver == "matrix_free" || candidate.integrator == "cvode_bdf_gmres";
  return iterates ? iterations : factorisation;
}

}  // namespace

void Search::add(const Candidate& candidate, const std::string& verdict) {
  Trial trial;
  trial.candidate = candidate;
  trial.verdict = verdict;
  advice_.trials.push_back(trial);
}

Search::Outcome Search::run(const Candidate& candidate, const Limits& limits) {
  return attempt(candidate, [&] {
    if (const double least = least_cost(candidate); least > limits.cost) {
      add(candidate, "would take at least " + times_the_best(least));
      return Outcome::dear;
    }
    return follow(candidate, limits);
  });
}

Search::Outcome Search::follow(const Candidate& candidate, const Limits& limits) {
  constexpr double soon = 0.005;         // [s]; times below say little,
  constexpr std::size_t soon_looks = 4;  // and so do fewer,
  constexpr double far_too_dear = 10;    // unless they say this
  Outcome outcome = Outcome::meets;
  double error = 0;
  const auto go_on = [&](const Followed& run) {
    if (judge_->sees_early())
      error = std::max(error, judge_->at(run.trajectory, run.trajectory.looks.size() - 1));
    if (error > limits.error) outcome = Outcome::wrong;
    const double times = run.total_seconds() > soon ? run.cost() / limits.cost : 0;
    if (times > (run.seconds.size() >= soon_looks ? 1 : far_too_dear)) outcome = Outcome::dear;
    return outcome == Outcome::meets && !stopped();
  };
  const Scene scene = family_.scene(candidate);
  check_solve(scene);
  progress_.report(
      0.5, fmt::format("cells of {:.4g} m, {}", family_.cell_size(candidate.level), candidate.integrator));
  const double most_seconds = far_too_dear * std::max(soon, limits.cost * looks_.interval);
  const Followed run = follow_scene(scene, looks_, go_on, most_seconds);
  if (stopped()) return Outcome::impossible;
  if (run.ended_early && outcome == Outcome::meets) outcome = Outcome::dear;
  Trial trial;
  trial.candidate = candidate;
  trial.cost = run.cost();
  trial.share = run.simulated / scene.solve.duration;
  if (run.status != Status::ok) {
    trial.verdict = to_string(run.status);
    outcome = Outcome::wrong;
  } else {
    trial.error = run.ended_early && judge_->sees_early() ? error : judge_->over_all(run.trajectory);
  }
  if (outcome == Outcome::meets && !meets(trial.error)) outcome = Outcome::wrong;
  trial.meets = outcome == Outcome::meets;
  if (trial.meets)
    trial.verdict = meets_it;
  else if (outcome == Outcome::dear)
    trial.verdict = "would take " + times_the_best(trial.cost);
  else if (trial.verdict.empty())
    trial.verdict = is_undecided(trial.error) ? too_close : too_wrong;
  advice_.trials.push_back(trial);
  return outcome;
}

std::optional<std::size_t> Search::cheapest() const {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < advice_.trials.size(); ++i)
    if (advice_.trials[i].meets && (!best || advice_.trials[i].cost < advice_.trials[*best].cost)) best = i;
  return best;
}

double Search::best_cost() const {
  const auto best = cheapest();
  return best ? advice_.trials[*best].cost : std::numeric_limits<double>::infinity();
}

std::string Search::times_the_best(double cost) const {
  if (std::isfinite(best_cost()))
    return fmt::format("{:.2g} times as long as the best before", cost / best_cost());
  return fmt::format("{:.2g} s a second, and nothing has met the error yet", cost);
}

/// What the method of references costs there: cells go with the cube of the level, steps with the level.
double Search::accurate_cost(int level) const { return seconds_at(level) / family_.asked().solve.duration; }

/// What a candidate costs at least, in seconds per second. A force takes what it took the finest reference,
/// cell by cell. A method that chooses its steps still has to show itself at every look.
double Search::least_cost(const Candidate& candidate) const {
  if (ladder_.empty() || !find_integrator(candidate.integrator).implicit) return 0;
  const double steps = family_.asked().solve.duration / accurate({.level = candidate.level}).dt;
  const double force = seconds_at(candidate.level) / steps;
  return force * least_forces(candidate) / (candidate.dt > 0 ? candidate.dt : looks_.interval);
}

/// What springs may be left out: of calibrated ones body diagonals, and the volume force where there is one.
std::vector<Candidate> Search::fillings(int level) const {
  std::vector<Candidate> all;
  for (const bool volume_force : {true, false})
    for (const double face_share : {0.5, 1.0}) {
      if (face_share != 0.5 && !family_.is_calibrated()) continue;
      if (!volume_force && !family_.has_volume_force()) continue;
      Candidate lattice{.level = level};
      lattice.face_share = face_share;
      lattice.volume_force = volume_force;
      all.push_back(lattice);
    }
  return all;
}

Search::Outcome Search::try_lattice(const Candidate& lattice) {
  return attempt(lattice, [&] {
    return run(accurate(lattice), {ask_.error + advice_.uncertainty, 4 * best_cost()});
  });
}

/// The coarsest of the lattices that references are made of to meet the error; where none does, a finer one,
/// from the square by which errors fall. 0 if there is none.
int Search::coarsest_plain() {
  constexpr double much = 4;  // a lattice is tried whether or not a reference could be made of it
  const std::vector<int> levels = all_levels();
  int coarsest = 0, missed = 0;
  for (const Rung& rung : ladder_) {
    const Trial& trial = advice_.trials[rung.trial];
    if (trial.meets && coarsest == 0) coarsest = rung.level;
    if (!trial.meets && coarsest == 0) missed = rung.level;
  }
  const auto meets_at = [&](int level) {
    return !stopped() && try_lattice(Candidate{.level = level}) == Outcome::meets;
  };
  if (coarsest == 0) {
    const double error = advice_.trials[ladder_.back().trial].error;
    const double wanted = missed * std::sqrt(error / (ask_.error - advice_.uncertainty));
    for (const int level : levels) {
      if (seconds_at(level) > much * ask_.patience) break;
      if (level > missed && level >= 0.95 * wanted && level <= 2 * wanted && meets_at(level)) return level;
    }
    return 0;
  }
  for (const int level : levels)
    if (level > missed && level < coarsest && meets_at(level)) return level;
  return coarsest;
}

/// Of every filling the coarsest lattice that meets the error. What a coarser one misses is what its model
/// leaves out, and no method brings it back.
std::vector<Candidate> Search::find_lattices() {
  const int start = coarsest_plain();
  if (start == 0) return {};
  const std::vector<int> levels = all_levels();
  std::vector<Candidate> found;
  for (Candidate lattice : fillings(start)) {
    const auto meets_at = [&](int level) {
      lattice.level = level;
      return !stopped() && try_lattice(lattice) == Outcome::meets;
    };
    if (lattice.face_share == Candidate().face_share && lattice.volume_force) {
      found.push_back(lattice);
      continue;
    }
    auto at = std::find(levels.begin(), levels.end(), start);
    if (meets_at(start)) {
      while (at != levels.begin() && meets_at(*(at - 1))) --at;
    } else if (at + 1 == levels.end() || !meets_at(*++at)) {
      continue;
    }
    lattice.level = *at;
    found.push_back(lattice);
  }
  return found;
}

/// Methods for a lattice; within each, steps or tolerances from the longest on.
std::vector<std::vector<Candidate>> Search::methods(const Candidate& lattice) {
  const SpectralBound bound = family_.bound(lattice);
  // The scene wants to be seen that often, and what nobody sees cannot be judged.
  const double longest = std::min(family_.asked().solve.every, family_.asked().solve.duration);
  const double unit = safe_step("semi_implicit_euler", bound);
  std::vector<std::vector<Candidate>> all;
  const auto steps = [&](Candidate c, double most, std::initializer_list<double> shares) {
    std::vector<Candidate> chain;
    for (const double share : shares) {
      c.dt = step_between_looks(std::min(share * most, longest), looks_);
      if (chain.empty() || c.dt < 0.99 * chain.back().dt) chain.push_back(c);
    }
    all.push_back(chain);
  };
  for (const Precision precision : {Precision::single, Precision::dbl})
    for (const IntegratorInfo& method : integrators()) {
      Candidate c = lattice;
      c.precision = precision;
      c.integrator = method.name;
      if (method.stepping == Stepping::equilibrium || (precision == Precision::single && !method.make_single))
        continue;
      if (method.stepping == Stepping::adaptive) {
        std::vector<Candidate> chain;
        for (const double tolerance : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
          c.tolerance = tolerance;
          chain.push_back(c);
        }
        all.push_back(chain);
      } else if (method.implicit) {
        for (const char* solver : {"cholmod", "matrix_free"}) {
          c.linear_solver = solver;
          steps(c, unit, {256, 128, 64, 32, 16, 8, 4});
        }
      } else if (const double safe = safe_step(method.name, bound); safe > 0) {
        steps(c, safe, {1, 0.5, 0.25, 0.125});
      }
    }
  return all;
}

void Search::try_methods(const Candidate& lattice) {
  for (const std::vector<Candidate>& chain : methods(lattice))
    for (const Candidate& candidate : chain) {
      if (stopped()) return;
      if (run(candidate, worth()) != Outcome::wrong) break;  // shorter steps only cost more
    }
}

/// More threads than one change no bit, and seldom pay: the cheapest are asked.
void Search::try_threads() {
  constexpr std::size_t few = 3;
  if (family_.asked().solve.threads != 0) return;
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < advice_.trials.size(); ++i)
    if (advice_.trials[i].meets && advice_.trials[i].candidate.threads == 1) order.push_back(i);
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return advice_.trials[a].cost < advice_.trials[b].cost; });
  for (std::size_t i = 0; i < std::min(few, order.size()) && !stopped(); ++i) {
    Candidate candidate = advice_.trials[order[i]].candidate;
    candidate.threads = 0;
    run(candidate, worth());
  }
}

/// Those that might be the cheapest once more, in turns: single times of a busy machine mislead.
void Search::time_again(double worth) {
  constexpr int rounds = 5;
  std::vector<std::size_t> close;
  for (std::size_t i = 0; i < advice_.trials.size(); ++i)
    if (advice_.trials[i].meets && advice_.trials[i].cost <= worth * best_cost()) close.push_back(i);
  std::vector<std::vector<double>> costs(close.size());
  interleave(rounds, close.size(), progress_, [&](std::size_t i) {
    const Followed run = follow_scene(family_.scene(advice_.trials[close[i]].candidate), looks_,
                                      [](const Followed&) { return true; });
    costs[i].push_back(run.cost());
  });
  for (std::size_t i = 0; i < close.size(); ++i)
    if (!costs[i].empty()) advice_.trials[close[i]].cost = quantile(costs[i], 0.5);
}

/// Asks a reference that chose nothing: it decides about those that were too close, if they are cheaper, and
/// who fails there is not advised.
void Search::check() {
  const int finest = ladder_.back().level, level = checking_level();
  if (level == 0) return;
  const std::optional<Rung> finer = climb_to(level);
  if (!finer) return;
  advice_.trials[finer->trial].verdict = "a reference, to check with";
  const double by = double(level) / finest;
  const Judge judge(ask_.of, extrapolated_ ? extrapolate(ladder_.back().trajectory, finer->trajectory, by)
                                           : finer->trajectory);
  const double unsure = judge.over_all(judge_->reference()) / (by * by - 1);
  const auto error_of = [&](const Trial& trial) {
    return judge.over_all(follow_scene(family_.scene(trial.candidate), looks_, [](const Followed&) {
                            return true;
                          }).trajectory);
  };
  const double before = best_cost();
  bool others = false;
  for (Trial& trial : advice_.trials)
    if (!stopped() && trial.verdict == too_close && trial.share == 1 && trial.cost < before &&
        error_of(trial) + unsure / 2 <= ask_.error) {
      trial.meets = others = true;
      trial.verdict = meets_it;
    }
  if (others) time_again();
  while (const auto best = cheapest()) {
    if (stopped()) return;
    Trial& trial = advice_.trials[*best];
    advice_.checked_error = error_of(trial);
    if (advice_.checked_error <= ask_.error) return;
    trial.meets = false;
    trial.verdict = fmt::format("error {} against a finer reference", percent(advice_.checked_error));
  }
}

/// Who comes nearest on either side, where error and budget cannot be met together.
void Search::explain_budget() {
  const Trial best = advice_.trials[*advice_.best];
  Candidate coarser = best.candidate;
  const double step_over_cell = coarser.dt / family_.cell_size(coarser.level);
  for (auto level = rungs.rbegin(); level != rungs.rend(); ++level) {
    if (*level >= best.candidate.level || stopped()) continue;
    coarser.level = *level;
    coarser.dt = step_between_looks(step_over_cell * family_.cell_size(*level), looks_);
    const std::size_t before = advice_.trials.size();
    run(coarser, {});
    if (advice_.trials.size() > before && advice_.trials.back().cost <= *ask_.budget) break;
  }
  advice_.best = cheapest();
  advice_.within_budget = best_cost() <= *ask_.budget;
  if (advice_.within_budget) return;
  const Trial* within = nullptr;
  for (const Trial& trial : advice_.trials)
    if (trial.share > 0.999 && trial.cost <= *ask_.budget && std::isfinite(trial.error) &&
        (within == nullptr || trial.error < within->error))
      within = &trial;
  advice_.explanation =
      fmt::format("no way that was tried meets {} within {:.3g} ms a frame; nearest: {}; {}",
                  percent(ask_.error), *ask_.budget * 1e3 / frames_per_second, tell(family_, best),
                  within == nullptr ? "nothing is that cheap" : "within it " + tell(family_, *within));
}

Advice Search::find() {
  const bool sure = climb();
  if (!sure && !advice_.stopped) {
    advice_.explanation = why_unsure();
  }
  if (judge_) judge_rungs();
  if (sure) {
    for (const Candidate& lattice : find_lattices()) try_methods(lattice);
    try_threads();
    if (!stopped()) time_again();
    if (!stopped() && cheapest()) check();
    if (!advice_.stopped) advice_.best = cheapest();
    if (!advice_.best && !advice_.stopped) advice_.explanation = nothing_meets;
  }
  if (advice_.best) {
    Trial& best = advice_.trials[*advice_.best];
    advice_.within_budget = !ask_.budget || best.cost <= *ask_.budget;
    if (!advice_.within_budget) explain_budget();
    advice_.trials[*advice_.best].verdict = advice_.within_budget ? "advised" : "the cheapest that meets it";
  }
  for (Trial& trial : advice_.trials)
    if (trial.verdict == meets_it) trial.verdict = "meets it and costs more";
  advice_.seconds = seconds();
  return std::move(advice_);
}

Advice Search::grid(int finest_level, int reference_level) {
  for (const int level : {reference_level / 2, reference_level * 3 / 4, reference_level}) {
    std::optional<Rung> reference = climb_to(level);
    if (!reference) {
      if (!advice_.stopped) advice_.explanation = no_reference;
      return std::move(advice_);
    }
    ladder_.push_back(std::move(*reference));
  }
  judge_by_ladder();
  check_scale();
  for (int level = 1; level <= finest_level && !stopped(); ++level) {
    const bool offered = std::find(rungs.begin(), rungs.end(), level) != rungs.end() ||
                         std::find(between_rungs.begin(), between_rungs.end(), level) != between_rungs.end();
    if (!offered) continue;
    for (const Candidate& filling : fillings(level))
      attempt(filling, [&] {
        for (const std::vector<Candidate>& chain : methods(filling))
          for (const Candidate& candidate : chain)
            if (!stopped())
              run(candidate,
                  {.error = 1, .cost = std::min(10 * best_cost(), 40 * accurate_cost(candidate.level))});
        return Outcome::wrong;
      });
  }
  try_threads();
  constexpr double misled = 2;  // by a single time
  if (!stopped()) time_again(misled);
  advice_.best = cheapest();
  if (!advice_.best && !advice_.stopped) advice_.explanation = why_grid_fails();
  advice_.within_budget = advice_.best && (!ask_.budget || best_cost() <= *ask_.budget);
  advice_.seconds = seconds();
  return std::move(advice_);
}

Advice advise(SceneFamily& family, const Ask& ask, Progress& progress) {
  return Search(family, ask, progress).find();
}

Advice try_all(SceneFamily& family, const Ask& ask, int finest_level, int reference_level,
               Progress& progress) {
  return Search(family, ask, progress).grid(finest_level, reference_level);
}

Table advice_table(const SceneFamily& family, const Advice& advice) {
  Table table({{"cell_size", "m"},
               {"face_share"},
               {"volume_force"},
               {"precision"},
               {"integrator"},
               {"linear_solver"},
               {"dt", "s"},
               {"tolerance"},
               {"threads"},
               {"error"},
               {"cost", "s/s"},
               {"share_run"},
               {"status"}});
  for (const Trial& trial : advice.trials) {
    const Candidate& c = trial.candidate;
    table.add({family.cell_size(c.level), family.is_calibrated() ? c.face_share : none,
               std::int64_t(c.volume_force && family.has_volume_force()),
               c.precision == Precision::single ? "single" : "double", c.integrator, c.linear_solver,
               c.dt > 0 ? c.dt : none, c.tolerance > 0 ? c.tolerance : none, std::int64_t(c.threads),
               trial.error, trial.cost, trial.share, trial.verdict});
  }
  return table;
}

}  // namespace mss::advise

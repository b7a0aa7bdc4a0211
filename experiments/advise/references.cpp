// What the search of `mss advise` judges by: references finer and finer, until one is sure enough.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/advise/search.hpp"
#include "integrators/stable_step.hpp"

namespace mss::advise {

namespace {

/// The method of references and of trials that are about lattices: explicit, of second order with damping.
constexpr const char* accurate_method = "damped_verlet";
constexpr double accurate_share = 0.5;  ///< of its safe step

/// A reference whose uncertainty is a larger share of the error asked does not do.
constexpr double sure_share = 0.5;

}  // namespace

std::vector<int> all_levels() {
  std::vector<int> levels(rungs.begin(), rungs.end());
  levels.insert(levels.end(), between_rungs.begin(), between_rungs.end());
  std::sort(levels.begin(), levels.end());
  return levels;
}

double safe_step(const std::string& method, const SpectralBound& bound) {
  return safe_share * guaranteed_step(find_integrator(method), bound);
}

std::string percent(double share) { return fmt::format("{:.3g} %", 100 * share); }

/// A lattice, computed as references are.
Candidate Search::accurate(Candidate lattice) const {
  const double most = accurate_share * safe_step(accurate_method, family_.bound(lattice));
  lattice.integrator = accurate_method;
  lattice.dt = step_between_looks(std::min(most, looks_.interval), looks_);
  return lattice;
}

/// All threads pay in large bodies only: the first looks say where.
int Search::quicker_threads(Candidate candidate) {
  constexpr std::size_t looks = 4;
  int quicker = 1;
  if (family_.asked().solve.threads != 0) return quicker;  // asked for
  double least = std::numeric_limits<double>::infinity();
  for (const int threads : {1, 0}) {
    candidate.threads = threads;
    const Followed run = follow_scene(awake(candidate), looks_, [&](const Followed& so_far) {
      return so_far.seconds.size() < looks && !stopped();
    });
    if (run.cost() >= least) continue;
    least = run.cost();
    quicker = threads;
  }
  return quicker;
}

/// The scene in which nothing falls asleep: what a reference computes.
Scene Search::awake(const Candidate& candidate) const {
  Scene scene = family_.scene(candidate);
  scene.solve.sleep = {};
  return scene;
}

/// Runs a reference; nothing if that is impossible or fails, which the trial says.
std::optional<Search::Rung> Search::climb_to(int level) {
  std::optional<Rung> rung;
  progress_.report(0, fmt::format("reference, cells of {:.4g} m", family_.cell_size(level)));
  attempt({.level = level}, [&] {
    Trial trial;
    trial.candidate = accurate({.level = level});
    trial.candidate.threads = quicker_threads(trial.candidate);
    Followed run = follow_scene(awake(trial.candidate), looks_, [&](const Followed&) { return !stopped(); });
    trial.cost = run.cost();
    trial.share = run.simulated / family_.asked().solve.duration;
    trial.verdict = run.ended_early            ? "interrupted"
                    : run.status == Status::ok ? "a reference"
                                               : std::string(to_string(run.status));
    advice_.trials.push_back(trial);
    if (!run.ended_early && run.status == Status::ok)
      rung = Rung{level, std::move(run.trajectory), run.total_seconds(), advice_.trials.size() - 1};
    return Outcome::wrong;
  });
  return rung;
}

/// What is taken for true: the finest rung, or what the last two tend to, whichever has changed less since
/// the rung before.
void Search::judge_by_ladder() {
  const std::size_t last = ladder_.size() - 1;
  const Rung &fine = ladder_[last], &coarse = ladder_[last - 1];
  const double by = double(fine.level) / coarse.level, gain = 1 / (by * by - 1);
  advice_.finest_level = fine.level;
  judge_.emplace(ask_.of, fine.trajectory);
  extrapolated_ = false;
  if (last < 2) {
    advice_.uncertainty = judge_->over_all(coarse.trajectory) / (by - 1);
    return;
  }
  const Rung& coarser = ladder_[last - 2];
  const double by_before = double(coarse.level) / coarser.level;
  const double change = judge_->over_all(coarse.trajectory),
               before = Judge(ask_.of, coarse.trajectory).over_all(coarser.trajectory);
  double order = 1;
  if (change > 0 && before > 0)
    order = std::clamp(std::log(before / change) / std::log(std::sqrt(by * by_before)), 0.5, 2.0);
  advice_.uncertainty = change / (std::pow(by, order) - 1);
  Judge limit(ask_.of, extrapolate(coarse.trajectory, fine.trajectory, by));
  const double sure = gain * limit.over_all(extrapolate(coarser.trajectory, coarse.trajectory, by_before));
  if (!(sure < advice_.uncertainty)) return;
  advice_.uncertainty = sure;
  judge_.emplace(std::move(limit));
  extrapolated_ = true;
}

/// A reference that does not move has no errors to compare with.
void Search::check_scale() const {
  if (ask_.of == ErrorOf::frequency && !std::isfinite(judge_->scale()))
    throw InputError(
        fmt::format("{}: does not swing often enough in solve.duration to have a frequency; ask for "
                    "--of displacement, or give it more time",
                    family_.asked().file.string()));
  if (judge_->scale() == 0)
    throw InputError(
        fmt::format("{}: nothing moves, so that every way to compute it is without error; give it "
                    "gravity, a load or a start",
                    family_.asked().file.string()));
}

/// Finer and finer references until one is sure enough: to decide among lattices, as long as that leaves
/// patience for the one that checks; to judge at all, as long as there is patience. False if none is.
bool Search::climb() {
  constexpr double left_for_check = 5;
  constexpr double guessed = 4;  // the coarsest take longer than their cells would
  for (const int level : rungs) {
    if (stopped()) return false;
    const double predicted = ladder_.empty() ? 0 : seconds_at(level);
    if (predicted > (ladder_.size() < 2 ? guessed : 1) * ask_.patience) break;
    if (ladder_.size() >= 2 && is_sure() && left_for_check * predicted > ask_.patience) break;
    std::optional<Rung> rung = climb_to(level);
    if (!rung) continue;
    ladder_.push_back(std::move(*rung));
    if (ladder_.size() < 2) continue;
    judge_by_ladder();
    check_scale();
    if (decides()) return true;
  }
  return is_sure();
}

/// What a finer rung will take [s]: cells go with the cube of the level, steps with the level.
double Search::seconds_at(int level) const {
  return ladder_.back().seconds * std::pow(double(level) / ladder_.back().level, 4);
}

/// Of the rung after the finest; 0 if there is none.
int Search::next_level() const {
  const int finest = ladder_.back().level;
  const auto next = std::find_if(rungs.begin(), rungs.end(), [&](int level) { return level > finest; });
  return next == rungs.end() ? 0 : *next;
}

/// The level of the reference that checks: beyond the finest, and up to the next rung as far as that takes no
/// longer than the search did. 0 if any would take too long.
int Search::checking_level() const {
  int checking = 0;
  for (const int level : all_levels()) {
    if (level <= ladder_.back().level) continue;
    if (level > next_level() || seconds_at(level) > ask_.patience) break;
    if (checking == 0 || seconds_at(level) <= seconds()) checking = level;
  }
  return checking;
}

/// Since the search began [s].
double Search::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

bool Search::is_sure() const { return ladder_.size() >= 3 && advice_.uncertainty <= sure_share * ask_.error; }

/// Whether it is sure which rungs meet the error, or surer than a search can make use of.
bool Search::decides() const {
  constexpr double of_use = 0.1;
  if (is_sure() && advice_.uncertainty <= of_use * ask_.error) return true;
  return is_sure() && std::none_of(ladder_.begin(), ladder_.end(), [&](const Rung& rung) {
           return is_undecided(judge_->over_all(rung.trajectory));
         });
}

/// What references are made of are candidates too.
void Search::judge_rungs() {
  for (const Rung& rung : ladder_) {
    Trial& trial = advice_.trials[rung.trial];
    if (&rung == &ladder_.back() && !extrapolated_) {
      trial.verdict = "the reference";
      continue;
    }
    trial.error = judge_->over_all(rung.trajectory);
    trial.meets = meets(trial.error);
    trial.verdict = trial.meets ? meets_it : too_wrong;
  }
}

std::string Search::why_unsure() const {
  if (ladder_.empty()) return no_reference;
  if (ladder_.size() < 3 && next_level() > 0 && seconds_at(next_level()) > ask_.patience)
    return fmt::format(
        "{} nothing about how errors fall, and the next would take some {:.2g} s: give it more than {:.3g} s "
        "of --patience",
        ladder_.size() == 1 ? "one reference says" : "two references say", seconds_at(next_level()),
        ask_.patience);
  if (ladder_.size() < 2) return no_reference;
  return fmt::format("the finest reference that takes up to {:.3g} s, {}, or give it more --patience",
                     ask_.patience, how_unsure());
}

std::string Search::how_unsure() const {
  return fmt::format("with cells of {:.4g} m, is itself unsure by {}: ask for an error of at least {}",
                     family_.cell_size(advice_.finest_level), percent(advice_.uncertainty),
                     percent(advice_.uncertainty / sure_share));
}

/// References of a grid are as fine as --grid has them, whatever the patience.
std::string Search::why_grid_fails() const {
  if (is_sure()) return "nothing that was tried meets the error; a larger --grid tries finer cells";
  return fmt::format("the finest reference, {}, or give a larger --grid", how_unsure());
}

}  // namespace mss::advise

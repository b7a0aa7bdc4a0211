#include "experiments/advise/reference_levels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "integrators/analysis/stable_step.hpp"

namespace mss::advise {

namespace {

/// The method of references and of trials that are about lattices: explicit, of second order with damping.
constexpr const char* accurate_method = "damped_verlet";
constexpr double accurate_share = 0.5;  ///< of its safe step

/// Largest uncertainty of a reference, as a share of the requested error.
constexpr double allowed_share = 0.5;

constexpr const char* no_reference = "no reference could be computed: see the table";

}  // namespace

std::vector<int> all_levels() {
  std::vector<int> levels(reference_levels.begin(), reference_levels.end());
  levels.insert(levels.end(), levels_between.begin(), levels_between.end());
  std::sort(levels.begin(), levels.end());
  return levels;
}

double safe_step(const std::string& method, const SpectralBound& bound) {
  return safe_share * guaranteed_step(find_integrator(method), bound);
}

std::string percent(double share) { return fmt::format("{:.3g} %", 100 * share); }

Candidate ReferenceLevels::accurate(Candidate lattice) const {
  if (!find_integrator(lattice.integrator).moves_particles()) return lattice;  // its model has one method
  const double most = accurate_share * safe_step(accurate_method, search_.family.bound(lattice));
  lattice.integrator = accurate_method;
  lattice.precision = Precision::dbl;
  lattice.dt = step_between_samples(most, search_.sampling);
  return lattice;
}

/// All threads pay in large bodies only: the first samples show where.
int ReferenceLevels::quicker_threads(Candidate candidate) {
  constexpr std::size_t samples = 4;
  const int given = search_.family.given().solve.threads;
  if (given != 0) return given;
  int quicker = 1;
  double least = std::numeric_limits<double>::infinity();
  for (const int threads : {1, 0}) {
    candidate.threads = threads;
    const SampledRun run = search_.sample(without_sleep(candidate), [&](const SampledRun& so_far) {
      return so_far.seconds.size() < samples && !search_.stopped();
    });
    if (run.cost() >= least) continue;
    least = run.cost();
    quicker = threads;
  }
  return quicker;
}

Scene ReferenceLevels::without_sleep(const Candidate& candidate) const {
  Scene scene = search_.family.scene(candidate);
  scene.solve.sleep = {};
  return scene;
}

std::optional<ReferenceLevels::Reference> ReferenceLevels::compute(int level) {
  std::optional<Reference> reference;
  search_.progress.report(0, fmt::format("reference, cells of {:.4g} m", search_.family.cell_size(level)));
  search_.attempt(search_.family.candidate(level), [&] {
    Trial trial{.candidate = accurate(search_.family.candidate(level)), .verdict = Verdict::reference};
    trial.candidate.threads = quicker_threads(trial.candidate);
    SampledRun run =
        search_.sample(without_sleep(trial.candidate), [&](const SampledRun&) { return !search_.stopped(); });
    trial.cost = run.cost();
    trial.share = run.simulated / search_.sampling.duration();
    trial.min_jacobian = run.trajectory.min_jacobian;
    trial.max_stretch = run.trajectory.max_stretch;
    trial.status = run.status;
    if (run.status != Status::ok) trial.verdict = Verdict::failed;
    if (run.ended_early) trial.verdict = Verdict::interrupted;
    search_.trials.push_back(trial);
    if (trial.verdict == Verdict::reference)
      reference = Reference{level, std::move(run.trajectory), run.work, search_.trials.size() - 1};
  });
  return reference;
}

bool ReferenceLevels::compute(const std::vector<int>& levels) {
  for (const int level : levels) {
    std::optional<Reference> reference = compute(level);
    if (!reference) return false;
    add(std::move(*reference));
  }
  return true;
}

/// The reference of the estimator is the finest one, or the extrapolation of the last two, whichever has
/// changed less since the level before.
void ReferenceLevels::estimate() {
  const std::size_t last = all_.size() - 1;
  const ErrorOf of = search_.request.of;
  const Reference &fine = all_[last], &coarse = all_[last - 1];
  const double by = double(fine.level) / coarse.level, gain = 1 / (by * by - 1);
  estimator_.emplace(of, fine.trajectory);
  extrapolated_ = false;
  if (last < 2) {
    uncertainty_ = estimator_->error_of(coarse.trajectory) / (by - 1);
    return;
  }
  const Reference& coarser = all_[last - 2];
  const double by_before = double(coarse.level) / coarser.level;
  const double change = estimator_->error_of(coarse.trajectory),
               before = ErrorEstimator(of, coarse.trajectory).error_of(coarser.trajectory);
  double order = 1;
  if (change > 0 && before > 0)
    order = std::clamp(std::log(before / change) / std::log(std::sqrt(by * by_before)), 0.5, 2.0);
  uncertainty_ = change / (std::pow(by, order) - 1);
  ErrorEstimator limit(of, extrapolate(coarse.trajectory, fine.trajectory, by));
  const double of_limit =
      gain * limit.error_of(extrapolate(coarser.trajectory, coarse.trajectory, by_before));
  if (!(of_limit < uncertainty_)) return;
  uncertainty_ = of_limit;
  estimator_.emplace(std::move(limit));
  extrapolated_ = true;
}

/// Errors relative to a motion that is zero mean nothing.
void ReferenceLevels::check_scale() const {
  const std::string file = search_.family.given().file.string();
  if (search_.request.of == ErrorOf::frequency && !std::isfinite(estimator_->scale()))
    throw InputError(
        fmt::format("{}: does not oscillate often enough in solve.duration to have a frequency; give --of "
                    "displacement, or a longer duration",
                    file));
  if (estimator_->scale() == 0)
    throw InputError(
        fmt::format("{}: nothing moves, so every way to compute it is without error; give it "
                    "gravity, a load or a start",
                    file));
  // The fit of a rigid motion leaves rounding.
  if (search_.request.of == ErrorOf::deformation && estimator_->scale() < 1e-9 * search_.family.cell_size(1))
    throw InputError(
        fmt::format("{}: the body does not deform, so every way to compute it is without error of that; give "
                    "--of displacement, or a scene that deforms it",
                    file));
}

bool ReferenceLevels::refine() {
  constexpr double left_for_check = 5;
  constexpr double guessed = 4;  // the coarsest take longer than in proportion to their cells
  const double patience = search_.request.patience;
  if (decides()) return true;
  for (const int level : reference_levels) {
    if (search_.stopped()) return false;
    if (!all_.empty() && level <= finest().level) continue;
    const double predicted = all_.empty() ? 0 : seconds_at(level);
    if (predicted > (all_.size() < 2 ? guessed : 1) * patience) break;
    if (all_.size() >= 2 && is_accurate_enough() && left_for_check * predicted > patience) break;
    std::optional<Reference> reference = compute(level);
    if (!reference) continue;
    add(std::move(*reference));
    if (decides()) return true;
  }
  return is_accurate_enough();
}

void ReferenceLevels::add(Reference reference) {
  all_.push_back(std::move(reference));
  if (all_.size() < 2) return;
  estimate();
  check_scale();
}

void ReferenceLevels::refine_with_patience() {
  for (const int level : reference_levels) {
    if (search_.stopped()) return;
    if (!all_.empty() && seconds_at(level) > search_.request.patience) break;
    std::optional<Reference> reference = compute(level);
    if (reference) add(std::move(*reference));
  }
}

double ReferenceLevels::seconds_at(int level) const {
  return finest().seconds * std::pow(double(level) / finest().level, 4);
}

double ReferenceLevels::cost_at(int level) const {
  return search_.trials[finest().trial].cost * std::pow(double(level) / finest().level, 4);
}

/// The level after the finest; 0 if there is none.
int ReferenceLevels::next_level() const {
  const auto next = std::find_if(reference_levels.begin(), reference_levels.end(),
                                 [&](int level) { return level > finest().level; });
  return next == reference_levels.end() ? 0 : *next;
}

int ReferenceLevels::checking_level() const {
  int checking = 0;
  for (const int level : all_levels()) {
    if (level <= finest().level) continue;
    if (level > next_level() || seconds_at(level) > search_.request.patience) break;
    if (checking == 0 || seconds_at(level) <= search_.charged) checking = level;
  }
  return checking;
}

double ReferenceLevels::allowed_uncertainty() const { return allowed_share * search_.request.error; }

bool ReferenceLevels::is_accurate_enough() const {
  return all_.size() >= 3 && uncertainty_ <= allowed_uncertainty();
}

bool ReferenceLevels::meets(double error) const {
  return error + (!all_.empty() && checking_level() > 0 ? 0.5 : 1) * uncertainty_ <= search_.request.error;
}

/// Whether it is certain which references meet the error, or a search would gain nothing from more accuracy.
bool ReferenceLevels::decides() const {
  constexpr double of_use = 0.1;
  if (!is_accurate_enough()) return false;
  return uncertainty_ <= of_use * search_.request.error ||
         std::none_of(all_.begin(), all_.end(), [&](const Reference& reference) {
           return is_undecided(estimator_->error_of(reference.trajectory));
         });
}

void ReferenceLevels::conclude() {
  for (const Reference& reference : all_) {
    Trial& trial = search_.trials[reference.trial];
    if (&reference == &finest() && !extrapolated_) {
      trial.verdict = Verdict::finest_reference;
      continue;
    }
    trial.error = estimator_->error_of(reference.trajectory);
    const bool unfolded = trial.min_jacobian > 0 || folds();
    trial.meets = unfolded && meets(trial.error);
    trial.verdict = trial.meets ? Verdict::meets : unfolded ? Verdict::inaccurate : Verdict::folds;
  }
}

void ReferenceLevels::conclude_without_request() {
  for (const Reference& reference : all_)
    search_.trials[reference.trial].error = estimator_->error_of(reference.trajectory);
  search_.trials[finest().trial].verdict = Verdict::finest_reference;
}

std::string ReferenceLevels::why_inaccurate() const {
  const double patience = search_.request.patience;
  if (all_.empty()) return no_reference;
  if (all_.size() < 3 && next_level() > 0 && seconds_at(next_level()) > patience)
    return fmt::format(
        "{} nothing about how errors decrease, and the next would take some {:.2g} s: give more than {:.3g} "
        "s of --patience",
        all_.size() == 1 ? "one reference shows" : "two references show", seconds_at(next_level()), patience);
  if (all_.size() < 2) return no_reference;
  return fmt::format("no reference within --patience {:.3g} is accurate enough: the finest, {}", patience,
                     advice_for_accuracy("give more --patience"));
}

std::string ReferenceLevels::advice_for_accuracy(const std::string& remedy) const {
  const double least = uncertainty_ / allowed_share;
  const std::string less =
      least < 1 ? fmt::format("request an error of at least {}, or ", percent(least)) : "";
  return fmt::format("with cells of {:.4g} m, is itself uncertain by {}; {}{}",
                     search_.family.cell_size(finest().level), percent(uncertainty_), less, remedy);
}

/// References of a grid are of the levels that --grid gives, whatever --patience is.
std::string ReferenceLevels::why_grid_fails() const {
  if (all_.size() < 3) return no_reference;
  if (is_accurate_enough())
    return "nothing that was tried meets the error; a larger --grid tries finer cells";
  return fmt::format("the finest reference, {}", advice_for_accuracy("give a larger --grid"));
}

}  // namespace mss::advise

#pragma once

#include <array>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.hpp"
#include "experiments/advise/advise.hpp"
#include "experiments/harness/measure.hpp"

namespace mss::advise {

/// Levels of references: parts that an edge of the coarsest cells is split into.
inline constexpr std::array<int, 13> reference_levels{1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96};
/// Levels between those, of candidates and of references that check.
inline constexpr std::array<int, 7> levels_between{5, 7, 10, 14, 20, 28, 40};
/// Both, ascending.
std::vector<int> all_levels();

/// The longest step of a method that is certain to be stable on such a lattice [s], times the safety factor
/// of dt = "safe".
double safe_step(const std::string& method, const SpectralBound& bound);
/// 0.0123 as 1.23 %.
std::string percent(double share);

/// What references and search share: what is requested, and what was tried so far.
struct SearchState {
  SearchState(SceneFamily& family_, const AdviseRequest& request_, Progress& progress_)
      : family(family_),
        request(request_),
        progress(progress_),
        sampling(sampling_of(family_.given(), request_.of)) {}

  SceneFamily& family;
  const AdviseRequest& request;
  Progress& progress;
  Sampling sampling;
  Stopwatch watch{};
  double charged = 0;  ///< for all samples so far, by_work() [s]
  std::vector<Trial> trials{};
  bool was_stopped = false;

  /// Whether the user has stopped it.
  bool stopped() { return was_stopped = was_stopped || progress.stopped(); }

  /// Runs a scene as sample_scene() does.
  SampledRun sample(const Scene& scene, const GoOn& go_on,
                    double most_seconds = std::numeric_limits<double>::infinity()) {
    SampledRun run = sample_scene(scene, sampling, go_on, request.charge, most_seconds);
    charged += run.work;
    return run;
  }

  /// Calls act(). Where a scene cannot be computed like that, or there is not enough memory, adds a trial
  /// that records it, and returns false.
  template <class Act>
  bool attempt(const Candidate& candidate, Act&& act) {
    try {
      act();
      return true;
    } catch (const InputError& error) {
      const std::string problem = error.what(), file = family.given().file.string() + ": ";
      trials.push_back({.candidate = candidate, .verdict = Verdict::impossible});
      trials.back().problem = problem.substr(problem.starts_with(file) ? file.size() : 0);
    } catch (const std::bad_alloc&) {
      trials.push_back({.candidate = candidate, .verdict = Verdict::out_of_memory});
    }
    return false;
  }
};

/// References of a scene at successive levels, and the error estimates that follow from them.
class ReferenceLevels {
 public:
  struct Reference {
    int level;
    Trajectory trajectory;
    double seconds;  ///< by_work()
    std::size_t trial;
  };

  explicit ReferenceLevels(SearchState& search) : search_(search) {}

  /// Computes finer and finer references until one is accurate enough: to decide among lattices, as long as
  /// that leaves time for the one that checks; to estimate errors at all, as long as there is time. False if
  /// none is. Goes on from where it was, and from what was added. Throws InputError for a scene whose
  /// reference has no motion to compare with.
  bool refine();
  /// Computes finer and finer references as long as one takes no more than `patience`, and estimates their
  /// errors where there are two.
  void refine_with_patience();
  /// Computes references of these levels. False if one cannot be computed.
  bool compute(const std::vector<int>& levels);
  /// A finer one.
  void add(Reference reference);
  /// One reference more, which is not added to these; nothing if it is impossible or fails, as its trial
  /// records.
  std::optional<Reference> compute(int level);

  bool empty() const { return all_.empty(); }
  const std::vector<Reference>& all() const { return all_; }
  const Reference& finest() const { return all_.back(); }
  /// Nothing until there are two references.
  const std::optional<ErrorEstimator>& estimator() const { return estimator_; }
  /// Whether the estimator's reference is extrapolated from the finest two.
  bool extrapolated() const { return extrapolated_; }
  /// Of errors, from what the reference still changes by.
  double uncertainty() const { return uncertainty_; }
  /// Whether cells of the finest are inverted at some time: then nothing keeps candidates from folding.
  bool folds() const { return finest().trajectory.min_jacobian <= 0; }
  /// How large it may be.
  double allowed_uncertainty() const;
  /// Whether the uncertainty is small enough to advise at all.
  bool is_accurate_enough() const;

  /// Whether an error, uncertain as it is, is as small as requested. Uncertainties are rather too large: half
  /// of one is added where a finer reference will check.
  bool meets(double error) const;
  bool is_undecided(double error) const { return std::abs(error - search_.request.error) < uncertainty_; }

  /// Verdicts about the references themselves, which are candidates too.
  void conclude();

  /// The same where no error is required.
  void conclude_without_request();

  /// A lattice, computed with the method and step of references.
  Candidate accurate(Candidate lattice) const;
  /// Work of a reference of a level, by_work() [s]: cells go with the cube of the level, steps with the
  /// level.
  double seconds_at(int level) const;
  /// What it costs by the same rule, as candidates do, per simulated second.
  double cost_at(int level) const;
  /// The level of the reference that checks the advice: beyond the finest, up to the next level as far as
  /// that takes no more than the search did. 0 if any would take too long.
  int checking_level() const;

  /// Why refine() returned false.
  std::string why_inaccurate() const;
  /// Why no candidate of a grid meets the error.
  std::string why_grid_fails() const;

 private:
  Scene without_sleep(const Candidate& candidate) const;
  int quicker_threads(Candidate candidate);
  void estimate();
  bool decides() const;
  int next_level() const;
  void check_scale() const;
  std::string advice_for_accuracy(const std::string& remedy) const;

  SearchState& search_;
  std::vector<Reference> all_;
  std::optional<ErrorEstimator> estimator_;
  bool extrapolated_ = false;
  double uncertainty_ = 0;
};

}  // namespace mss::advise

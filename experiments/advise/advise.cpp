// What is asked of the advisor and its verdicts in words; search.cpp is how it finds an answer,
// search_check.cpp how it doubts it.
#include "experiments/advise/advise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/advise/frame_search.hpp"
#include "experiments/advise/search.hpp"

namespace mss::advise {

namespace {

std::string times_the_best(double cost, double best) {
  if (std::isfinite(best)) return fmt::format("{:.2g} times as long as the best before", cost / best);
  return fmt::format("{:.2g} s a second, and nothing has met the error yet", cost);
}

}  // namespace

double judged_error(const Trial& trial) {
  return std::isnan(trial.error_at_half_step) ? trial.error : std::max(trial.error, trial.error_at_half_step);
}

ErrorOf default_error_of(const Scene& scene) {
  return scene.environment.holds.empty() ? ErrorOf::deformation : ErrorOf::displacement;
}

std::string to_string(const Trial& trial) {
  switch (trial.verdict) {
    case Verdict::reference:
      return "a reference";
    case Verdict::finest_reference:
      return "the reference";
    case Verdict::checking_reference:
      return "a reference, to check with";
    case Verdict::meets:
      return "meets the error";
    case Verdict::meets_but_costlier:
      return "meets the error and costs more";
    case Verdict::ties:
      return "meets the error and costs as much, within the noise";
    case Verdict::advised:
      return "advised";
    case Verdict::cheapest:
      return "the cheapest that meets the error";
    case Verdict::inaccurate:
      return "error above the requested one";
    case Verdict::folds:
      return fmt::format("{}: min_jacobian {:.3g}, and the reference does not",
                         trial.min_jacobian > 0 ? "nearly folds" : "folds", trial.min_jacobian);
    case Verdict::undecided:
      return "too close to the requested error to decide";
    case Verdict::fluke:
      return std::isfinite(trial.error_at_half_step)
                 ? "a fluke: at half the step the error is " + percent(trial.error_at_half_step)
                 : "a fluke: at half the step it folds or fails";
    case Verdict::fails_check:
      return "error " + percent(trial.checked_error) + " against a finer reference";
    case Verdict::refuted:
      return "judged by references that a finer one refuted";
    case Verdict::costly:
      return "would take " + times_the_best(trial.estimated_cost, trial.best_before);
    case Verdict::too_costly_to_run:
      return "would take at least " + times_the_best(trial.estimated_cost, trial.best_before);
    case Verdict::failed:
      return std::string(to_string(trial.status));
    case Verdict::interrupted:
      return "interrupted";
    case Verdict::fits:
      return "fits the budget and errs more, or costs more";
    case Verdict::over_budget:
      return "takes longer than the budget";
    case Verdict::unclean:
      return "as mss run has it: " + trial.problem;
    case Verdict::impossible:
      return "impossible: " + trial.problem;
    case Verdict::out_of_memory:
      return "needs more memory than there is";
  }
  return {};
}

Advice advise(SceneFamily& family, const AdviseRequest& request, Progress& progress) {
  return Search(family, request, progress).find();
}

Advice advise_for_frames(SceneFamily& family, const AdviseRequest& request, Progress& progress) {
  return FrameSearch(family, request, progress).find();
}

Advice try_all(SceneFamily& family, const AdviseRequest& request, int finest_level, int reference_level,
               bool pruned, Progress& progress) {
  return Search(family, request, progress).grid(finest_level, reference_level, pruned);
}

}  // namespace mss::advise

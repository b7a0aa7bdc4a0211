#include "experiments/simulation/remarks.hpp"

#include <fmt/format.h>

#include <cmath>

#include "experiments/simulation/scene_check.hpp"

namespace mss {

namespace {

std::string on_step(const Scene& scene, const SimulationResult& result) {
  if (result.stable_dt == 0)
    return fmt::format("no step of {} is sure to be stable here; choose another method",
                       scene.solve.integrator);
  if (!std::isfinite(result.stable_dt))
    return "numbers grew beyond what can be computed with; a shorter solve.dt may help";
  const std::string about =
      fmt::format("the {:.4g} s up to which small motions are sure to be stable", result.stable_dt);
  if (result.dt > result.stable_dt)
    return fmt::format("the step of {:.4g} s is longer than {}; give solve.dt = \"safe\", or less than that",
                       result.dt, about);
  return fmt::format(
      "the step of {:.4g} s is below {}, but the body deformed beyond small motions: a shorter "
      "solve.dt may help, or the body is too soft for its loads",
      result.dt, about);
}

}  // namespace

std::vector<std::string> remarks_on(const Scene& scene, const SimulationResult& result) {
  std::vector<std::string> remarks;
  const bool fixed = find_integrator(scene.solve.integrator).stepping == Stepping::fixed;
  if (result.status == Status::non_finite && fixed) remarks.push_back(on_step(scene, result));
  if (result.status == Status::newton_stalled && is_static(scene) && scene.environment.holds.empty())
    remarks.emplace_back("nothing holds the body in place; where a scene has no [[hold]], few are at rest");
  if (result.status == Status::ok && !result.series.empty() && result.series.back().min_jacobian <= 0)
    remarks.push_back(fmt::format(
        "the body ends folded: the smallest signed volume at a cell's corner is {:.3g} of the one "
        "at rest (min_jacobian), and the largest stretch {:.3g}",
        result.series.back().min_jacobian, result.series.back().max_stretch));
  return remarks;
}

}  // namespace mss

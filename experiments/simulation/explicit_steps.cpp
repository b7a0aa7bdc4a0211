#include "experiments/simulation/explicit_steps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/harness/measure.hpp"

namespace mss {

namespace {

/// Force evaluations over the duration, from those of the first step.
double evaluations(BodySystem<double>& system, State<double> state, const ExplicitSteps& choice) {
  Work work;
  choice.info->make<double>({.dt = choice.dt})->advance(system, state, state.t + choice.dt, work);
  return double(choice.steps * work.force_evaluations);
}

}  // namespace

ExplicitSteps explicit_steps(const IntegratorInfo& info, const SpectralBound& bound, double duration,
                             double share) {
  const double steps = std::ceil(duration / (share * safe_share * stable_step(info, bound)));
  return {&info, long(steps), duration / steps};
}

std::vector<ExplicitSteps> cheapest_explicit_steps(BodySystem<double>& system, const State<double>& start,
                                                   double duration) {
  const SpectralBound bound = system.spectral_bound();
  std::vector<std::pair<double, ExplicitSteps>> all;
  double fewest = std::numeric_limits<double>::infinity();
  for (const IntegratorInfo& info : integrators()) {
    if (!info.limit || info.stepping != Stepping::fixed || !(guaranteed_step(info, bound) > 0)) continue;
    const ExplicitSteps choice = explicit_steps(info, bound, duration);
    all.emplace_back(evaluations(system, start, choice), choice);
    fewest = std::min(fewest, all.back().first);
  }
  std::vector<ExplicitSteps> cheapest;
  for (const auto& [count, choice] : all)
    if (count <= 1.2 * fewest) cheapest.push_back(choice);
  return cheapest;
}

double explicit_step_seconds(BodySystem<double>& system) {
  constexpr double enough = 5e-3;
  constexpr int repetitions = 5;
  constexpr long most_steps = 100;  // from the start on: a soft body that falls further may become unstable
  const IntegratorInfo& info = find_integrator("semi_implicit_euler");
  const double dt = safe_share * stable_step(info, system.spectral_bound());
  const auto method = info.make<double>({.dt = dt});
  const State<double> start = system.undeformed_state();
  Work work;
  const auto seconds_for = [&](long steps) {
    return seconds_of([&] {
      for (long done = 0; done < steps; done += most_steps) {
        State<double> state = start;
        method->reset();
        method->advance(system, state, double(std::min(most_steps, steps - done)) * dt, work);
      }
    });
  };
  const long steps = sample_length(enough, seconds_for).steps;
  std::vector<double> seconds;
  seconds.reserve(std::size_t(repetitions));
  for (int i = 0; i < repetitions; ++i) seconds.push_back(seconds_for(steps) / double(steps));
  return quartiles(seconds).median;
}

}  // namespace mss

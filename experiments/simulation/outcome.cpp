#include "experiments/simulation/outcome.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.hpp"

namespace mss {

namespace {

/// In the enumeration's order.
struct OutcomeText {
  Outcome outcome;
  std::string_view name, label;
};
constexpr std::array<OutcomeText, 8> texts{{{Outcome::stable, "stable", "stable"},
                                            {Outcome::loses_energy, "loses_energy", "loses energy"},
                                            {Outcome::gains_energy, "gains_energy", "gains energy"},
                                            {Outcome::folds, "folds", "folds"},
                                            {Outcome::blows_up, "blows_up", "blows up"},
                                            {Outcome::stalls, "stalls", "solver stalls"},
                                            {Outcome::too_many_steps, "too_many_steps", "too many steps"},
                                            {Outcome::refused, "refused", "refused by the method"}}};

}  // namespace

std::string_view to_string(Outcome outcome) { return texts.at(std::size_t(outcome)).name; }

Outcome read_outcome(std::string_view text) {
  for (const OutcomeText& known : texts)
    if (known.name == text) return known.outcome;
  throw InputError(fmt::format("'{}' is not the outcome of a run", text));
}

std::vector<std::string> outcome_labels() {
  std::vector<std::string> labels;
  labels.reserve(std::size(texts));
  for (const OutcomeText& known : texts) labels.emplace_back(known.label);
  return labels;
}

Outcome outcome_of(Status status) {
  switch (status) {
    case Status::ok:
      return Outcome::stable;
    case Status::non_finite:
      return Outcome::blows_up;
    case Status::step_limit:
      return Outcome::too_many_steps;
    default:
      return Outcome::stalls;
  }
}

double velocity_lag(const IntegratorInfo& method, double dt) {
  return method.symplectic && method.order_undamped == 1 ? dt / 2 : 0;
}

Measures measure_in_time(SolidSystem<double>& system, const State<double>& state, double velocity_lag) {
  if (velocity_lag == 0) return measure(system, state);
  State<double> in_time = state;
  system.acceleration(state.t, state.x, state.v, in_time.v);
  in_time.v.array() = state.v.array() + velocity_lag * in_time.v.array();
  return measure(system, in_time);
}

SampledRun::SampledRun(SolidSystem<double>& system, State<double>& state, double velocity_lag)
    : system_(system), state_(state), velocity_lag_(velocity_lag) {
  extremes_.initial_energy = extremes_.max_energy = measure(system, state).mechanical();
}

Outcome SampledRun::run(long samples, const std::function<Status(long)>& advance,
                        const std::function<void(const Measures&)>& sample) {
  constexpr double blown_up = 10;  // times the initial energy
  double sum = 0;
  for (long i = 1; i <= samples; ++i) {
    Status status = Status::ok;
    try {
      status = advance(i);
    } catch (const InputError&) {
      return Outcome::refused;
    }
    if (status != Status::ok) return outcome_of(status);
    const Measures m = measure_in_time(system_, state_, velocity_lag_);
    if (!(m.mechanical() <= blown_up * extremes_.initial_energy)) return Outcome::blows_up;
    sum += m.mechanical();
    extremes_.max_energy = std::max(extremes_.max_energy, m.mechanical());
    extremes_.final_jacobian = m.min_jacobian;
    extremes_.min_jacobian = std::fmin(extremes_.min_jacobian, m.min_jacobian);
    if (sample) sample(m);
  }
  mean_energy_ = sum / double(samples);
  return extremes_.max_energy > (1 + tolerated_growth) * extremes_.initial_energy ? Outcome::gains_energy
                                                                                  : Outcome::stable;
}

}  // namespace mss

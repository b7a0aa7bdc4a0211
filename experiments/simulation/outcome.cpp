#include "experiments/simulation/outcome.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"

namespace mss {

namespace {

/// In the enumeration's order.
struct OutcomeText {
  Outcome outcome;
  std::string_view name, label;
};
constexpr std::array<OutcomeText, 7> texts{{{Outcome::stable, "stable", "stable"},
                                            {Outcome::loses_energy, "loses_energy", "loses energy"},
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

Outcome run_sampled(BodySystem<double>& system, State<double>& state, long samples,
                    const std::function<Status(long)>& advance, RunExtremes& extremes,
                    const std::function<void(const Measures&)>& sample) {
  constexpr double blown_up = 10;  // times the initial energy
  extremes.initial_energy = extremes.max_energy = measure(system, state).mechanical();
  for (long i = 1; i <= samples; ++i) {
    Status status = Status::ok;
    try {
      status = advance(i);
    } catch (const InputError&) {
      return Outcome::refused;
    }
    if (status != Status::ok) return outcome_of(status);
    const Measures m = measure(system, state);
    if (!(m.mechanical() <= blown_up * extremes.initial_energy)) return Outcome::blows_up;
    extremes.max_energy = std::max(extremes.max_energy, m.mechanical());
    extremes.final_jacobian = m.min_jacobian;
    extremes.min_jacobian = std::fmin(extremes.min_jacobian, m.min_jacobian);
    if (sample) sample(m);
  }
  return Outcome::stable;
}

}  // namespace mss

#include "experiments/simulation/fate.hpp"

#include <algorithm>
#include <cmath>

namespace mss {

std::string_view to_string(Fate fate) {
  switch (fate) {
    case Fate::holds:
      return "holds";
    case Fate::loses_energy:
      return "loses_energy";
    case Fate::folds:
      return "folds";
    case Fate::blows_up:
      return "blows_up";
    case Fate::stalls:
      return "stalls";
    case Fate::too_many_steps:
      return "too_many_steps";
  }
  return "unknown";
}

std::vector<std::string> fate_names() {
  return {"holds", "loses energy", "folds", "blows up", "stalls", "too many steps"};
}

Fate fate_of(Status status) {
  switch (status) {
    case Status::ok:
      return Fate::holds;
    case Status::non_finite:
      return Fate::blows_up;
    case Status::step_limit:
      return Fate::too_many_steps;
    default:
      return Fate::stalls;
  }
}

Fate follow(BodySystem<double>& system, State<double>& state, long looks,
            const std::function<Status(long)>& advance, Watch& watch,
            const std::function<void(const Measures&)>& look) {
  constexpr double blown = 10;
  watch.energy_before = watch.most_energy = measure(system, state).mechanical();
  for (long i = 1; i <= looks; ++i) {
    const Status status = advance(i);
    if (status != Status::ok) return fate_of(status);
    const Measures m = measure(system, state);
    if (!(m.mechanical() <= blown * watch.energy_before)) return Fate::blows_up;
    watch.most_energy = std::max(watch.most_energy, m.mechanical());
    watch.last_jacobian = m.min_jacobian;
    watch.least_jacobian = std::fmin(watch.least_jacobian, m.min_jacobian);
    if (look) look(m);
  }
  return Fate::holds;
}

}  // namespace mss

// The single runs of `mss stability atlas`.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "core/measures/measures.hpp"
#include "core/springs/spring_system.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/disturbance.hpp"
#include "experiments/studies/atlas/atlas.hpp"
#include "integrators/analysis/modes.hpp"
#include "integrators/analysis/stable_step.hpp"

namespace mss::studies::atlas {

namespace {

constexpr int samples_per_period = 16;

BodyConfig cube(const AtlasBody& body) {
  BodyConfig config = unit_cube({.young = 1e4, .poisson = body.poisson}, 1000, body.cells, body.ratio);
  if (body.viscosity > 0) config.damping = {.law = Damping::Law::viscosity, .viscosity = body.viscosity};
  return config;
}

/// Stretched along x about its middle, with superposed fast motions a hundredth as large.
State<double> stretched(BodySystem<double>& system, double strain) {
  constexpr double fast_share = 0.01;
  State<double> state = system.rest_state();
  const Field<double> fast =
      fast_disturbance(system, state, fast_share * std::abs(strain) * system.body().config().cell_size, 1);
  for (const std::ptrdiff_t site : system.particles()) {
    Vec3 x = state.x.at(site);
    x[0] = 0.5 + (1 + strain) * (x[0] - 0.5);
    state.x.set(site, x + fast.at(site));
  }
  return state;
}

/// The energy at samples until after the end of the longest step that is tried, by a method of small steps;
/// shorter if it fails.
Json reference_energies(BodySystem<double>& system, double strain, double omega, double period) {
  constexpr double small = 0.05, longest = 512;  // dt omega_max
  const auto method = find_integrator("damped_verlet").make<double>({.dt = small / omega});
  State<double> state = stretched(system, strain);
  Work work;
  Json energies = Json::array({measure(system, state).mechanical()});
  const int samples = int(std::ceil((1 + longest / omega / period) * samples_per_period));
  for (int i = 1; i <= samples; ++i) {
    if (method->advance(system, state, i * period / samples_per_period, work) != Status::ok) break;
    energies.push_back(measure(system, state).mechanical());
  }
  return energies;
}

Json compute_body(const AtlasBody& config) {
  constexpr int rigid = 6;
  const Body body(cube(config));
  SpringSystem<double> system(body, {}, {.threads = 1});
  Work work;
  const State<double> rest = system.rest_state();
  const Modes fast = fastest_mode(system, rest, work), slow = slowest_modes(system, rest, rigid + 1, work);
  for (const Status status : {fast.status, slow.status})
    if (status != Status::ok) return {{"status", to_string(status)}};
  const double omega = fast.modes.front().omega, period = 2 * std::numbers::pi / slow.modes.back().omega;
  return {{"status", "ok"},
          {"omega", omega},
          {"period", period},
          {"energies", reference_energies(system, config.strain, omega, period)}};
}

Json compute_limit(const AtlasCase& run, double omega) {
  const IntegratorInfo& method = find_integrator(run.integrator);
  const Body body(cube(run.body));
  SpringSystem<double> system(body, {}, {.threads = 1});
  Work work;
  const PredictedStep step = predicted_step(method, system, system.rest_state(), work);
  return {{"status", to_string(step.status)}, {"dt_omega", step.dt * omega}};
}

/// The reference's energy at a time; after its end the last one.
double reference_at(const Json& body, double t) {
  const double sample = t / body["period"].get<double>() * samples_per_period;
  const auto& energies = body["energies"];
  const auto last = energies.size() - 1;
  const auto i = std::size_t(std::min(sample, double(last)));
  const double share = i == last ? 0 : sample - double(i);
  return (1 - share) * energies[i].get<double>() + share * energies[std::min(i + 1, last)].get<double>();
}

/// How many steps, or intervals, a run has.
struct Horizon {
  long first;  ///< in which energy is compared with the reference
  long last;   ///< after which energy must have stopped growing
};

/// First two slowest periods, of methods for any step 1.125. Growth is a rate per step, of a motion of
/// frequency w proportional to (dt w)^2 for a method of first order that is damped too weakly. Methods with a
/// limit go on for 64 times the inverse, explicit Euler with w of the slowest motion, which may be the one
/// that grows, the others with omega_max, and for 4096 steps at least.
Horizon horizon_of(const IntegratorInfo& method, double dt, double omega, double period) {
  constexpr double growths = 64;
  constexpr long fewest = 1L << 12, most = 1L << 22;
  const bool any_step = method.stepping == Stepping::fixed && !method.limit;
  const long least = method.stepping == Stepping::adaptive ? 4 : any_step ? 48 : 512;
  const double periods = any_step ? 1.125 : 2;
  const long first = std::max(least, long(std::ceil(periods * period / dt)));
  if (!method.limit) return {first, first};
  const double growing = is_slowly_unstable(method) ? 2 * std::numbers::pi / period : omega;
  return {first, std::max(first, std::clamp(long(growths / std::pow(dt * growing, 2)), fewest, most))};
}

/// Energy after one slowest period, over the initial one.
struct RemainingEnergy {
  double energy = no_value, reference = no_value;
  bool is_too_low() const {
    constexpr double rounding = 1e-12;
    return reference > rounding && energy < 0.5 * reference;
  }
};

/// The integrator of a run and its state; counts steps from the start.
struct AtlasRun {
  AtlasRun(const AtlasCase& run, const IntegratorInfo& method, BodySystem<double>& of_body, double step,
           double period)
      : system(of_body), state(stretched(of_body, run.body.strain)), dt(step) {
    constexpr long most_steps = 500;  // in one interval
    const double amplitude = std::abs(run.body.strain);
    integrator = method.make<double>({.dt = method.stepping == Stepping::adaptive ? 0 : dt,
                                      .length_scale = amplitude,
                                      .speed_scale = amplitude * 2 * std::numbers::pi / period,
                                      .most_steps = most_steps});
  }
  Status advance_to(long step) { return integrator->advance(system, state, double(step) * dt, work); }

  BodySystem<double>& system;
  State<double> state;
  double dt;
  std::unique_ptr<Integrator<double>> integrator;
  Work work;
};

/// Runs on in windows, each as long as all before, until the horizon's end or until energy has died away;
/// blows up if it grows from the last window but one to the last.
Outcome run_on(AtlasRun& run, SampledRun& sampled, long steps, long last, Outcome outcome) {
  constexpr double died_away = 1e-5;
  constexpr long window_samples = 64;
  bool grows = false;
  while (steps < last && (outcome == Outcome::stable || outcome == Outcome::gains_energy)) {
    const double before = sampled.mean_energy();
    const long stride = std::max(1L, steps / window_samples);
    outcome =
        sampled.run(steps / stride, [&](long sample) { return run.advance_to(steps + sample * stride); });
    steps += steps / stride * stride;
    grows = sampled.mean_energy() > (1 + SampledRun::tolerated_growth) * before;
    if (!grows && sampled.mean_energy() < died_away * sampled.extremes().initial_energy) break;
  }
  return grows ? Outcome::blows_up : outcome;
}

Json compute_outcome(const AtlasCase& atlas_case, const Json& body) {
  constexpr long most_samples = 128;
  const IntegratorInfo& method = find_integrator(atlas_case.integrator);
  const double omega = body["omega"], period = body["period"];
  const double dt = dt_omega(atlas_case.step) / omega;
  const Body cells(cube(atlas_case.body));
  SpringSystem<double> system(cells, {}, {.threads = 1});
  AtlasRun run(atlas_case, method, system, dt, period);
  const Horizon horizon = horizon_of(method, dt, omega, period);
  const long stride = std::max(1L, horizon.first / most_samples), samples = horizon.first / stride;
  SampledRun sampled(system, run.state, velocity_lag(method, dt));
  RemainingEnergy remaining;
  Outcome outcome = sampled.run(
      samples, [&](long sample) { return run.advance_to(sample * stride); },
      [&](const Measures& m) {
        if (run.state.t < period || !std::isnan(remaining.energy)) return;
        const double initial = sampled.extremes().initial_energy;
        remaining = {m.mechanical() / initial, reference_at(body, run.state.t) / initial};
      });
  outcome = run_on(run, sampled, samples * stride, horizon.last, outcome);
  const RunExtremes& extremes = sampled.extremes();
  if (outcome == Outcome::stable)
    outcome = extremes.min_jacobian <= 0 ? Outcome::folds
              : remaining.is_too_low()   ? Outcome::loses_energy
                                         : Outcome::stable;
  return {{"outcome", int(outcome)},
          {"seconds", run.state.t},
          {"max_energy", extremes.max_energy / extremes.initial_energy},
          {"energy_left", remaining.energy},
          {"reference_left", remaining.reference},
          {"min_jacobian", extremes.min_jacobian}};
}

}  // namespace

Json compute(const AtlasCase& atlas_case, const Journal& journal) {
  if (atlas_case.kind == AtlasCase::Kind::body) return compute_body(atlas_case.body);
  const Json& body = *journal.find(AtlasCase{AtlasCase::Kind::body, atlas_case.body}.name());
  return atlas_case.kind == AtlasCase::Kind::limit ? compute_limit(atlas_case, body["omega"])
                                                   : compute_outcome(atlas_case, body);
}

std::string AtlasBody::name() const {
  const std::string damping =
      viscosity > 0 ? fmt::format("viscosity {}", viscosity) : fmt::format("ratio {}", ratio);
  return fmt::format("{} cells, {}, nu {}, strain {}", cells, damping, poisson, strain);
}

std::string AtlasCase::name() const {
  switch (kind) {
    case Kind::body:
      return body.name();
    case Kind::limit:
      return fmt::format("{}, limit, {}", integrator, body.name());
    case Kind::outcome:
      break;
  }
  return fmt::format("{}, {}, step {}", integrator, body.name(), step);
}

}  // namespace mss::studies::atlas

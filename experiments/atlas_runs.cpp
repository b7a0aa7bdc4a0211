// What `mss stability atlas` asks, and its answers.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/measures.hpp"
#include "core/spring_system.hpp"
#include "experiments/atlas.hpp"
#include "experiments/stability.hpp"
#include "integrators/modes.hpp"
#include "integrators/stable_step.hpp"

namespace mss {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr int reference_periods = 4, samples_per_period = 16;

double energy(const Measures& m) { return m.kinetic + m.elastic + m.volume_energy; }

BodyConfig cube(const AtlasBody& body) {
  StabilityConfig config = stability_config({});
  config.poisson = body.poisson;
  return stability_cube(config, body.cells, body.ratio);
}

/// Stretched along x about its middle, with a hundredth as much of fast motions.
State<double> stretched(BodySystem<double>& system, double strain) {
  constexpr double fast_share = 0.01;
  State<double> state = system.rest_state();
  const double edge = system.body().config().cell_size;
  const Field<double> fast = fast_disturbance(system, fast_share * std::abs(strain) * edge, 1);
  for (const std::ptrdiff_t site : system.particles()) {
    Vec3 x = state.x.at(site);
    x[0] = 0.5 + (1 + strain) * (x[0] - 0.5);
    state.x.set(site, x + fast.at(site));
  }
  return state;
}

/// The energy left after whole samples of the slowest period, by small steps.
Json reference_energies(BodySystem<double>& system, double strain, double omega, double period) {
  constexpr double small = 0.05;  // dt omega_max
  const auto method = find_integrator("damped_verlet").make<double>({.dt = small / omega});
  State<double> state = stretched(system, strain);
  Work work;
  Json energies = Json::array({energy(measure(system, state))});
  for (int i = 1; i <= reference_periods * samples_per_period; ++i) {
    method->advance(system, state, i * period / samples_per_period, work);
    energies.push_back(energy(measure(system, state)));
  }
  return energies;
}

Json answer_body(const AtlasBody& asked) {
  constexpr int rigid = 6;
  const Body body(cube(asked));
  SpringSystem<double> system(body, {}, {.threads = 1});
  Work work;
  const State<double> rest = system.rest_state();
  const Modes fast = fastest_mode(system, rest, work), slow = slowest_modes(system, rest, rigid + 1, work);
  for (const Status status : {fast.status, slow.status})
    if (status != Status::ok) return {{"status", to_string(status)}};
  const double omega = fast.modes.front().omega, period = 2 * M_PI / slow.modes.back().omega;
  return {{"status", "ok"},
          {"omega", omega},
          {"period", period},
          {"energies", reference_energies(system, asked.strain, omega, period)}};
}

Json answer_limit(const AtlasQuestion& question, double omega) {
  const IntegratorInfo& method = find_integrator(question.integrator);
  const Body body(cube(question.body));
  SpringSystem<double> system(body, {}, {.threads = 1});
  Work work;
  const PredictedStep step = predicted_step(method, system, system.rest_state(), work);
  return {{"status", to_string(step.status)}, {"dt_omega", step.dt * omega}};
}

/// What is watched during a run.
struct Watch {
  double energy_before = 0, most_energy = 0, least_jacobian = 1;
  double left = none, reference_left = none;  ///< after a slow period, of the energy before

  bool lost_energy() const { return reference_left - left > std::max(0.5 * reference_left, 0.05); }
};

/// The reference's energy at a time; the last one known from then on.
double reference_at(const Json& body, double t) {
  const double sample = t / body["period"].get<double>() * samples_per_period;
  const auto& energies = body["energies"];
  const auto last = energies.size() - 1;
  const auto i = std::size_t(std::min(sample, double(last)));
  const double share = i == last ? 0 : sample - double(i);
  return (1 - share) * energies[i].get<double>() + share * energies[std::min(i + 1, last)].get<double>();
}

/// Steps, or intervals, of a run: two slow periods, and enough of them to see growth.
long steps_of(const IntegratorInfo& method, double dt, double period) {
  const long least = method.stepping == Stepping::adaptive ? 4 : method.implicit ? 48 : 512;
  return std::max(least, long(std::ceil(2 * period / dt)));
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

/// Follows a run until it ends or fails.
Fate follow(Integrator<double>& method, BodySystem<double>& system, State<double>& state, const Json& body,
            double dt, long steps, Watch& watch) {
  constexpr long looks = 128;
  constexpr double blown = 10;
  const double period = body["period"];
  const long stride = std::max(1L, steps / looks);
  Work work;
  watch.energy_before = watch.most_energy = energy(measure(system, state));
  for (long step = stride; step <= steps; step += stride) {
    const Status status = method.advance(system, state, double(step) * dt, work);
    if (status != Status::ok) return fate_of(status);
    const Measures m = measure(system, state);
    const double now = energy(m);
    if (!(now <= blown * watch.energy_before)) return Fate::blows_up;
    watch.most_energy = std::max(watch.most_energy, now);
    watch.least_jacobian = std::min(watch.least_jacobian, m.min_jacobian);
    if (std::isnan(watch.left) && state.t >= period) {
      watch.left = now / watch.energy_before;
      watch.reference_left = reference_at(body, state.t) / watch.energy_before;
    }
  }
  if (watch.least_jacobian <= 0) return Fate::folds;
  return watch.lost_energy() ? Fate::loses_energy : Fate::holds;
}

Json answer_fate(const AtlasQuestion& question, const Json& body) {
  constexpr long most_steps = 500;  // of one interval
  const IntegratorInfo& method = find_integrator(question.integrator);
  const double omega = body["omega"], period = body["period"];
  const double dt = std::exp2(double(question.step) / octave_parts) / omega;
  const Body cells(cube(question.body));
  SpringSystem<double> system(cells, {}, {.threads = 1});
  const double amplitude = std::abs(question.body.strain);
  const bool adaptive = method.stepping == Stepping::adaptive;
  const auto integrator = method.make<double>({.dt = adaptive ? 0 : dt,
                                               .length_scale = amplitude,
                                               .speed_scale = amplitude * 2 * M_PI / period,
                                               .most_steps = most_steps});
  State<double> state = stretched(system, question.body.strain);
  Watch watch;
  const Fate fate = follow(*integrator, system, state, body, dt, steps_of(method, dt, period), watch);
  return {{"fate", int(fate)},
          {"seconds", state.t},
          {"most_energy", watch.most_energy / watch.energy_before},
          {"energy_left", watch.left},
          {"reference_left", watch.reference_left},
          {"min_jacobian", watch.least_jacobian}};
}

}  // namespace

Json answer(const AtlasQuestion& question, const Journal& journal) {
  if (question.kind == AtlasQuestion::Kind::body) return answer_body(question.body);
  const Json& body = *journal.find(AtlasQuestion{AtlasQuestion::Kind::body, question.body}.name());
  return question.kind == AtlasQuestion::Kind::limit ? answer_limit(question, body["omega"])
                                                     : answer_fate(question, body);
}

std::string AtlasBody::name() const {
  return fmt::format("{} cells, ratio {}, nu {}, strain {}", cells, ratio, poisson, strain);
}

std::string AtlasQuestion::name() const {
  switch (kind) {
    case Kind::body:
      return body.name();
    case Kind::limit:
      return fmt::format("{}, limit, {}", integrator, body.name());
    case Kind::fate:
      break;
  }
  return fmt::format("{}, {}, step {}", integrator, body.name(), step);
}

}  // namespace mss

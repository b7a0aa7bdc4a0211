// What `mss stability atlas` asks, and its answers.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/measures.hpp"
#include "core/spring_system.hpp"
#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/disturbance.hpp"
#include "experiments/studies/atlas/atlas.hpp"
#include "integrators/modes.hpp"
#include "integrators/stable_step.hpp"

namespace mss::studies::atlas {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr int reference_periods = 4, samples_per_period = 16;

BodyConfig cube(const AtlasBody& body) {
  return unit_cube({.young = 1e4, .poisson = body.poisson}, 1000, body.cells, body.ratio);
}

/// Stretched along x about its middle, with a hundredth as much of fast motions.
State<double> stretched(BodySystem<double>& system, double strain) {
  constexpr double fast_share = 0.01;
  State<double> state = system.rest_state();
  const Field<double> fast =
      fast_disturbance(system, fast_share * std::abs(strain) * system.body().config().cell_size, 1);
  for (const std::ptrdiff_t site : system.particles()) {
    Vec3 x = state.x.at(site);
    x[0] = 0.5 + (1 + strain) * (x[0] - 0.5);
    state.x.set(site, x + fast.at(site));
  }
  return state;
}

/// The energy left after whole samples of the slowest period, by small steps; shorter if they fail.
Json reference_energies(BodySystem<double>& system, double strain, double omega, double period) {
  constexpr double small = 0.05;  // dt omega_max
  const auto method = find_integrator("damped_verlet").make<double>({.dt = small / omega});
  State<double> state = stretched(system, strain);
  Work work;
  Json energies = Json::array({measure(system, state).mechanical()});
  for (int i = 1; i <= reference_periods * samples_per_period; ++i) {
    if (method->advance(system, state, i * period / samples_per_period, work) != Status::ok) break;
    energies.push_back(measure(system, state).mechanical());
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

/// The reference's energy at a time; the last one known from then on.
double reference_at(const Json& body, double t) {
  const double sample = t / body["period"].get<double>() * samples_per_period;
  const auto& energies = body["energies"];
  const auto last = energies.size() - 1;
  const auto i = std::size_t(std::min(sample, double(last)));
  const double share = i == last ? 0 : sample - double(i);
  return (1 - share) * energies[i].get<double>() + share * energies[std::min(i + 1, last)].get<double>();
}

/// Steps, or intervals, of a run: two slow periods, of implicit methods one and an eighth; and enough to see
/// growth.
long steps_of(const IntegratorInfo& method, double dt, double period) {
  const long least = method.stepping == Stepping::adaptive ? 4 : method.implicit ? 48 : 512;
  const double periods = method.stepping == Stepping::fixed && method.implicit ? 1.125 : 2;
  return std::max(least, long(std::ceil(periods * period / dt)));
}

/// Energy after a slow period, of that before.
struct Left {
  double energy = none, reference = none;
  bool lost() const { return reference - energy > std::max(0.5 * reference, 0.05); }
};

Json answer_fate(const AtlasQuestion& question, const Json& body) {
  constexpr long most_steps = 500;  // of one interval
  constexpr long most_looks = 128;
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
  const long steps = steps_of(method, dt, period), stride = std::max(1L, steps / most_looks);
  Work work;
  Watch watch;
  Left left;
  Fate fate = follow(
      system, state, steps / stride,
      [&](long look) { return integrator->advance(system, state, double(look * stride) * dt, work); }, watch,
      [&](const Measures& m) {
        if (state.t < period || !std::isnan(left.energy)) return;
        left = {m.mechanical() / watch.energy_before, reference_at(body, state.t) / watch.energy_before};
      });
  if (fate == Fate::holds)
    fate = watch.least_jacobian <= 0 ? Fate::folds : left.lost() ? Fate::loses_energy : Fate::holds;
  return {{"fate", int(fate)},
          {"seconds", state.t},
          {"most_energy", watch.most_energy / watch.energy_before},
          {"energy_left", left.energy},
          {"reference_left", left.reference},
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

}  // namespace mss::studies::atlas

// How `mss stability` finds the largest stable step.
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/spring_system.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/disturbance.hpp"
#include "experiments/studies/stability/stability.hpp"
#include "integrators/modes.hpp"
#include "integrators/stable_step.hpp"

namespace mss::studies::stability {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

double largest_speed(const State<double>& state) { return state.v.array().abs().maxCoeff(); }

/// A body whose particles are displaced from rest by at most a millionth of a cell, so that its motion is
/// linear.
State<double> disturbed(const StabilityConfig& config, BodySystem<double>& system) {
  constexpr double share_of_cell = 1e-6;
  State<double> state = system.rest_state();
  state.x.array() +=
      fast_disturbance(system, share_of_cell * system.body().config().cell_size, config.seed).array();
  return state;
}

/// Whether a step is stable. Runs a small motion in windows, each twice as long as the one before, and
/// compares the largest speeds. The run ends once the speed has grown or decayed enough; otherwise a damped
/// motion counts as stable if the largest speed of the last window is below that of the window before,
/// because motions that decay have had time to do so. An undamped motion never decays; if it has not grown by
/// the end, it grows by less than 3e-4 a step.
bool is_stable(const StabilityConfig& config, const IntegratorInfo& method, BodySystem<double>& system,
               double dt) {
  constexpr double grown = 100, gone = 1e-5;
  constexpr long first_window = 512, sample_every = 32;
  const bool damped = system.body().config().damping.zeta > 0;
  const long last_window = damped ? 65536 : 16384;
  const auto integrator = method.make<double>({.dt = dt});
  State<double> state = disturbed(config, system);
  Work work;
  if (integrator->advance(system, state, dt, work) != Status::ok) return false;
  const double begin = largest_speed(state);
  double before = infinity;
  long step = 1;
  for (long window = first_window; window <= last_window; window *= 2) {
    double speed = 0;
    for (const long end = step + window; step < end;) {
      step += sample_every;
      if (integrator->advance(system, state, double(step) * dt, work) != Status::ok) return false;
      speed = std::max(speed, largest_speed(state));
      if (!(speed < grown * begin)) return false;
    }
    if (speed < gone * begin) return true;
    if (2 * window > last_window) return !damped || speed < before;
    before = speed;
  }
  return true;
}

/// Seconds per step, the least of several samples.
double step_seconds(const IntegratorInfo& method, BodySystem<double>& system, double dt) {
  constexpr int samples = 50;
  constexpr long steps = 64;
  const auto integrator = method.make<double>({.dt = dt});
  State<double> state = system.rest_state();
  Work work;
  double least = infinity;
  for (int sample = 1; sample <= samples; ++sample) {
    const double seconds =
        seconds_of([&] { integrator->advance(system, state, double(sample * steps) * dt, work); });
    least = std::min(least, seconds / double(steps));
  }
  return least;
}

/// A cube at rest, and the frequency of its fastest mode.
struct Specimen {
  Specimen(const StabilityConfig& config, int n, double ratio)
      : cells(n),
        damping(ratio),
        body(unit_cube({.young = config.young, .poisson = config.poisson}, config.density, n, ratio)),
        system(body, {}, {.threads = config.threads}) {
    Work work;
    const Modes fastest = fastest_mode(system, system.rest_state(), work);
    status = fastest.status;
    if (status == Status::ok) omega = fastest.modes.front().omega;
  }
  int cells;
  double damping;
  Body body;
  SpringSystem<double> system;
  Status status = Status::ok;
  double omega = none;
};

void add_row(const StabilityConfig& config, const IntegratorInfo& method, Specimen& cube, Table& rows) {
  SpringSystem<double>& system = cube.system;
  const double guaranteed = guaranteed_step(method, system.spectral_bound());
  Work work;
  const PredictedStep predicted = predicted_step(method, system, system.rest_state(), work);
  const Status known = cube.status == Status::ok ? predicted.status : cube.status;
  if (known != Status::ok) {
    rows.add({method.name, cube.cells, cube.damping, cube.omega, guaranteed, none, none, none, none, none,
              std::string(to_string(known))});
    return;
  }
  const MeasuredStep measured =
      measure_step(config, method, system, predicted.dt > 0 ? predicted.dt : 2 / cube.omega);
  const bool ok = measured.stable > 0 && std::isfinite(measured.unstable);
  const double middle = ok ? (measured.stable + measured.unstable) / 2 : none;
  const double seconds = ok ? step_seconds(method, system, measured.stable) : none;
  rows.add({method.name, cube.cells, cube.damping, cube.omega, guaranteed, predicted.dt, middle,
            middle / predicted.dt, seconds, middle / seconds,
            ok                    ? "ok"
            : measured.stable > 0 ? "every step is stable"
                                  : "no step is stable"});
}

}  // namespace

MeasuredStep measure_step(const StabilityConfig& config, const IntegratorInfo& method,
                          BodySystem<double>& system, double guess) {
  constexpr double least_share = 1e-2, most_share = 1e3;  // of the guess
  double low = 0.97 * guess, high = 1.03 * guess;
  if (is_stable(config, method, system, low)) {
    while (is_stable(config, method, system, high)) {
      low = high;
      high *= 2;
      if (high > most_share * guess) return {low, infinity};
    }
  } else {
    do {
      high = low;
      low /= 2;
      if (low < least_share * guess) return {};
    } while (!is_stable(config, method, system, low));
  }
  while (high - low > config.resolution * low) {
    const double middle = (low + high) / 2;
    (is_stable(config, method, system, middle) ? low : high) = middle;
  }
  return {low, high};
}

StabilityTables measure_stability(const StabilityConfig& config, Progress& progress) {
  StabilityTables tables{Table({{"integrator"},
                                {"cells"},
                                {"ratio"},
                                {"omega_max", "rad/s"},
                                {"guaranteed", "s"},
                                {"predicted", "s"},
                                {"measured", "s"},
                                {"measured_over_predicted"},
                                {"seconds_per_step", "s"},
                                {"real_time_factor"},
                                {"status"}})};
  const double total = double(config.cells.size() * config.ratios.size() * config.integrators.size());
  double done = 0;
  for (const int n : config.cells)
    for (const double ratio : config.ratios) {
      Specimen cube(config, n, ratio);
      for (const std::string& name : config.integrators) {
        progress.report(done++ / total, fmt::format("{}, {} cells, damping ratio {:g}", name, n, ratio));
        if (progress.stopped()) {
          tables.status = Status::interrupted;
          return tables;
        }
        add_row(config, find_integrator(name), cube, tables.rows);
      }
    }
  return tables;
}

}  // namespace mss::studies::stability

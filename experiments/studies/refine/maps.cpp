// Problems in cells of several sizes: which cells are smaller, and what that saves.
#include "experiments/studies/refine/maps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/refinement/marking.hpp"
#include "experiments/harness/extrapolation.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/studies/refine/answers.hpp"
#include "integrators/analysis/stable_step.hpp"

namespace mss::studies::refine {

namespace {

/// Seconds of a step of Verlet's method; a step is short, so it is taken from as many as last long enough.
double seconds_per_step(System<double>& system, State<double> state, double sample_seconds) {
  const KickDrift verlet{.kick_before = 1e-6, .drift_new = 1e-6};
  const auto seconds_for = [&](long steps) {
    return seconds_of([&] { system.kick_drift(verlet, 1e-6, steps, state); });
  };
  const SampleLength length = sample_length(sample_seconds, seconds_for);
  constexpr int repetitions = 3;
  std::vector<double> samples;
  samples.reserve(repetitions);
  for (int i = 0; i < repetitions; ++i) samples.push_back(seconds_for(length.steps) / double(length.steps));
  return quartiles(samples).median;
}

class Maps {
 public:
  Maps(const MapConfig& config, Progress& progress) : config_(config), progress_(progress) {}
  MapTables run();

 private:
  BodyConfig body(int n) const { return in_cells(problem_->shape, n, config_.material, config_.face_share); }
  void find_reference();
  void measure_uniform();
  void measure_by_hand();
  void measure_estimated(Map map);
  void measure_surface();
  Answer measure(Map map, int n, Solid& solid);
  bool goes_on(Map map, int n);
  bool fits(const Solid& solid, std::size_t most) const {
    return solid.system->particles().size() <= std::min(most, problem_->most_particles);
  }

  const MapConfig& config_;
  Progress& progress_;
  const MapProblem* problem_ = nullptr;
  double reference_ = no_value;
  double period_ = no_value;  ///< of the slowest vibration [s]
  MapTables tables_{.rows = Table({{"problem"},
                                   {"description"},
                                   {"quantity"},
                                   {"map"},
                                   {"cells_per_metre"},
                                   {"levels"},
                                   {"particles"},
                                   {"value"},
                                   {"reference"},
                                   {"error"},
                                   {"answer_seconds", "s"},
                                   {"step_seconds", "s"},
                                   {"steps_per_period"},
                                   {"period_seconds", "s"},
                                   {"local_period_seconds", "s"},
                                   {"status"}}),
                    .gains = Table(std::vector<Column>{})};
};

/// False if stopped.
bool Maps::goes_on(Map map, int n) {
  const auto at = double(problem_ - config_.problems.data());
  progress_.report(at / double(config_.problems.size()),
                   fmt::format("{}, {}, {} cells a metre", problem_->name, to_string(map), n));
  if (progress_.stopped()) tables_.status = Status::interrupted;
  return tables_.status == Status::ok;
}

/// And the period, of the middle one of the three sizes.
void Maps::find_reference() {
  std::vector<double> values;
  for (const int share : {4, 2, 1}) {
    const int n = problem_->finest / (share * config_.reference_coarsening);
    if (!goes_on(Map::uniform, n)) return;
    Solid solid(body(n), {}, problem_->shape.environment);
    values.push_back(answer(solid, *problem_).value);
  }
  reference_ = limit_of(values).value;
  Solid solid(body(problem_->coarsest), {}, problem_->shape.environment);
  period_ = slowest_vibration(solid).period;
}

Answer Maps::measure(Map map, int n, Solid& solid) {
  Answer answered = answer(solid, *problem_);
  const IntegratorInfo& verlet = find_integrator("verlet");
  SolidSystem<double>& system = *solid.system;
  const double dt = safe_share * stable_step(verlet, system.spectral_bound()),
               local_dt = safe_share * stable_step(verlet, system.local_bound());
  const std::unique_ptr<System<double>> in_local_steps = system.with_local_steps(local_dt);
  const State<double> rest = system.undeformed_state();
  const double step = seconds_per_step(system, rest, config_.sample_seconds),
               local_step =
                   in_local_steps ? seconds_per_step(*in_local_steps, rest, config_.sample_seconds) : step;
  const bool ok = answered.status == Status::ok;
  tables_.rows.add({problem_->name, problem_->description, to_string(problem_->quantity), to_string(map), n,
                    solid.body.depth(solid.body.levels().size() - 1), std::int64_t(system.particles().size()),
                    ok ? answered.value : no_value, reference_,
                    ok ? std::abs(answered.value / reference_ - 1) : no_value, answered.seconds, step,
                    period_ / dt, step * period_ / dt, local_step * period_ / local_dt,
                    std::string(to_string(answered.status))});
  return answered;
}

void Maps::measure_uniform() {
  for (const int n : config_.uniform_cells) {
    if (!goes_on(Map::uniform, n)) return;
    if (n % problem_->multiple != 0) continue;
    Solid solid(body(n), {}, problem_->shape.environment);
    if (fits(solid, config_.most_uniform)) measure(Map::uniform, n, solid);
  }
}

void Maps::measure_by_hand() {
  for (const auto& [n, levels] : problem_->by_hand) {
    if (!goes_on(Map::by_hand, n)) return;
    Solid solid(body(n), split_near(body(n), problem_->distance, levels), problem_->shape.environment);
    if (fits(solid, config_.most_particles)) measure(Map::by_hand, n, solid);
  }
}

void Maps::measure_estimated(Map map) {
  const int n = problem_->coarsest;
  const Saved saved = map == Map::for_time ? Saved::time : Saved::particles;
  auto solid = std::make_unique<Solid>(body(n), RefinementMap(), problem_->shape.environment);
  while (goes_on(map, n)) {
    const Answer solved = measure(map, n, *solid);
    if (solved.status != Status::ok) return;
    const RefinementMap next =
        split_by_estimate(solid->body, solved.displacement, solved.dual ? &*solved.dual : nullptr, saved);
    solid = std::make_unique<Solid>(body(n), next, problem_->shape.environment);
    if (!fits(*solid, config_.most_particles)) return;
  }
}

void Maps::measure_surface() {
  for (const int n : config_.uniform_cells) {
    if (n % (2 * problem_->multiple) != 0 || !goes_on(Map::surface, n / 2)) continue;
    Solid solid(body(n / 2), split_surface(body(n / 2)), problem_->shape.environment);
    if (solid.body.levels().size() > 1 && fits(solid, config_.most_particles))
      measure(Map::surface, n / 2, solid);
  }
}

MapTables Maps::run() {
  for (const MapProblem& problem : config_.problems) {
    problem_ = &problem;
    find_reference();
    measure_uniform();
    measure_by_hand();
    measure_estimated(Map::estimated);
    measure_estimated(Map::for_time);
    measure_surface();
    if (tables_.status != Status::ok) break;
  }
  tables_.gains = gains_of(tables_.rows);
  return std::move(tables_);
}

}  // namespace

const std::string& to_string(Map map) {
  static const std::array<std::string, 5> names{"uniform", "by hand", "estimated", "estimated for time",
                                                "surface layers"};
  return names[std::size_t(map)];
}

MapConfig map_config(const ExperimentOptions& options) {
  MapConfig config{.problems = map_problems()};
  config.uniform_cells = options.quick ? std::vector{1, 2, 4, 6, 8}
                                       : std::vector{1, 2, 3, 4, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48, 64};
  config.reference_coarsening = options.quick ? 2 : 1;
  config.most_uniform = options.quick ? 2000 : 280000;
  config.most_particles = options.quick ? 1000 : 12000;
  config.sample_seconds = options.quick ? 0.005 : 0.03;
  return config;
}

MapTables measure_maps(const MapConfig& config, Progress& progress) { return Maps(config, progress).run(); }

}  // namespace mss::studies::refine

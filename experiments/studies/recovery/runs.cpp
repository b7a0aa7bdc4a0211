// The runs of `mss recovery`.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <random>

#include "core/measures.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/statistics.hpp"
#include "experiments/harness/workers.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/recovery/recovery.hpp"
#include "integrators/integrator.hpp"
#include "integrators/stable_step.hpp"

namespace mss::studies::recovery {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr std::array outcomes{Recovery::recovered, Recovery::mirrored, Recovery::trapped, Recovery::moving,
                              Recovery::non_finite};
constexpr double at_rest = 1e-6;  ///< largest stretch of what has recovered

const IntegratorInfo& method() { return find_integrator("verlet"); }

/// A tenth of what holds about rest, without a guard: trials begin far from any rest, and a guard that acts
/// makes motions up to three times as fast.
double trial_step(const BodySystem<double>& system) {
  return 0.1 * stable_step(method(), system.spectral_bound());
}

/// Lets go of a body until it is at rest, trapped (its stored energy stays what it is), or the time is over.
RecoveryTrial settle(BodySystem<double>& system, State<double>& state) {
  constexpr long look = 128, most_looks = 500;
  constexpr int same_looks = 50;
  constexpr double same = 1e-9;
  const double dt = trial_step(system);
  const auto integrator = method().make<double>({.dt = dt});
  Work work;
  double before = none;
  int unchanged = 0;
  RecoveryTrial trial{.outcome = Recovery::moving};
  for (long i = 1; i <= most_looks; ++i) {
    const Status status = integrator->advance(system, state, double(i * look) * dt, work);
    const Measures m = measure(system, state);
    const double stored = m.elastic + m.volume_energy;
    trial.seconds = state.t;
    if (status != Status::ok || !std::isfinite(stored))
      return {.outcome = Recovery::non_finite, .seconds = state.t, .max_stretch = none, .min_jacobian = none};
    trial.max_stretch = m.max_stretch;
    trial.min_jacobian = m.min_jacobian;
    unchanged = std::abs(stored - before) <= same * stored ? unchanged + 1 : 0;
    before = stored;
    if (m.max_stretch < at_rest)
      trial.outcome = m.min_jacobian > 0 ? Recovery::recovered : Recovery::mirrored;
    if (unchanged == same_looks) trial.outcome = Recovery::trapped;
    if (trial.outcome != Recovery::moving) break;
  }
  return trial;
}

/// Of one model and state.
struct Tally {
  std::map<Recovery, int> outcomes;
  std::vector<double> seconds;  ///< of those that recovered
  double worst_stretch = 0;     ///< of all that are finite

  void add(const RecoveryTrial& trial) {
    ++outcomes[trial.outcome];
    if (trial.outcome == Recovery::recovered) seconds.push_back(trial.seconds);
    if (std::isfinite(trial.max_stretch)) worst_stretch = std::max(worst_stretch, trial.max_stretch);
  }
};

/// All seeds of a model in a state.
Json answer_of(const RecoveryModel& model, const TrappedState& trap, std::uint64_t first_seed) {
  const Body body(model.body);
  const auto system = make_system<double>(model.model, body, {}, 1);
  Tally tally;
  for (int i = 0; i < model.seeds; ++i) tally.add(try_recovery(*system, trap, first_seed + std::uint64_t(i)));
  Json answer{{"seconds", tally.seconds.empty() ? none : quantile(tally.seconds, 0.5)},
              {"worst", tally.worst_stretch}};
  for (const Recovery outcome : outcomes) answer[to_string(outcome)] = tally.outcomes[outcome];
  return answer;
}

/// Harder and harder, until it does not recover.
Json answer_of(const RecoveryModel& model, const Landing& landing, const std::vector<double>& speeds) {
  Json answer{{"recovers_to", none}, {"folds_at", none}, {"max_stretch", none}, {"min_jacobian", none}};
  for (const double speed : speeds) {
    const RecoveryTrial trial = try_landing(model, landing, speed);
    answer["outcome"] = to_string(trial.outcome);
    if (trial.outcome == Recovery::recovered) {
      answer["recovers_to"] = speed;
      continue;
    }
    answer["folds_at"] = speed;
    answer["max_stretch"] = trial.max_stretch;
    answer["min_jacobian"] = trial.min_jacobian;
    break;
  }
  return answer;
}

/// The outcome of most that did not recover, or that they all did.
std::string usual(const Json& answer) {
  std::string most = "ok";
  int count = 0;
  for (const Recovery outcome : outcomes)
    if (const int times = answer[to_string(outcome)]; outcome != Recovery::recovered && times > count) {
      most = to_string(outcome);
      count = times;
    }
  return most;
}

std::string name_of(const RecoveryModel& model, const TrappedState& trap) {
  return model.name + ", " + to_string(trap);
}
std::string name_of(const RecoveryModel& model, const Landing& landing) {
  return fmt::format("{}, lands on its {}", model.name, landing.name);
}

std::vector<Case> cases_of(const RecoveryConfig& config) {
  std::vector<Case> cases;
  for (const RecoveryModel& model : config.models) {
    for (const TrappedState& trap : config.states)
      cases.push_back(
          {name_of(model, trap), [&model, &trap, &config] { return answer_of(model, trap, config.seed); }});
    if (model.lands && !config.landing_speeds.empty())
      for (const Landing& landing : landings())
        cases.push_back({name_of(model, landing), [&model, &landing, &config] {
                           return answer_of(model, landing, config.landing_speeds);
                         }});
  }
  return cases;
}

void add_rows(const RecoveryConfig& config, const Journal& journal, RecoveryTables& tables) {
  for (const RecoveryModel& m : config.models) {
    for (const TrappedState& trap : config.states)
      if (const Json* found = journal.find(name_of(m, trap))) {
        const Json& a = *found;
        std::vector<Cell> row{m.name, m.guarded ? 1 : 0, m.face_share, m.poisson, to_string(trap), m.seeds};
        for (const Recovery outcome : outcomes) row.emplace_back(a[to_string(outcome)].get<std::int64_t>());
        row.insert(row.end(), {a["recovered"].get<double>() / m.seeds, number(a["seconds"]),
                               number(a["worst"]), usual(a)});
        tables.rows.add(std::move(row));
      }
    for (const Landing& landing : landings())
      if (const Json* found = journal.find(name_of(m, landing))) {
        const Json& a = *found;
        const std::string outcome = a["outcome"];
        tables.landings.add({m.name, m.guarded ? 1 : 0, landing.name, number(a["recovers_to"]),
                             number(a["folds_at"]), number(a["max_stretch"]), number(a["min_jacobian"]),
                             outcome == "recovered" ? "recovers at any tried" : outcome});
      }
  }
}

RecoveryTables empty_tables() {
  return {.rows = Table({{"model"},
                         {"guarded"},
                         {"face_share"},
                         {"poisson"},
                         {"state"},
                         {"trials"},
                         {"recovered"},
                         {"mirrored"},
                         {"trapped"},
                         {"moving"},
                         {"non_finite"},
                         {"rate"},
                         {"median_seconds", "s"},
                         {"worst_stretch"},
                         {"status"}}),
          .landings = Table({{"model"},
                             {"guarded"},
                             {"landing"},
                             {"recovers_to", "m/s"},
                             {"folds_at", "m/s"},
                             {"max_stretch"},
                             {"min_jacobian"},
                             {"status"}})};
}

}  // namespace

RecoveryTrial try_recovery(BodySystem<double>& system, const TrappedState& trap, std::uint64_t seed) {
  const BodyConfig& config = system.body().config();
  State<double> state = system.rest_state();
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<> share(-1, 1);
  for (const std::ptrdiff_t site : system.particles()) {
    const double x = share(random), y = share(random), z = share(random);
    const Vec3 rest = (state.x.at(site) - config.origin) / config.cell_size;
    state.x.set(site, config.origin + config.cell_size * trap.put(rest, {x, y, z}, trap.amount));
  }
  return settle(system, state);
}

RecoveryTrial try_landing(const RecoveryModel& model, const Landing& landing, double speed) {
  constexpr double above = 1e-3;  // of a cell
  BodyConfig config = model.body;
  config.origin = above * config.cell_size * Vec3::Ones();
  const Environment ground{.planes = {{.point = Vec3::Zero(), .normal = landing.up, .restitution = 0.5}}};
  const Body body(config);
  const auto system = make_system<double>(model.model, body, ground, 1);
  State<double> state = system->rest_state();
  for (const std::ptrdiff_t site : system->particles()) state.v.set(site, -speed * landing.up);
  RecoveryTrial trial = settle(*system, state);
  const bool unfolded = trial.min_jacobian > 0;
  if (unfolded && (trial.outcome == Recovery::trapped || trial.outcome == Recovery::moving))
    trial.outcome = Recovery::recovered;
  return trial;
}

namespace {

/// A cube that is stretched by a twentieth and let go, as in ordinary scenes.
struct Ordinary {
  explicit Ordinary(const RecoveryModel& model)
      : body(model.body),
        system(make_system<double>(model.model, body, {}, 1)),
        state(stretched_state(*system, 1.05)) {
    dt = safe_share * stable_step(method(), system->spectral_bound());
    integrator = method().make<double>({.dt = dt});
  }
  void advance(long steps) {
    Work work;
    integrator->advance(*system, state, state.t + double(steps) * dt, work);
  }
  Body body;
  std::unique_ptr<BodySystem<double>> system;
  State<double> state;
  double dt = 0;
  std::unique_ptr<Integrator<double>> integrator;
};

/// The largest difference of a coordinate of two such cubes [m].
double difference(const Ordinary& a, const Ordinary& b) {
  return (a.state.x.array() - b.state.x.array()).abs().maxCoeff();
}

}  // namespace

Table measure_costs(const RecoveryConfig& config, const Progress& progress) {
  constexpr int repetitions = 15;
  constexpr long steps = 500;
  using Clock = std::chrono::steady_clock;
  std::vector<std::unique_ptr<Ordinary>> cubes;
  for (const RecoveryModel& model : config.models) cubes.push_back(std::make_unique<Ordinary>(model));
  std::vector<std::vector<double>> seconds(cubes.size());
  interleave(repetitions, cubes.size(), progress, [&](std::size_t i) {
    const auto begin = Clock::now();
    cubes[i]->advance(steps);
    seconds[i].push_back(std::chrono::duration<double>(Clock::now() - begin).count() / double(steps));
  });
  Table table(
      {{"model"}, {"guarded"}, {"median", "s"}, {"q1", "s"}, {"q3", "s"}, {"difference", "m"}, {"status"}});
  for (std::size_t i = 0; i < cubes.size(); ++i) {
    const bool measured = seconds[i].size() == repetitions;
    const bool has_plain = i > 0 && config.models[i].name.starts_with(config.models[i - 1].name);
    const double apart = !config.models[i].guarded ? 0
                         : measured && has_plain   ? difference(*cubes[i], *cubes[i - 1])
                                                   : none;
    table.add({config.models[i].name, config.models[i].guarded ? 1 : 0,
               measured ? quantile(seconds[i], 0.5) : none, measured ? quantile(seconds[i], 0.25) : none,
               measured ? quantile(seconds[i], 0.75) : none, apart, measured ? "ok" : "interrupted"});
  }
  return table;
}

RecoveryTables measure_recovery(const RecoveryConfig& config, int processes, Journal& journal,
                                Progress& progress) {
  RecoveryTables tables = empty_tables();
  if (!find_answers(cases_of(config), processes, journal, progress)) tables.status = Status::interrupted;
  add_rows(config, journal, tables);
  return tables;
}

}  // namespace mss::studies::recovery

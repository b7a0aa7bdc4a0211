// The trials of `mss recovery`, and what a step costs.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <random>

#include "experiments/harness/measure.hpp"
#include "experiments/harness/statistics.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/harness/workers.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/recovery/recovery.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "integrators/integrator.hpp"

namespace mss::studies::recovery {

namespace {

constexpr std::array outcomes{Recovery::recovered, Recovery::mirrored, Recovery::trapped, Recovery::moving,
                              Recovery::non_finite};

const IntegratorInfo& method() { return find_integrator("verlet"); }

/// Counts over the seeds of one model and state.
struct Tally {
  std::map<Recovery, int> outcomes;
  std::vector<double> seconds;  ///< until recovery
  double worst_stretch = 0;     ///< of all trials that stayed finite

  void add(const RecoveryTrial& trial) {
    ++outcomes[trial.outcome];
    if (trial.outcome == Recovery::recovered) seconds.push_back(trial.seconds);
    if (std::isfinite(trial.max_stretch)) worst_stretch = std::max(worst_stretch, trial.max_stretch);
  }
};

/// All seeds of a model in a state.
Json compute_states(const RecoveryModel& model, const TrappedState& trap, std::uint64_t first_seed) {
  const Body body(model.body);
  const auto system = model.system(body, {});
  Tally tally;
  for (int i = 0; i < model.seeds; ++i) tally.add(try_recovery(*system, trap, first_seed + std::uint64_t(i)));
  Json result{{"seconds", tally.seconds.empty() ? no_value : quantile(tally.seconds, 0.5)},
              {"worst", tally.worst_stretch}};
  for (const Recovery outcome : outcomes) result[to_string(outcome)] = tally.outcomes[outcome];
  return result;
}

/// Ascending speeds, until one from which it does not recover.
Json compute_landing(const RecoveryModel& model, const Landing& landing, const std::vector<double>& speeds) {
  Json result{{"highest_recovered", no_value},
              {"lowest_unrecovered", no_value},
              {"max_stretch", no_value},
              {"min_jacobian", no_value}};
  for (const double speed : speeds) {
    const RecoveryTrial trial = try_landing(model, landing, speed);
    result["outcome"] = to_string(trial.outcome);
    if (trial.outcome == Recovery::recovered) {
      result["highest_recovered"] = speed;
      continue;
    }
    result["lowest_unrecovered"] = speed;
    result["max_stretch"] = trial.max_stretch;
    result["min_jacobian"] = trial.min_jacobian;
    break;
  }
  return result;
}

/// The most frequent outcome of those that did not recover; "ok" if all did.
std::string most_frequent_failure(const Json& result) {
  std::string most = "ok";
  int count = 0;
  for (const Recovery outcome : outcomes)
    if (const int times = result[to_string(outcome)]; outcome != Recovery::recovered && times > count) {
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
      cases.push_back({name_of(model, trap),
                       [&model, &trap, &config] { return compute_states(model, trap, config.seed); }});
    if (model.lands && !config.landing_speeds.empty())
      for (const Landing& landing : landings())
        cases.push_back({name_of(model, landing), [&model, &landing, &config] {
                           return compute_landing(model, landing, config.landing_speeds);
                         }});
  }
  for (Case& one : cases) one.group = one.name;
  return cases;
}

/// The rows of one model that have results.
void add_rows(const RecoveryConfig& config, const RecoveryModel& m, const Journal& journal,
              RecoveryTables& tables) {
  const int guarded = m.guarded() ? 1 : 0;
  for (const TrappedState& trap : config.states)
    if (const Json* found = journal.find(name_of(m, trap))) {
      const Json& result = *found;
      std::vector<Cell> row{m.name, guarded, m.face_share, m.poisson, to_string(trap), m.seeds};
      for (const Recovery outcome : outcomes)
        row.emplace_back(result[to_string(outcome)].get<std::int64_t>());
      row.insert(row.end(), {result["recovered"].get<double>() / m.seeds, number(result["seconds"]),
                             number(result["worst"]), most_frequent_failure(result)});
      tables.rows.add(std::move(row));
    }
  for (const Landing& landing : landings())
    if (const Json* found = journal.find(name_of(m, landing))) {
      const Json& result = *found;
      const std::string outcome = result["outcome"];
      tables.landings.add(
          {m.name, guarded, landing.name, number(result["highest_recovered"]),
           number(result["lowest_unrecovered"]), number(result["max_stretch"]),
           number(result["min_jacobian"]),
           outcome == to_string(Recovery::recovered) ? "recovered at every speed tried" : outcome});
    }
}

RecoveryTables empty_tables() {
  return {
      .rows = Table({{"model"},
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
                         {"highest_recovered", "m/s"},
                         {"lowest_unrecovered", "m/s"},
                         {"max_stretch"},
                         {"min_jacobian"},
                         {"status"}}),
      .models = Table({{"model"}, {"unguarded"}, {"stiffness"}, {"guarded"}, {"face_share"}, {"poisson"}}),
      .speeds = Table(std::vector<Column>{{"speed", "m/s"}})};
}

}  // namespace

std::unique_ptr<BodySystem<double>> RecoveryModel::system(const Body& of,
                                                          const Environment& environment) const {
  return make_system<double>(law(), of, environment, 1);
}

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
  return settle(system, state, trial_step(system));
}

RecoveryTrial try_landing(const RecoveryModel& model, const Landing& landing, double speed) {
  return mss::try_landing(model.law(), model.body, {.normal = landing.up, .restitution = 0.5}, speed);
}

namespace {

/// A cube in motion far from folding: stretched by a twentieth and released.
struct OrdinaryMotion {
  explicit OrdinaryMotion(const RecoveryModel& model)
      : body(model.body), system(model.system(body, {})), state(stretched_state(*system, 1.05)) {
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

/// The largest difference of a coordinate between two cubes [m].
double difference(const OrdinaryMotion& a, const OrdinaryMotion& b) {
  return (a.state.x.array() - b.state.x.array()).abs().maxCoeff();
}

/// The model of that name; config.models.size() if there is none.
std::size_t index_of(const RecoveryConfig& config, const std::string& name) {
  const auto found = std::find_if(config.models.begin(), config.models.end(),
                                  [&](const RecoveryModel& model) { return model.name == name; });
  return std::size_t(found - config.models.begin());
}

}  // namespace

Table measure_costs(const RecoveryConfig& config, const Progress& progress) {
  constexpr int repetitions = 15;
  constexpr long steps = 500;
  std::vector<std::unique_ptr<OrdinaryMotion>> cubes;
  for (const RecoveryModel& model : config.models) cubes.push_back(std::make_unique<OrdinaryMotion>(model));
  const auto seconds = measure_interleaved(repetitions, cubes.size(), progress, [&](std::size_t i) {
    return seconds_of([&] { cubes[i]->advance(steps); }) / double(steps);
  });
  Table table(
      {{"model"}, {"guarded"}, {"median", "s"}, {"q1", "s"}, {"q3", "s"}, {"difference", "m"}, {"status"}});
  for (std::size_t i = 0; i < cubes.size(); ++i) {
    const RecoveryModel& model = config.models[i];
    const bool measured = seconds[i].size() == repetitions;
    const Quartiles q = measured ? quartiles(seconds[i]) : Quartiles{no_value, no_value, no_value};
    const std::size_t unguarded = index_of(config, model.unguarded);
    const bool comparable = measured && unguarded < cubes.size();
    table.add({model.name, model.guarded() ? 1 : 0, q.median, q.q1, q.q3,
               comparable ? difference(*cubes[i], *cubes[unguarded]) : no_value,
               !measured    ? "interrupted"
               : comparable ? "ok"
                            : "no unguarded model"});
  }
  return table;
}

RecoveryTables measure_recovery(const RecoveryConfig& config, int processes, Journal& journal,
                                Progress& progress) {
  RecoveryTables tables = empty_tables();
  if (!compute_cases(own_cases(cases_of(config), journal), processes, journal, progress))
    tables.status = Status::interrupted;
  for (const RecoveryModel& m : config.models) {
    add_rows(config, m, journal, tables);
    tables.models.add({m.name, m.unguarded, std::string(to_string(m.stiffness)), m.guarded() ? 1 : 0,
                       m.face_share, m.poisson});
  }
  for (const double speed : config.landing_speeds) tables.speeds.add({speed});
  return tables;
}

std::vector<NamedTable> recovery_files(RecoveryTables tables, Table costs) {
  return {{"recovery", std::move(tables.rows)},
          {"recovery_landing", std::move(tables.landings)},
          {"recovery_models", std::move(tables.models)},
          {"recovery_speeds", std::move(tables.speeds)},
          {"recovery_cost", std::move(costs)}};
}

}  // namespace mss::studies::recovery

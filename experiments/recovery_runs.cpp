// The runs of `mss recovery`.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <random>

#include "core/measures.hpp"
#include "experiments/model.hpp"
#include "experiments/recovery.hpp"
#include "experiments/workers.hpp"
#include "integrators/integrator.hpp"
#include "integrators/stable_step.hpp"

namespace mss {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr std::array outcomes{Recovery::recovered, Recovery::mirrored, Recovery::trapped, Recovery::moving,
                              Recovery::non_finite};
constexpr double at_rest = 1e-6;  ///< largest stretch of what has recovered

const IntegratorInfo& method() { return find_integrator("verlet"); }

/// A tenth of what the body at rest allows: the guard of a cell inside out is far stiffer.
double trial_step(const BodySystem<double>& system) {
  return 0.1 * stable_step(method(), system.spectral_bound());
}

/// Lets go of a body until it is at rest, trapped (its stored energy stays what it is), or the time is over.
Trial settle(BodySystem<double>& system, State<double>& state, double at_ease) {
  constexpr long look = 128, most_looks = 500;
  constexpr int same_looks = 50;
  constexpr double same = 1e-9;
  const double dt = trial_step(system);
  const auto integrator = method().make<double>({.dt = dt});
  Work work;
  double before = none;
  int unchanged = 0;
  for (long i = 1; i <= most_looks; ++i) {
    const Status status = integrator->advance(system, state, double(i * look) * dt, work);
    const Measures m = measure(system, state);
    const double stored = m.elastic + m.volume_energy;
    if (status != Status::ok || !std::isfinite(stored))
      return {.outcome = Recovery::non_finite, .seconds = state.t, .max_stretch = none};
    if (m.max_stretch < at_ease)
      return {.outcome = m.min_jacobian > 0 ? Recovery::recovered : Recovery::mirrored,
              .seconds = state.t,
              .max_stretch = m.max_stretch};
    unchanged = std::abs(stored - before) <= same * stored ? unchanged + 1 : 0;
    before = stored;
    if (unchanged == same_looks)
      return {.outcome = Recovery::trapped, .seconds = state.t, .max_stretch = m.max_stretch};
  }
  return {.outcome = Recovery::moving, .seconds = state.t, .max_stretch = measure(system, state).max_stretch};
}

/// Of one model and state.
struct Tally {
  std::map<Recovery, int> outcomes;
  std::vector<double> seconds;  ///< of those that recovered
  double worst_stretch = 0;     ///< of all that are finite

  void add(const Trial& trial) {
    ++outcomes[trial.outcome];
    if (trial.outcome == Recovery::recovered) seconds.push_back(trial.seconds);
    if (std::isfinite(trial.max_stretch)) worst_stretch = std::max(worst_stretch, trial.max_stretch);
  }
};

double median(std::vector<double> values) {
  if (values.empty()) return none;
  std::nth_element(values.begin(), values.begin() + std::ptrdiff_t(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// All seeds of a model in a state.
Json answer_of(const RecoveryModel& model, const TrappedState& trap, std::uint64_t first_seed) {
  const Body body(model.body);
  const auto system = make_system<double>(model.model, body, {}, 1);
  Tally tally;
  for (int i = 0; i < model.seeds; ++i) tally.add(try_recovery(*system, trap, first_seed + std::uint64_t(i)));
  Json answer{{"seconds", median(tally.seconds)}, {"worst", tally.worst_stretch}};
  for (const Recovery outcome : outcomes) answer[to_string(outcome)] = tally.outcomes[outcome];
  return answer;
}

Json answer_of(const RecoveryModel& model, double speed) {
  const Trial trial = try_landing(model, speed);
  return {
      {"outcome", to_string(trial.outcome)}, {"seconds", trial.seconds}, {"max_stretch", trial.max_stretch}};
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

/// A case of the journal, and what answers it.
struct Case {
  std::string name;
  std::function<Json()> answer;
};

std::vector<Case> cases_of(const RecoveryConfig& config) {
  std::vector<Case> cases;
  for (const RecoveryModel& model : config.models) {
    for (const TrappedState& trap : config.states)
      cases.push_back({model.name + ", " + to_string(trap),
                       [&model, &trap, &config] { return answer_of(model, trap, config.seed); }});
    if (model.lands)
      for (const double speed : config.landing_speeds)
        cases.push_back({fmt::format("{}, landing at {:g} m/s", model.name, speed),
                         [&model, speed] { return answer_of(model, speed); }});
  }
  return cases;
}

/// Of what a journal knows; a number it holds as null is missing.
double number(const Json& answer, const char* name) {
  return answer[name].is_null() ? none : answer[name].get<double>();
}

void add_rows(const RecoveryConfig& config, const Journal& journal, RecoveryTables& tables) {
  for (const RecoveryModel& m : config.models) {
    for (const TrappedState& trap : config.states)
      if (const Json* found = journal.find(m.name + ", " + to_string(trap))) {
        const Json& a = *found;
        std::vector<Cell> row{m.name, m.guarded ? 1 : 0, m.face_share, m.poisson, to_string(trap), m.seeds};
        for (const Recovery outcome : outcomes) row.emplace_back(a[to_string(outcome)].get<std::int64_t>());
        row.insert(row.end(), {a["recovered"].get<double>() / m.seeds, number(a, "seconds"),
                               number(a, "worst"), usual(a)});
        tables.rows.add(std::move(row));
      }
    for (const double speed : config.landing_speeds)
      if (const Json* found = journal.find(fmt::format("{}, landing at {:g} m/s", m.name, speed))) {
        const Json& a = *found;
        const std::string outcome = a["outcome"];
        tables.landings.add({m.name, m.guarded ? 1 : 0, speed, outcome, number(a, "seconds"),
                             number(a, "max_stretch"), outcome == "non_finite" ? "non_finite" : "ok"});
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
                             {"speed", "m/s"},
                             {"outcome"},
                             {"seconds", "s"},
                             {"max_stretch"},
                             {"status"}})};
}

}  // namespace

Trial try_recovery(BodySystem<double>& system, const TrappedState& trap, std::uint64_t seed) {
  const BodyConfig& config = system.body().config();
  State<double> state = system.rest_state();
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<> share(-1, 1);
  for (const std::ptrdiff_t site : system.particles()) {
    const double x = share(random), y = share(random), z = share(random);
    const Vec3 rest = (state.x.at(site) - config.origin) / config.cell_size;
    state.x.set(site, config.origin + config.cell_size * trap.put(rest, {x, y, z}, trap.amount));
  }
  return settle(system, state, at_rest);
}

Trial try_landing(const RecoveryModel& model, double speed) {
  constexpr double bounced_and_turning = 1e-3;  // turning stretches a little
  const Vec3 diagonal = Vec3::Ones().normalized();
  BodyConfig config = model.body;
  config.origin = 1e-3 * config.cell_size * Vec3::Ones();
  const Environment ground{.planes = {{.point = Vec3::Zero(), .normal = diagonal, .restitution = 0.5}}};
  const Body body(config);
  const auto system = make_system<double>(model.model, body, ground, 1);
  State<double> state = system->rest_state();
  for (const std::ptrdiff_t site : system->particles()) state.v.set(site, -speed * diagonal);
  return settle(*system, state, bounced_and_turning);
}

RecoveryTables measure_recovery(const RecoveryConfig& config, int processes, Journal& journal,
                                Progress& progress) {
  const std::vector<Case> cases = cases_of(config);
  std::vector<std::string> names;
  for (const Case& c : cases) names.push_back(c.name);
  RecoveryTables tables = empty_tables();
  if (!find_answers(
          names, [&](std::size_t i) { return cases[i].answer(); }, processes, journal, progress))
    tables.status = Status::interrupted;
  add_rows(config, journal, tables);
  return tables;
}

}  // namespace mss

// Which runs of `mss stability atlas` are needed: steps and rows on a coarse grid, and between neighbours of
// different outcome. Found again from the journal's results after every round, so that an interrupted run
// continues where it was.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <utility>

#include "experiments/harness/table.hpp"
#include "experiments/harness/workers.hpp"
#include "experiments/studies/atlas/atlas.hpp"

namespace mss::studies::atlas {

namespace {

/// One row of a map: a method and a body at steps that are finer where the outcome changes.
struct AtlasRow {
  int level = 0;
  AtlasBody body{};
  std::vector<std::pair<int, Outcome>> steps{};  ///< ascending
};

/// First and last octave of dt omega_max that is tried with a method.
struct Octaves {
  int first, last;
};
Octaves octaves_of(const IntegratorInfo& method) {
  if (method.stepping == Stepping::adaptive) return {-1, 9};
  if (!method.limit) return {-2, 7};
  return is_slowly_unstable(method) ? Octaves{-5, 3} : Octaves{-4, 3};
}

/// The coarse grid of steps.
std::vector<int> first_steps(const AtlasConfig& config, const IntegratorInfo& method) {
  const Octaves range = octaves_of(method);
  std::vector<int> steps;
  for (int octave = range.first; octave <= range.last; octave += config.quick ? 2 : 1)
    steps.push_back(octave * octave_parts);
  return steps;
}

/// The outcomes in a row, finer between steps of different outcome; adds cases without a result to `open`.
std::vector<std::pair<int, Outcome>> read_steps(const AtlasConfig& config, const AtlasBody& body,
                                                const std::string& integrator, const Journal& journal,
                                                std::vector<AtlasCase>& open) {
  std::map<int, Outcome> known;
  const auto look_up = [&](int step) {
    const AtlasCase run{AtlasCase::Kind::outcome, body, integrator, step};
    if (const Json* found = journal.find(run.name()))
      known[step] = Outcome((*found)["outcome"].get<int>());
    else
      open.push_back(run);
  };
  const std::size_t open_before = open.size();
  const IntegratorInfo& method = find_integrator(integrator);
  const int finest = method.limit ? config.finest : config.finest_without_limit;
  for (const int step : first_steps(config, method)) look_up(step);
  for (std::size_t before = 0; before != known.size() && open.size() == open_before;) {
    before = known.size();
    const std::vector<std::pair<int, Outcome>> steps(known.begin(), known.end());
    for (std::size_t i = 1; i < steps.size(); ++i)
      if (steps[i].second != steps[i - 1].second && steps[i].first - steps[i - 1].first > finest)
        look_up((steps[i].first + steps[i - 1].first) / 2);
  }
  return {known.begin(), known.end()};
}

/// Whether the map changes between two rows: another sequence of outcomes, or a change at another step.
bool differ(const AtlasRow& a, const AtlasRow& b) {
  constexpr int tolerance = octave_parts / 2;
  const auto sequence = [](const AtlasRow& row) {
    std::vector<std::pair<Outcome, int>> changes;  // with the last step of each
    for (const auto& [step, outcome] : row.steps)
      if (changes.empty() || changes.back().first != outcome)
        changes.emplace_back(outcome, step);
      else
        changes.back().second = step;
    return changes;
  };
  const auto left = sequence(a), right = sequence(b);
  if (left.size() != right.size()) return true;
  for (std::size_t i = 0; i < left.size(); ++i)
    if (left[i].first != right[i].first || std::abs(left[i].second - right[i].second) > tolerance)
      return true;
  return false;
}

/// Whether the results that a row's runs need are known; adds those that are not to `open`. A body without a
/// spectrum has no row.
bool is_ready(const AtlasBody& body, const std::string& integrator, const Journal& journal,
              std::vector<AtlasCase>& open) {
  const AtlasCase of_body{AtlasCase::Kind::body, body};
  const Json* found = journal.find(of_body.name());
  if (found == nullptr) {
    open.push_back(of_body);
    return false;
  }
  if ((*found)["status"] != "ok") return false;
  const AtlasCase limit{AtlasCase::Kind::limit, body, integrator};
  if (find_integrator(integrator).limit && journal.find(limit.name()) == nullptr) open.push_back(limit);
  return true;
}

/// The rows of a parameter and method as far as the journal has their results, ascending; adds cases without
/// a result to `open`.
std::vector<AtlasRow> read_rows(const AtlasConfig& config, const AtlasParameter& parameter,
                                const std::string& integrator, const Journal& journal,
                                std::vector<AtlasCase>& open) {
  std::map<int, AtlasRow> rows;
  const std::size_t open_before = open.size();
  const auto read = [&](int level) {
    AtlasRow row{.level = level};
    parameter.set(row.body, parameter.value(level));
    if (is_ready(row.body, integrator, journal, open))
      row.steps = read_steps(config, row.body, integrator, journal, open);
    rows[level] = std::move(row);
  };
  for (int level = 0; level <= parameter.levels(); level += 1 << parameter.halvings) read(level);
  for (std::size_t before = 0; before != rows.size() && open.size() == open_before;) {
    before = rows.size();
    std::vector<int> between;
    for (auto upper = std::next(rows.begin()), lower = rows.begin(); upper != rows.end(); ++upper, ++lower)
      if (upper->first - lower->first > 1 && differ(lower->second, upper->second))
        between.push_back((upper->first + lower->first) / 2);
    for (const int level : between) read(level);
  }
  std::vector<AtlasRow> out;
  for (auto& [level, row] : rows)
    if (!row.steps.empty()) out.push_back(std::move(row));
  return out;
}

/// All cases without a result, once each.
std::vector<AtlasCase> open_cases(const AtlasConfig& config, const Journal& journal) {
  std::map<std::string, AtlasCase> open;
  for (const AtlasParameter& parameter : config.parameters)
    for (const std::string& integrator : config.integrators) {
      std::vector<AtlasCase> of_map;
      read_rows(config, parameter, integrator, journal, of_map);
      for (const AtlasCase& one : of_map) open.emplace(one.name(), one);
    }
  std::vector<AtlasCase> out;
  out.reserve(open.size());
  for (const auto& [name, one] : open) out.push_back(one);
  return out;
}

double omega_of(const Journal& journal, const AtlasBody& body) {
  return (*journal.find(AtlasCase{AtlasCase::Kind::body, body}.name()))["omega"];
}

/// dt omega_max up to which linear theory predicts a method to be stable; NaN: no prediction.
double predicted(const Journal& journal, const AtlasBody& body, const std::string& integrator) {
  const Json* found = journal.find(AtlasCase{AtlasCase::Kind::limit, body, integrator}.name());
  return found != nullptr && (*found)["status"] == "ok" ? number((*found)["dt_omega"]) : no_value;
}

/// Of numbers that say why a run has its outcome, further digits would only fill the table.
double five_digits(const Json& value) {
  const std::string text = fmt::format("{:.4e}", number(value));
  double rounded = no_value;
  std::from_chars(text.data(), text.data() + text.size(), rounded);
  return rounded;
}

void add_points(const AtlasParameter& parameter, const std::string& integrator, const AtlasRow& row,
                const Journal& journal, Table& points) {
  const AtlasBody& b = row.body;
  for (const auto& [step, outcome] : row.steps) {
    const Json& run = *journal.find(AtlasCase{AtlasCase::Kind::outcome, b, integrator, step}.name());
    points.add({parameter.name, integrator, b.cells, b.ratio, b.viscosity, b.poisson, b.strain,
                dt_omega(step), five_digits(run["seconds"]), five_digits(run["max_energy"]),
                five_digits(run["energy_left"]), five_digits(run["reference_left"]),
                five_digits(run["min_jacobian"]), std::string(to_string(outcome))});
  }
}

/// Between which two steps the energy begins to grow without bound, of the first such change in a row: their
/// geometric mean, dt omega_max; NaN if it does nowhere, or everywhere.
double growth_limit(const AtlasRow& row) {
  const auto grown = std::find_if(row.steps.begin(), row.steps.end(),
                                  [](const auto& step) { return step.second == Outcome::blows_up; });
  if (grown == row.steps.begin() || grown == row.steps.end()) return no_value;
  return dt_omega((std::prev(grown)->first + grown->first) / 2.0);
}

/// Of a row, the largest step up to which all are stable, the next outcome, and the limit beside the
/// predicted one.
void add_limit(const AtlasParameter& parameter, const std::string& integrator, const AtlasRow& row,
               const Journal& journal, Table& limits) {
  const auto failed = std::find_if(row.steps.begin(), row.steps.end(),
                                   [](const auto& step) { return step.second != Outcome::stable; });
  const bool some = failed != row.steps.begin();
  const double limit = predicted(journal, row.body, integrator), grows = growth_limit(row);
  limits.add({parameter.name, integrator, parameter.value(row.level), omega_of(journal, row.body),
              some ? dt_omega(std::prev(failed)->first) : no_value,
              std::string(to_string(failed == row.steps.end() ? Outcome::stable : failed->second)), grows,
              limit, grows / limit,
              !some                          ? "stable at no step tried"
              : std::isfinite(grows / limit) ? "ok"
                                             : "no limit"});
}

AtlasTables empty_tables() {
  return {.points = Table({{"parameter"},
                           {"integrator"},
                           {"cells"},
                           {"ratio"},
                           {"viscosity", "Pa s"},
                           {"poisson"},
                           {"strain"},
                           {"dt_omega"},
                           {"seconds", "s"},
                           {"max_energy"},
                           {"energy_left"},
                           {"reference_left"},
                           {"min_jacobian"},
                           {"status"}}),
          .limits = Table({{"parameter"},
                           {"integrator"},
                           {"value"},
                           {"omega_max", "rad/s"},
                           {"stable_to"},
                           {"next_outcome"},
                           {"limit"},
                           {"predicted"},
                           {"limit_over_predicted"},
                           {"status"}}),
          .parameters = Table({{"parameter"}, {"label"}, {"position"}, {"value"}})};
}

AtlasTables tables_of(const AtlasConfig& config, const Journal& journal) {
  AtlasTables tables = empty_tables();
  for (const AtlasParameter& parameter : config.parameters) {
    for (int level = 0; level <= parameter.levels(); ++level)
      tables.parameters.add(
          {parameter.name, parameter.label, level / double(1 << parameter.halvings), parameter.value(level)});
    for (const std::string& integrator : config.integrators) {
      std::vector<AtlasCase> open;
      for (const AtlasRow& row : read_rows(config, parameter, integrator, journal, open)) {
        add_points(parameter, integrator, row, journal, tables.points);
        add_limit(parameter, integrator, row, journal, tables.limits);
      }
    }
  }
  return tables;
}

/// Adds the number of the round to reports; how many rounds there will be depends on the outcomes.
class Rounds final : public Progress {
 public:
  explicit Rounds(Progress& all) : all_(all) {}
  void begin() { ++round_; }
  void report(double done, std::string_view what) override {
    all_.report(done, fmt::format("(of round {})  {}", round_, what));
  }
  bool stopped() const override { return all_.stopped(); }

 private:
  Progress& all_;
  int round_ = 0;
};

}  // namespace

double AtlasParameter::value(int level) const {
  const int whole = level >> halvings, rest = level - (whole << halvings);
  if (rest == 0) return values[std::size_t(whole)];
  const double share = double(rest) / double(1 << halvings);
  return (1 - share) * values[std::size_t(whole)] + share * values[std::size_t(whole) + 1];
}

double dt_omega(double step) { return std::exp2(step / octave_parts); }

AtlasTables measure_atlas(const AtlasConfig& config, int processes, Journal& journal, Progress& progress) {
  Status status = Status::ok;
  Rounds rounds(progress);
  for (;;) {
    const std::vector<AtlasCase> open = open_cases(config, journal);
    std::vector<Case> cases;
    cases.reserve(open.size());
    for (const AtlasCase& one : open)
      cases.push_back({one.name(), [&] { return compute(one, journal); }, one.integrator});
    cases = own_cases(std::move(cases), journal);
    if (cases.empty()) break;
    rounds.begin();
    if (compute_cases(cases, processes, journal, rounds)) continue;
    status = Status::interrupted;
    break;
  }
  AtlasTables tables = tables_of(config, journal);
  tables.status = status;
  return tables;
}

std::vector<NamedTable> atlas_files(AtlasTables tables) {
  return {{"atlas", std::move(tables.points)},
          {"atlas_limits", std::move(tables.limits)},
          {"atlas_parameters", std::move(tables.parameters)}};
}

}  // namespace mss::studies::atlas

// Where methods survive: maps of what becomes of a stretched cube that is let go, over step and damping,
// Poisson's ratio, stretch, resolution; finer where fates change. Runs are in atlas_runs.cpp.
#include "experiments/studies/atlas/atlas.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "experiments/harness/workers.hpp"

namespace mss::studies::atlas {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

double dt_omega(double step) { return std::exp2(step / octave_parts); }

/// One row of a map: a method and a body at steps that are finer where fates change.
struct AtlasRow {
  int level = 0;
  AtlasBody body{};
  std::vector<std::pair<int, Fate>> steps{};  ///< ascending
};

/// First and last octave of dt omega_max that is tried with a method.
struct Octaves {
  int first, last;
};
Octaves octaves_of(const IntegratorInfo& method) {
  if (method.stepping == Stepping::adaptive) return {-1, 9};
  return method.implicit ? Octaves{-2, 7} : Octaves{-6, 3};
}

/// Steps that are tried whatever comes of them.
std::vector<int> first_steps(const AtlasConfig& config, const IntegratorInfo& method) {
  const Octaves range = octaves_of(method);
  std::vector<int> steps;
  for (int octave = range.first; octave <= range.last; octave += config.quick ? 2 : 1)
    steps.push_back(octave * octave_parts);
  return steps;
}

/// The fates of a row, finer between steps of different fate; asks for what is not known.
std::vector<std::pair<int, Fate>> read_steps(const AtlasConfig& config, const AtlasBody& body,
                                             const std::string& integrator, const Journal& journal,
                                             std::vector<AtlasQuestion>& open) {
  std::map<int, Fate> known;
  const auto look_up = [&](int step) {
    const AtlasQuestion question{AtlasQuestion::Kind::fate, body, integrator, step};
    if (const Json* found = journal.find(question.name()))
      known[step] = Fate((*found)["fate"].get<int>());
    else
      open.push_back(question);
  };
  const std::size_t open_before = open.size();
  for (const int step : first_steps(config, find_integrator(integrator))) look_up(step);
  for (std::size_t before = 0; before != known.size() && open.size() == open_before;) {
    before = known.size();
    const std::vector<std::pair<int, Fate>> steps(known.begin(), known.end());
    for (std::size_t i = 1; i < steps.size(); ++i)
      if (steps[i].second != steps[i - 1].second && steps[i].first - steps[i - 1].first > config.finest)
        look_up((steps[i].first + steps[i - 1].first) / 2);
  }
  return {known.begin(), known.end()};
}

/// Whether there is something between two rows that neither shows: another kind, or a change at another step.
bool differ(const AtlasRow& a, const AtlasRow& b) {
  constexpr int apart = octave_parts / 2;
  const auto kinds = [](const AtlasRow& row) {
    std::vector<std::pair<Fate, int>> changes;  // where each stretch of one fate ends
    for (const auto& [step, fate] : row.steps)
      if (changes.empty() || changes.back().first != fate)
        changes.emplace_back(fate, step);
      else
        changes.back().second = step;
    return changes;
  };
  const auto left = kinds(a), right = kinds(b);
  if (left.size() != right.size()) return true;
  for (std::size_t i = 0; i < left.size(); ++i)
    if (left[i].first != right[i].first || std::abs(left[i].second - right[i].second) > apart) return true;
  return false;
}

/// Whether what a row builds on is known; asks if not. A body that has no spectrum has no row.
bool is_ready(const AtlasBody& body, const std::string& integrator, const Journal& journal,
              std::vector<AtlasQuestion>& open) {
  const AtlasQuestion of_body{AtlasQuestion::Kind::body, body};
  const Json* found = journal.find(of_body.name());
  if (found == nullptr) {
    open.push_back(of_body);
    return false;
  }
  if ((*found)["status"] != "ok") return false;
  const AtlasQuestion limit{AtlasQuestion::Kind::limit, body, integrator};
  if (find_integrator(integrator).limit && journal.find(limit.name()) == nullptr) open.push_back(limit);
  return true;
}

/// The rows of a plane and method as far as the journal knows them, ascending; questions that are open are
/// added to `open`.
std::vector<AtlasRow> read_rows(const AtlasConfig& config, const AtlasPlane& plane,
                                const std::string& integrator, const Journal& journal,
                                std::vector<AtlasQuestion>& open) {
  std::map<int, AtlasRow> rows;
  const std::size_t open_before = open.size();
  const auto read = [&](int level) {
    AtlasRow row{.level = level};
    plane.set(row.body, plane.value(level));
    if (is_ready(row.body, integrator, journal, open))
      row.steps = read_steps(config, row.body, integrator, journal, open);
    rows[level] = std::move(row);
  };
  for (int level = 0; level <= plane.levels(); level += 1 << plane.halvings) read(level);
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

/// Everything that is open, once each.
std::vector<AtlasQuestion> open_questions(const AtlasConfig& config, const Journal& journal) {
  std::map<std::string, AtlasQuestion> open;
  for (const AtlasPlane& plane : config.planes)
    for (const std::string& integrator : config.integrators) {
      std::vector<AtlasQuestion> of_map;
      read_rows(config, plane, integrator, journal, of_map);
      for (const AtlasQuestion& question : of_map) open.emplace(question.name(), question);
    }
  std::vector<AtlasQuestion> out;
  for (const auto& [name, question] : open) out.push_back(question);
  return out;
}

double omega_of(const Journal& journal, const AtlasBody& body) {
  return (*journal.find(AtlasQuestion{AtlasQuestion::Kind::body, body}.name()))["omega"];
}

/// dt omega_max up to which a method should hold on a body; NaN: none is predicted.
double predicted(const Journal& journal, const AtlasBody& body, const std::string& integrator) {
  const Json* found = journal.find(AtlasQuestion{AtlasQuestion::Kind::limit, body, integrator}.name());
  return found != nullptr && (*found)["status"] == "ok" ? number((*found)["dt_omega"]) : none;
}

void add_points(const AtlasPlane& plane, const std::string& integrator, const AtlasRow& row,
                const Journal& journal, Table& points) {
  const AtlasBody& b = row.body;
  for (const auto& [step, fate] : row.steps) {
    const Json& a = *journal.find(AtlasQuestion{AtlasQuestion::Kind::fate, b, integrator, step}.name());
    points.add({plane.name, integrator, b.cells, b.ratio, b.poisson, b.strain, dt_omega(step),
                number(a["seconds"]), number(a["most_energy"]), number(a["energy_left"]),
                number(a["reference_left"]), number(a["min_jacobian"]), std::string(to_string(fate))});
  }
}

/// Of a row, the largest step below which all hold, and what comes next.
void add_limit(const AtlasPlane& plane, const std::string& integrator, const AtlasRow& row,
               const Journal& journal, Table& limits) {
  const auto failed = std::find_if(row.steps.begin(), row.steps.end(),
                                   [](const auto& step) { return step.second != Fate::holds; });
  const bool some = failed != row.steps.begin();
  const double limit = predicted(journal, row.body, integrator);
  limits.add({plane.name, integrator, plane.value(row.level), omega_of(journal, row.body),
              some ? dt_omega(std::prev(failed)->first) : none,
              failed == row.steps.end() ? "holds" : std::string(to_string(failed->second)), limit,
              !some                  ? "no step tried holds"
              : std::isfinite(limit) ? "ok"
                                     : "no limit"});
}

AtlasTables tables_of(const AtlasConfig& config, const Journal& journal) {
  AtlasTables tables{.points = Table({{"plane"},
                                      {"integrator"},
                                      {"cells"},
                                      {"ratio"},
                                      {"poisson"},
                                      {"strain"},
                                      {"dt_omega"},
                                      {"seconds", "s"},
                                      {"most_energy"},
                                      {"energy_left"},
                                      {"reference_left"},
                                      {"min_jacobian"},
                                      {"status"}}),
                     .limits = Table({{"plane"},
                                      {"integrator"},
                                      {"value"},
                                      {"omega_max", "rad/s"},
                                      {"holds_to"},
                                      {"then"},
                                      {"predicted"},
                                      {"status"}})};
  for (const AtlasPlane& plane : config.planes)
    for (const std::string& integrator : config.integrators) {
      std::vector<AtlasQuestion> open;
      for (const AtlasRow& row : read_rows(config, plane, integrator, journal, open)) {
        add_points(plane, integrator, row, journal, tables.points);
        add_limit(plane, integrator, row, journal, tables.limits);
      }
    }
  return tables;
}

/// Passes reports on with the number of their round: how many there will be nobody knows.
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

double AtlasPlane::value(int level) const {
  const int whole = level >> halvings, rest = level - (whole << halvings);
  if (rest == 0) return values[std::size_t(whole)];
  const double share = double(rest) / double(1 << halvings);
  return (1 - share) * values[std::size_t(whole)] + share * values[std::size_t(whole) + 1];
}

AtlasTables measure_atlas(const AtlasConfig& config, int processes, Journal& journal, Progress& progress) {
  Status status = Status::ok;
  Rounds rounds(progress);
  for (;;) {
    const std::vector<AtlasQuestion> open = open_questions(config, journal);
    if (open.empty()) break;
    std::vector<Case> cases;
    for (const AtlasQuestion& question : open)
      cases.push_back({question.name(), [&] { return answer(question, journal); }});
    rounds.begin();
    if (find_answers(cases, processes, journal, rounds)) continue;
    status = Status::interrupted;
    break;
  }
  AtlasTables tables = tables_of(config, journal);
  tables.status = status;
  return tables;
}

namespace {

constexpr const char* caption =
    "A cube of 1 m is stretched along x, with a hundredth as much of fast motions, and let go; "
    "calibrated springs, t = 0.5. Where nothing else is said it has 3 cells per edge, nu = 0.3, is "
    "stretched by 1 percent, and every spring's damping is 0.05 of critical. Each run lasts two "
    "periods of the slowest vibration and at least 512 steps; of implicit methods one and an eighth "
    "and 48, of those that choose their own steps two and 4 intervals. Loses energy: has, after one "
    "period, less than half of what small steps leave, and a twentieth of all less. Folds: a corner "
    "of a cell is inside out where somebody looks, 128 times in a run. Blows up: ten times the energy "
    "at the beginning. Stalls: a solver finds no solution. Too many steps: 500 do not suffice from "
    "look to look, for one dt or a few. White: not tried. omega_max is that of the body at rest, and "
    "so is the predicted limit: stretch stiffens springs. Small instabilities that take longer to "
    "grow are those of `mss stability`.";

Json configuration(const AtlasConfig& c) {
  Json planes = Json::array();
  for (const AtlasPlane& plane : c.planes)
    planes.push_back({{"name", plane.name}, {"values", plane.values}, {"halvings", plane.halvings}});
  return {{"planes", planes}, {"integrators", c.integrators}, {"finest", c.finest}, {"quick", c.quick}};
}

ChartAxis level_axis(const AtlasPlane& plane) {
  ChartAxis axis{.label = plane.label, .low = -0.5, .high = double(plane.values.size()) - 0.5};
  for (std::size_t i = 0; i < plane.values.size(); ++i) {
    axis.ticks.push_back(double(i));
    axis.names.push_back(fmt::format("{:g}", plane.values[i]));
  }
  return axis;
}

/// The steps of a row as bars that meet halfway between two fates.
void add_bars(const AtlasRow& row, double y_low, double y_high, MapPanel& panel) {
  const auto& steps = row.steps;
  double low = steps.front().first - octave_parts / 2.0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const bool last = i + 1 == steps.size();
    if (!last && steps[i + 1].second == steps[i].second) continue;
    const double high =
        last ? steps[i].first + octave_parts / 2.0 : (steps[i].first + steps[i + 1].first) / 2.0;
    panel.cells.push_back({dt_omega(low), dt_omega(high), y_low, y_high, int(steps[i].second)});
    low = high;
  }
}

/// The rows of a map, which meet halfway.
void add_cells(const std::vector<AtlasRow>& rows, double per_value, double low, double high,
               MapPanel& panel) {
  const auto middle = [&](std::size_t r) { return (rows[r].level + rows[r + 1].level) / (2 * per_value); };
  for (std::size_t r = 0; r < rows.size(); ++r)
    add_bars(rows[r], r == 0 ? low : middle(r - 1), r + 1 == rows.size() ? high : middle(r), panel);
}

MapChart map_of(const AtlasConfig& config, const AtlasPlane& plane, const Journal& journal) {
  const ChartAxis y = level_axis(plane);
  MapChart chart{.title = "Which method survives where: step against " + plane.label,
                 .subtitle =
                     "a stretched cube is let go; t = 0.5; else 3 cells, nu 0.3, stretch 0.01, damping 0.05; "
                     "white: not tried",
                 .x = {.label = "dt omega_max",
                       .logarithmic = true,
                       .low = 0.01,
                       .high = 1000,
                       .ticks = {0.1, 1, 10, 100}},
                 .y = y,
                 .kinds = fate_names(),
                 .line_label = "predicted limit"};
  for (const std::string& integrator : config.integrators) {
    std::vector<AtlasQuestion> open;
    const std::vector<AtlasRow> rows = read_rows(config, plane, integrator, journal, open);
    const double per_value = double(1 << plane.halvings);
    MapPanel panel{.title = integrator};
    add_cells(rows, per_value, y.low, y.high, panel);
    for (const AtlasRow& row : rows)
      if (const double limit = predicted(journal, row.body, integrator); limit > 0)
        panel.line.push_back({limit, row.level / per_value});
    chart.panels.push_back(std::move(panel));
  }
  return chart;
}

/// A line per method: up to which steps it holds, and what comes behind.
std::string summary(const Table& limits, const AtlasConfig& config) {
  std::string lines;
  for (const std::string& integrator : config.integrators) {
    double least = std::numeric_limits<double>::infinity(), most = 0;
    std::set<std::string> then;
    bool nowhere = false, reached = false;
    for (std::size_t r = 0; r < limits.size(); ++r) {
      if (limits.text(r, "integrator") != integrator) continue;
      reached = true;
      then.insert(limits.text(r, "then"));
      if (limits.text(r, "status") == "no step tried holds") {
        nowhere = true;
        continue;
      }
      least = std::min(least, limits.number(r, "holds_to"));
      most = std::max(most, limits.number(r, "holds_to"));
    }
    if (!reached) continue;  // interrupted before
    const bool at_the_end = then.erase(std::string(to_string(Fate::holds))) > 0;
    lines += most == 0 ? fmt::format("{:<22} holds at no step that was tried", integrator)
                       : fmt::format("{:<22} holds to dt omega_max = {:.3g} to {:.3g}{}{}", integrator, least,
                                     most, at_the_end ? ", in places the largest tried" : "",
                                     nowhere ? ", in places at no step" : "");
    if (!then.empty()) lines += fmt::format("; then: {}", fmt::join(then, ", "));
    lines += "\n";
  }
  return lines;
}

ExperimentResult run_atlas(const ExperimentOptions& options, Progress& progress) {
  const AtlasConfig config = atlas_config(options);
  Journal journal = open_journal(options, configuration(config));
  AtlasTables tables = measure_atlas(config, options.processes, journal, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  for (const AtlasPlane& plane : config.planes)
    result.maps.push_back({"atlas_" + plane.name, map_of(config, plane, journal)});
  result.summary = summary(tables.limits, config);
  result.tables = {{"atlas", std::move(tables.points)}, {"atlas_limits", std::move(tables.limits)}};
  return result;
}

/// A few rows whose fates are far from where they change.
Table baseline_table(const BaselineOptions&, Progress& progress) {
  AtlasConfig config =
      atlas_config({.quick = true, .integrators = {"semi_implicit_euler", "rk4", "backward_euler"}});
  std::erase_if(config.planes, [](const AtlasPlane& plane) { return plane.name != "ratio"; });
  config.finest = 2 * octave_parts;
  Journal journal;
  return measure_atlas(config, 1, journal, progress)
      .points.select({"integrator", "ratio", "dt_omega", "status"});
}

}  // namespace

AtlasConfig atlas_config(const ExperimentOptions& options) {
  AtlasConfig config{.planes = {{"ratio",
                                 "damping of every spring over its critical",
                                 {0, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2},
                                 1,
                                 [](AtlasBody& body, double value) { body.ratio = value; }},
                                {"poisson",
                                 "Poisson's ratio",
                                 {0, 0.1, 0.2, 0.3, 0.4, 0.45, 0.49, 0.499},
                                 1,
                                 [](AtlasBody& body, double value) { body.poisson = value; }},
                                {"strain",
                                 "stretch before it is let go",
                                 {-0.95, -0.8, -0.5, -0.2, 0.01, 0.2, 0.5, 1, 2, 3},
                                 1,
                                 [](AtlasBody& body, double value) { body.strain = value; }},
                                {"cells",
                                 "cells per edge",
                                 {2, 3, 4, 5, 6},
                                 0,
                                 [](AtlasBody& body, double value) { body.cells = int(value); }}},
                     .integrators = moving_integrators(options.integrators),
                     .quick = options.quick};
  if (options.quick) {
    config.finest = octave_parts;
    config.planes[0].values = {0, 0.05, 0.5, 2};
    config.planes[1].values = {0, 0.25, 0.45};
    config.planes[2].values = {-0.95, -0.5, 0.01, 1, 3};
    config.planes[3].values = {2, 3};
    for (AtlasPlane& plane : config.planes) plane.halvings = 0;
  }
  return config;
}

ExperimentInfo experiment() {
  return {.name = "atlas",
          .under = "stability",
          .summary =
              "maps of what becomes of a cube, per integrator: step against damping, nu, stretch, resolution",
          .accepts = {.integrators = moving_integrators, .processes = true},
          .run = run_atlas,
          .baseline = {.keys = {"integrator", "ratio", "dt_omega"}, .rules = {}, .table = baseline_table}};
}

}  // namespace mss::studies::atlas

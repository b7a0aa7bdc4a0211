// Which method is cheapest where: a held cube under gravity, over stiffness, damping and resolution, asked
// for its motion to 10, 1 and 0.1 percent, for frames that only stay stable, and for its rest to 1 percent.
// Every point is measured; the map is finer where another kind of method becomes the cheapest. Texts and the
// map's grid are here, runs in runs.cpp, who is cheapest and where theory expects it in cheapest.cpp, maps in
// chart.cpp.
#include "experiments/studies/regimes/regimes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "experiments/harness/workers.hpp"

namespace mss::studies::regimes {

namespace {

constexpr const char* caption =
    "The map: a cube of 1 m, 1000 kg/m^3, nu = 0.3, held at one face and released straight under gravity; a "
    "sixth of a second in frames of 1/60 s, and where it comes to rest. For every Young's modulus, damping "
    "ratio of its springs and number of cells per edge, the kind of method that needs the least wall time to "
    "meet a demand: a motion with an error of 10, 1 or 0.1 percent, frames that only stay stable (an error "
    "below the displacement itself), rest to 1 percent. A cell in two halves is a tie: the upper half is the "
    "cheapest kind, the lower half the next one, whose quartiles overlap or whose median differs by less "
    "than "
    "a tenth. The line is where a frame of safe explicit steps, at what one of them takes, should cost as "
    "much as the cheapest frame by a method for any step. Errors are root mean squares over frames and "
    "particles, over the displacement, of the distance from the fourth-order Runge-Kutta method at half of "
    "its safe step; where that would take longer than most_reference_seconds nothing is drawn. A run is "
    "stopped after most_seconds, or after most_over_best times the time of another that meets every demand. "
    "Explicit methods: those that need at most 1.2 times the fewest force evaluations, and two of fourth "
    "order, at their safe step, halved up to four times. The chart of the loaded cube: the same cube of 10 "
    "cells an edge without gravity, damping ratio 0.5, one face held, 1e5 N sideways on the opposite one, "
    "for "
    "one second, by which it is at rest where E is 100 MPa or more; explicit methods at their safe step, all "
    "others at 1/60 s; from the vertical line on linearised backward Euler with matrix_free costs less. "
    "Energies at the end and distances from velocity Verlet's motion are in its table. "
    "Medians of interleaved runs, one thread, set-up included. Not varied: shape, Poisson's ratio, contact, "
    "precision.";

Json configuration(const RegimesConfig& c) {
  return {{"cells", c.cells},
          {"damping_ratios", c.damping_ratios},
          {"moduli", c.moduli},
          {"halvings", c.halvings},
          {"frames", c.frames},
          {"frame", frame},
          {"repetitions", c.repetitions},
          {"most_seconds", c.most_seconds},
          {"most_over_best", c.most_over_best},
          {"most_reference_seconds", c.most_reference_seconds},
          {"loaded",
           {{"cells", c.loaded.cells},
            {"damping_ratio", c.loaded.damping_ratio},
            {"force", c.loaded.force},
            {"frames", c.loaded.frames},
            {"moduli", c.loaded.moduli}}}};
}

/// Young's modulus at a place between those of the coarse grid.
double modulus_at(const RegimesConfig& c, double place) {
  return c.moduli.front() * std::pow(c.moduli.back() / c.moduli.front(), place / double(c.moduli.size() - 1));
}

std::vector<Cell> cells_of(const RegimePoint& p) { return {p.cells, p.damping_ratio, p.young}; }

void add_runs(const RegimePoint& point, const char* what, const Json& runs, Table& table) {
  for (const Json& run : runs) {
    std::vector<Cell> row = cells_of(point);
    const std::string method = run["method"];
    row.insert(row.end(), {std::string(what), method, number(run["steps"])});
    for (const char* column : {"seconds", "q1", "q3", "error"}) row.emplace_back(number(run[column]));
    row.emplace_back(run["status"].get<std::string>());
    table.add(std::move(row));
  }
}

void add_point(const RegimePoint& point, const Json& result, RegimesTables& tables) {
  add_runs(point, "motion", result["motion"], tables.runs);
  add_runs(point, "rest", result["rest"], tables.runs);
  std::vector<Cell> row = cells_of(point);
  const std::string motion = result["motion_status"], rest = result["rest_status"];
  row.insert(row.end(), {number(result["explicit_step"]), number(result["explicit_dt"]),
                         motion == "ok" ? rest
                         : rest == "ok" ? motion
                                        : motion + "; " + rest});
  tables.points.add(std::move(row));
}

RegimesTables empty_tables() {
  return {Table({{"cells"},
                 {"damping_ratio"},
                 {"young", "Pa"},
                 {"what"},
                 {"method"},
                 {"steps_or_tolerance"},
                 {"seconds", "s"},
                 {"q1", "s"},
                 {"q3", "s"},
                 {"error"},
                 {"status"}}),
          Table({{"cells"},
                 {"damping_ratio"},
                 {"young", "Pa"},
                 {"explicit_step_seconds", "s"},
                 {"safe_dt", "s"},
                 {"status"}}),
          Table(std::vector<Column>{}),
          Table(std::vector<Column>{}),
          empty_loaded(),
          Table(std::vector<Column>{})};
}

/// The kinds that are cheapest at a point, by demand.
std::vector<std::string> kinds_at(const RegimePoint& point, const Json& result) {
  RegimesTables tables = empty_tables();
  add_point(point, result, tables);
  const Table cheapest = cheapest_methods(tables.runs);
  std::vector<std::string> kinds;
  for (std::size_t r = 0; r < cheapest.size(); ++r) kinds.push_back(cheapest.text(r, "kind"));
  return kinds;
}

/// Points of a row of the map as far as the journal has them, ascending; adds those that are missing to
/// `open`, halfway between neighbours of different kinds too.
std::vector<RegimePoint> row_of(const RegimesConfig& c, int cells, double ratio, const Journal& journal,
                                std::vector<RegimePoint>& open) {
  const std::size_t open_before = open.size();
  std::vector<double> places;
  for (std::size_t i = 0; i < c.moduli.size(); ++i) places.push_back(double(i));
  const auto point_at = [&](double place) { return RegimePoint{cells, ratio, modulus_at(c, place)}; };
  for (int halving = 0; halving <= c.halvings_of(cells); ++halving) {
    for (const double place : places)
      if (!journal.find(point_at(place).name())) open.push_back(point_at(place));
    if (halving == c.halvings_of(cells) || open.size() > open_before) break;
    std::vector<double> between;
    for (std::size_t i = 1; i < places.size(); ++i) {
      const RegimePoint a = point_at(places[i - 1]), b = point_at(places[i]);
      if (kinds_at(a, *journal.find(a.name())) != kinds_at(b, *journal.find(b.name())))
        between.push_back((places[i - 1] + places[i]) / 2);
    }
    places.insert(places.end(), between.begin(), between.end());
    std::sort(places.begin(), places.end());
  }
  std::vector<RegimePoint> row;
  for (const double place : places)
    if (journal.find(point_at(place).name())) row.push_back(point_at(place));
  return row;
}

/// All rows of the map.
std::vector<RegimePoint> points_of(const RegimesConfig& c, const Journal& journal,
                                   std::vector<RegimePoint>& open) {
  std::vector<RegimePoint> all;
  for (const int cells : c.cells)
    for (const double ratio : c.damping_ratios) {
      const std::vector<RegimePoint> row = row_of(c, cells, ratio, journal, open);
      all.insert(all.end(), row.begin(), row.end());
    }
  return all;
}

std::string summary(const RegimesTables& tables) {
  std::string lines;
  const Table &b = tables.boundaries, &c = tables.crossings;
  for (std::size_t r = 0; r < b.size(); ++r)
    lines += fmt::format("n = {}, damping ratio {}: {}\n", b.number(r, "cells"), b.number(r, "damping_ratio"),
                         b.text(r, "status") == "ok"
                             ? fmt::format("frames that only stay stable cost less by a method for any step "
                                           "from E = {:.2g} Pa on; predicted {:.2g}",
                                           b.number(r, "measured"), b.number(r, "predicted"))
                             : b.text(r, "status"));
  if (const double worst = worst_factor(b); std::isfinite(worst))
    lines +=
        fmt::format("of these moduli measured and predicted differ by a factor of at most {:.2g}\n", worst);
  for (std::size_t r = 0; r < c.size(); ++r) {
    lines += fmt::format(
        "loaded cube, {}: {}", c.text(r, "method"),
        c.text(r, "status") == "ok"
            ? fmt::format("costs less than any explicit method from E = {:.2g} Pa on", c.number(r, "young"))
            : c.text(r, "status"));
    const double difference = c.number(r, "largest_energy_difference");
    lines += std::isnan(difference)
                 ? "\n"
                 : fmt::format("; energy at the end within {:.1g} of Verlet's\n", difference);
  }
  return lines;
}

ExperimentResult run_regimes(const ExperimentOptions& options, Progress& progress) {
  const RegimesConfig config = regimes_config(options);
  Journal journal = open_journal(options, configuration(config));
  RegimesTables tables = measure_regimes(config, std::max(1, options.processes), journal, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  result.summary = summary(tables);
  result.tables = regimes_files(std::move(tables));
  return result;
}

/// Errors, which are the same on every machine.
Table baseline_table(const BaselineOptions& options, Progress& progress) {
  RegimesConfig config = regimes_config({.quick = true});
  config.cells = {options.quick ? 4 : 6};
  config.damping_ratios = {0.05};
  config.repetitions = 1;
  config.most_seconds = config.most_over_best = 3600;
  config.loaded.moduli.clear();
  config.halvings = 0;  // where they are depends on times
  Journal journal;
  return measure_regimes(config, 1, journal, progress)
      .runs.select({"young", "what", "method", "steps_or_tolerance", "error", "status"});
}

}  // namespace

std::vector<NamedTable> regimes_files(RegimesTables tables) {
  return {{"regimes", std::move(tables.cheapest)},      {"regimes_runs", std::move(tables.runs)},
          {"regimes_points", std::move(tables.points)}, {"regimes_boundaries", std::move(tables.boundaries)},
          {"regimes_loaded", std::move(tables.loaded)}, {"regimes_crossings", std::move(tables.crossings)}};
}

RegimesConfig regimes_config(const ExperimentOptions& options) {
  if (options.quick)
    return {.cells = options.cells.empty() ? std::vector<int>{4, 8} : options.cells,
            .damping_ratios = {0.05, 0.5},
            .moduli = {1e5, 1e7, 1e9},
            .halvings = 1,
            .most_seconds = 3,
            .most_reference_seconds = 3,
            .loaded = {.moduli = {1e6, 1e7, 1e8, 1e9}}};
  return {.cells = options.cells.empty() ? std::vector<int>{4, 8, 14} : options.cells,
          .damping_ratios = {0.005, 0.05, 0.5},
          .moduli = {1e4, 1e5, 1e6, 1e7, 1e8, 1e9},
          .halvings = 2,
          .loaded = {.moduli = {1e5, 1e6, 1e7, 1e8, 1e9, 1e10}}};
}

namespace {

/// False if stopped. Adds points where the kind changes as long as there are any.
bool compute_map(const RegimesConfig& config, int processes, Journal& journal, Progress& progress) {
  for (;;) {
    std::vector<RegimePoint> open;
    points_of(config, journal, open);
    std::vector<Case> cases;
    cases.reserve(open.size());
    for (const RegimePoint& point : open)
      cases.push_back({point.name(), [point, &config] { return compute_point(point, config); },
                       fmt::format("{} cells, ratio {}", point.cells, point.damping_ratio)});
    cases = own_cases(std::move(cases), journal);
    if (cases.empty()) return true;
    if (!compute_cases(cases, processes, journal, progress)) return false;
  }
}

std::string loaded_name(double young) { return fmt::format("loaded, E {:.6g}", young); }

/// False if stopped.
bool compute_all_loaded(const RegimesConfig& config, int processes, Journal& journal, Progress& progress) {
  std::vector<Case> cases;
  for (const double young : config.loaded.moduli)
    cases.push_back(
        {loaded_name(young), [young, &config] { return compute_loaded(young, config); }, loaded_name(young)});
  return compute_cases(own_cases(std::move(cases), journal), processes, journal, progress);
}

}  // namespace

RegimesTables measure_regimes(const RegimesConfig& config, int processes, Journal& journal,
                              Progress& progress) {
  RegimesTables tables = empty_tables();
  if (!compute_all_loaded(config, processes, journal, progress) ||
      !compute_map(config, processes, journal, progress))
    tables.status = Status::interrupted;
  std::vector<RegimePoint> missing;
  for (const RegimePoint& point : points_of(config, journal, missing))
    add_point(point, *journal.find(point.name()), tables);
  for (const double young : config.loaded.moduli)
    if (const Json* runs = journal.find(loaded_name(young)))
      add_loaded(config.loaded, young, *runs, tables.loaded);
  tables.cheapest = cheapest_methods(tables.runs);
  tables.boundaries = boundaries(tables.points, tables.runs, tables.cheapest, config.frames);
  tables.crossings = loaded_crossings(tables.loaded);
  return tables;
}

ExperimentInfo experiment() {
  return {.name = "regimes",
          .summary = "which method is cheapest where: over stiffness, damping, resolution and what is asked",
          .accepts = {.cells = true, .largest_cells = 40, .processes = true},
          .times = true,
          .run = run_regimes,
          .draw = draw_regimes,
          .baseline = {.keys = {"young", "what", "method", "steps_or_tolerance"},
                       .rules = {{"error", 1e-3, 1e-6}},
                       .table = baseline_table}};
}

}  // namespace mss::studies::regimes

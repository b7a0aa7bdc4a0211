// Which method is cheapest where: scenes that people have, over stiffness and damping, asked for their motion
// to 10, 1 and 0.1 percent, for frames that only stay stable, and for their rest to 1 percent. Every point is
// measured; a map is finer where another kind of method becomes the cheapest. Texts and the maps' grids are
// here, runs in runs.cpp, who is cheapest and where theory expects it in cheapest.cpp, maps in
// chart.cpp.
#include "experiments/studies/regimes/regimes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "experiments/harness/workers.hpp"
#include "experiments/simulation/bench_scenes.hpp"

namespace mss::studies::regimes {

namespace {

constexpr const char* caption =
    "The map: scenes that people have, of 1000 kg/m^3 and nu = 0.3, in frames of 1/60 s: a cube of 1 m held "
    "at "
    "one face and an L of 0.2 m held at its foot, released under gravity, and where they come to rest; a "
    "ball "
    "of 0.4 m and the mesh of a bear of 0.3 m that come to the ground at 1.5 m/s; a free cube of 0.5 m that "
    "turns at 10 rad/s; cubes of 0.4 m at rest on the ground and on a slope of 19 degrees with a friction of "
    "0.5, on which as much weight is put. Planes stop what reaches them (restitution 0). For every Young's "
    "modulus and damping ratio of its springs, the kind of method that needs the least wall time to meet a "
    "demand: a motion with an error of 10, 1 or 0.1 percent, frames that only stay stable, rest to 1 "
    "percent. "
    "Stable: at the end of no frame is the kinetic and stored energy more than 1.5 times what the scene "
    "supplies, its energy at the start and what gravity and loads do in the true motion, or the displacement "
    "more than 1.5 times the largest of the true one, or a particle more than a tenth of a cell behind a "
    "plane, or a cell folded where none is in truth; the other demands include it. Numbers in that column of "
    "the map are the errors of its winners, in percent. A cell in two halves is a tie: the upper half is the "
    "cheapest kind, the lower half the next one, whose quartiles overlap or whose median differs by less "
    "than "
    "a tenth. The line is where a frame of safe explicit steps, at what one of them takes, should cost as "
    "much as the cheapest frame by a method for any step. Errors are root mean squares over frames and "
    "particles, over the displacement, of the distance from the true motion: that of an explicit method at "
    "a quarter of its safe step, on planes at a sixteenth or less. Its uncertainty is its distance from "
    "steps twice "
    "as "
    "long; demands of less than ten times that are not made. Where it would take longer than "
    "most_reference_seconds nothing is drawn. All families are tuned by one rule: of 1, 2, 4 ... 32 steps a "
    "frame, of 1, 2, 5, 10 and 20 iterations or passes a step where it has them, and of what it alone has "
    "(linear solvers to 1e-2, 1e-4 and 1e-6; Chebyshev's radius 0, 0.9 and 0.95), the cheapest that "
    "meets the demand; regimes_families.csv has the same of the settings that families had before, which are "
    "marked untuned: linear systems to 1e-10, 5 iterations of L-BFGS, 1 of xpbd, 20 of vbd. A run is stopped "
    "after most_seconds, or after most_over_best times the time of another that meets what its family has "
    "not; iterations are not added, and tolerances not tightened, where that changes the error by less than "
    "2 percent. Explicit methods: "
    "those that need at most 1.2 times the fewest force evaluations, and two of fourth order, at their safe "
    "step, halved up to four times. The chart of the loaded cube: a cube of 1 m, 10 cells an edge, without "
    "gravity, damping ratio 0.5, one face held, 1e5 N sideways on the opposite one, for one second, by which "
    "it is at rest where E is 100 MPa or more; explicit methods at their safe step, all others at 1/60 s, "
    "not "
    "tuned; from the vertical line on linearised backward Euler with matrix_free costs less. Energies at the "
    "end and distances from velocity Verlet's motion are in its table. Medians of interleaved runs, one "
    "thread, set-up included. Not varied: Poisson's ratio, restitution, precision.";

Json configuration(const RegimesConfig& c) {
  Json grids = Json::array(), families = Json::array();
  for (const RegimesGrid& grid : c.grids)
    grids.push_back({{"scene", grid.scene},
                     {"description", find_bench_scene(grid.scene).description},
                     {"cells", grid.cells},
                     {"frames", c.frames > 0 ? c.frames : find_bench_scene(grid.scene).frames},
                     {"damping_ratios", grid.damping_ratios},
                     {"moduli", grid.moduli},
                     {"halvings", grid.halvings}});
  for (const RegimeFamily& family : regime_families())
    families.push_back(
        {{"method", family.method}, {"setting", family.setting}, {"efforts", family.efforts.size()}});
  return {{"scenes", grids},
          {"families", families},
          {"steps_per_frame", tried_steps},
          {"iterations", tried_iterations},
          {"linear_tolerances", tried_tolerances},
          {"frame", frame},
          {"bounded_factor", bounded_factor},
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
double modulus_at(const RegimesGrid& c, double place) {
  return c.moduli.front() * std::pow(c.moduli.back() / c.moduli.front(), place / double(c.moduli.size() - 1));
}

std::vector<Cell> cells_of(const RegimePoint& p) { return {p.scene, p.cells, p.damping_ratio, p.young}; }

void add_runs(const RegimePoint& point, const char* what, double uncertainty, const Json& runs,
              Table& table) {
  for (const Json& run : runs) {
    std::vector<Cell> row = cells_of(point);
    row.insert(row.end(),
               {std::string(what), run["method"].get<std::string>(), run["setting"].get<std::string>(),
                run["untuned"].get<std::int64_t>(), number(run["steps"])});
    for (const char* column : {"seconds", "q1", "q3", "error", "energy", "displacement"})
      row.emplace_back(number(run[column]));
    row.emplace_back(run["bounds"].get<std::string>());
    row.emplace_back(uncertainty);
    row.emplace_back(run["status"].get<std::string>());
    table.add(std::move(row));
  }
}

/// What went wrong with the references; that nothing holds a body is no fault.
std::string status_of(const RegimePoint& point, const Json& result) {
  std::string motion = result["motion_status"], rest = result["rest_status"];
  if (rest == "ok" || !find_bench_scene(point.scene).is_held()) return motion;
  return motion == "ok" ? rest : motion + "; " + rest;
}

void add_point(const RegimePoint& point, const Json& result, RegimesTables& tables) {
  const double uncertainty = number(result["uncertainty"]);
  add_runs(point, "motion", uncertainty, result["motion"], tables.runs);
  add_runs(point, "rest", 0, result["rest"], tables.runs);
  std::vector<Cell> row = cells_of(point);
  row.insert(row.end(), {number(result["explicit_step"]), number(result["explicit_dt"]),
                         result["frames"].get<std::int64_t>(), uncertainty, status_of(point, result)});
  tables.points.add(std::move(row));
}

RegimesTables empty_tables() {
  return {Table({{"scene"},
                 {"cells"},
                 {"damping_ratio"},
                 {"young", "Pa"},
                 {"what"},
                 {"method"},
                 {"setting"},
                 {"untuned"},
                 {"steps_or_tolerance"},
                 {"seconds", "s"},
                 {"q1", "s"},
                 {"q3", "s"},
                 {"error"},
                 {"energy"},
                 {"displacement"},
                 {"bounds"},
                 {"uncertainty"},
                 {"status"}}),
          Table({{"scene"},
                 {"cells"},
                 {"damping_ratio"},
                 {"young", "Pa"},
                 {"explicit_step_seconds", "s"},
                 {"safe_dt", "s"},
                 {"frames"},
                 {"uncertainty"},
                 {"status"}}),
          Table(std::vector<Column>{}),
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

/// Points of a row of a map as far as the journal has them, ascending; adds those that are missing to
/// `open`, halfway between neighbours of different kinds too.
std::vector<RegimePoint> row_of(const RegimesGrid& c, double ratio, const Journal& journal,
                                std::vector<RegimePoint>& open) {
  const std::size_t open_before = open.size();
  std::vector<double> places;
  for (std::size_t i = 0; i < c.moduli.size(); ++i) places.push_back(double(i));
  const auto point_at = [&](double place) {
    return RegimePoint{c.scene, c.cells, ratio, modulus_at(c, place)};
  };
  for (int halving = 0; halving <= c.halvings; ++halving) {
    for (const double place : places)
      if (!journal.find(point_at(place).name())) open.push_back(point_at(place));
    if (halving == c.halvings || open.size() > open_before) break;
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

/// All rows of the maps.
std::vector<RegimePoint> points_of(const RegimesConfig& c, const Journal& journal,
                                   std::vector<RegimePoint>& open) {
  std::vector<RegimePoint> all;
  for (const RegimesGrid& grid : c.grids)
    for (const double ratio : grid.damping_ratios) {
      const std::vector<RegimePoint> row = row_of(grid, ratio, journal, open);
      all.insert(all.end(), row.begin(), row.end());
    }
  return all;
}

std::string summary(const RegimesTables& tables) {
  std::string lines;
  const Table &b = tables.boundaries, &c = tables.crossings;
  for (std::size_t r = 0; r < b.size(); ++r)
    lines += fmt::format("{}, n = {}, damping ratio {}: {}\n", b.text(r, "scene"), b.number(r, "cells"),
                         b.number(r, "damping_ratio"),
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
  RegimesConfig config = regimes_config(options);
  if (options.processes > 1) config.reference_threads = 1;
  Journal journal = open_journal(options, configuration(config));
  RegimesTables tables = measure_regimes(config, std::max(1, options.processes), journal, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  result.summary = summary(tables);
  result.tables = regimes_files(std::move(tables));
  return result;
}

/// Errors of scenes without contact, which are the same on every machine.
Table baseline_table(const BaselineOptions& options, Progress& progress) {
  RegimesConfig config = regimes_config({.quick = true});
  config.grids = {{"held_box", options.quick ? 4 : 6, {0.05}, {1e5, 1e7, 1e9}}};
  config.repetitions = 1;
  config.most_seconds = 3600;  // nothing is stopped, on a busy machine neither
  config.most_over_best = 1e9;
  config.loaded.moduli.clear();
  Journal journal;
  return measure_regimes(config, 1, journal, progress)
      .runs.select({"young", "what", "method", "setting", "steps_or_tolerance", "error", "bounds", "status"});
}

}  // namespace

std::vector<NamedTable> regimes_files(RegimesTables tables) {
  return {{"regimes", std::move(tables.cheapest)},
          {"regimes_runs", std::move(tables.runs)},
          {"regimes_points", std::move(tables.points)},
          {"regimes_families", std::move(tables.families)},
          {"regimes_boundaries", std::move(tables.boundaries)},
          {"regimes_loaded", std::move(tables.loaded)},
          {"regimes_crossings", std::move(tables.crossings)}};
}

RegimesConfig regimes_config(const ExperimentOptions& options) {
  RegimesConfig config;
  const std::vector<double> moduli(bench_moduli.begin(), bench_moduli.end()),
      ratios(bench_ratios.begin(), bench_ratios.end());
  for (const BenchScene& scene : bench_scenes()) {
    const bool varies = scene.name == "held_box";  // its cells, and over a wider range
    std::vector<int> cells{options.quick ? scene.quick_cells : scene.cells};
    if (varies && !options.cells.empty()) cells = options.cells;
    for (const int n : cells) {
      RegimesGrid grid{scene.name, n, ratios, moduli};
      if (varies && !options.quick) grid.moduli = {1e4, 1e5, 1e6, 1e7, 1e8}, grid.halvings = 1;
      config.grids.push_back(std::move(grid));
    }
  }
  config.loaded.moduli = {1e5, 1e6, 1e7, 1e8, 1e9};
  if (options.quick) {
    config.repetitions = 2;
    config.most_seconds = 0.3;
    config.most_reference_seconds = 2;
    config.loaded.moduli = {1e6, 1e7, 1e8};
  }
  return config;
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
                       fmt::format("{}, ratio {}", point.scene, point.damping_ratio)});
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
  tables.families = tuned_families(tables.runs);
  tables.boundaries = boundaries(tables.points, tables.runs, tables.cheapest);
  tables.crossings = loaded_crossings(tables.loaded);
  return tables;
}

ExperimentInfo experiment() {
  return {.name = "regimes",
          .summary = "which method is cheapest where: over scenes, stiffness, damping and what is asked",
          .accepts = {.cells = true, .largest_cells = 40, .processes = true},
          .times = true,
          .run = run_regimes,
          .draw = draw_regimes,
          .baseline = {.keys = {"young", "what", "method", "setting", "steps_or_tolerance"},
                       .rules = {{.column = "error", .relative = 1e-3, .absolute = 1e-6, .failure = 10}},
                       .table = baseline_table}};
}

}  // namespace mss::studies::regimes

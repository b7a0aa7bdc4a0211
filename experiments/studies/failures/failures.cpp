// Where methods fail beyond what linear theory knows: cubes dropped, spun, torn, crushed, folded, nearly
// incompressible, with steps that jump; and random scenes at the safe step, where none should. Runs are in
// failures_runs.cpp.
#include "experiments/studies/failures/failures.hpp"

#include <fmt/format.h>

#include <map>

#include "experiments/harness/workers.hpp"
#include "experiments/simulation/model.hpp"

namespace mss::studies::failures {

namespace {

constexpr const char* caption =
    "A cube of 1 m, 3 x 3 x 3 cells, E = 1 MPa, nu = 0.3, t = 0.5, damping 0.1 of every spring's "
    "critical, is followed for twenty times as long as sound takes there and back. Methods with a "
    "largest step take 0.9 of the one they are sure of (explicit Euler of the predicted one), the "
    "others ten times symplectic Euler's, or are asked for such intervals. Drops begin at the ground "
    "with the speed of a fall from that height, without gravity; spins count in 2 c / L, c the speed "
    "of sound; merged: so many particles of an edge are put where its first is; dt jumps: every other "
    "step is so much shorter. Folds: a corner of a cell is inside out at the end. Blows up: ten times "
    "the energy at the beginning. Of each pair of bars the lower one is with the guard against "
    "folding, at the step that holds where such a guard acts everywhere (explicit Euler at its own). "
    "Random scenes: bodies of "
    "up to 5 x 5 x 5 cells with gaps, E 1 kPa to 1 GPa, nu 0 to 0.45, t 0.25 to 1, damping 0.01 to 1, "
    "stretched by up to 5 percent along each axis and rattled, "
    "half of them above a plane, three in ten held; 2000 steps, without explicit Euler, of which no "
    "step is sure. The step is meant for bodies that touch nothing: impacts add energy, with "
    "velocity_verlet above all. Weights are carried by half of a cube, stretched across.";

std::string name_of(const FailureScene& scene, double severity, bool guarded, const std::string& integrator) {
  return fmt::format("{} {:g}{}, {}", scene.name, severity, guarded ? ", guarded" : "", integrator);
}
std::string name_of(std::uint64_t seed) { return fmt::format("random {}", seed); }

Hardship hardship_of(const FailureScene& scene, double severity, bool guarded) {
  Hardship hardship = at_ease();
  scene.set(hardship, severity);
  if (guarded) hardship.body.fold_guard = usual_fold_guard;
  return hardship;
}

Json to_json(const FailureRun& run) {
  return {{"fate", int(run.fate)},
          {"dt", run.dt},
          {"seconds", run.seconds},
          {"most_energy", run.watch.most_energy / run.watch.energy_before},
          {"min_jacobian", run.watch.last_jacobian}};
}

std::vector<Case> cases_of(const FailureConfig& config) {
  std::vector<Case> cases;
  for (const FailureScene& scene : config.scenes)
    for (const double severity : scene.severities)
      for (const bool guarded : {false, true})
        for (const std::string& integrator : config.integrators)
          cases.push_back(
              {name_of(scene, severity, guarded, integrator), [&scene, severity, guarded, &integrator] {
                 return to_json(
                     try_scene(hardship_of(scene, severity, guarded), find_integrator(integrator)));
               }});
  for (int i = 0; i < config.random_scenes; ++i)
    cases.push_back({name_of(config.seed + std::uint64_t(i)), [seed = config.seed + std::uint64_t(i)] {
                       return to_json(try_scene(random_scene(seed)));
                     }});
  return cases;
}

/// What rows of both tables end with.
void add_answer(const Json& a, std::vector<Cell> row, Table& table) {
  for (const char* column : {"dt", "seconds", "most_energy", "min_jacobian"})
    row.emplace_back(number(a[column]));
  row.emplace_back(std::string(to_string(Fate(a["fate"].get<int>()))));
  table.add(std::move(row));
}

std::vector<Column> with_answer(std::vector<Column> columns) {
  for (const Column& column : {Column{"dt", "s"}, Column{"seconds", "s"}, Column{"most_energy"},
                               Column{"min_jacobian"}, Column{"status"}})
    columns.push_back(column);
  return columns;
}

FailureTables tables_of(const FailureConfig& config, const Journal& journal) {
  FailureTables tables{
      .rows = Table(with_answer({{"scene"}, {"severity"}, {"guarded"}, {"integrator"}})),
      .random =
          Table(with_answer({{"seed"}, {"integrator"}, {"planes"}, {"cells"}, {"ratio"}, {"poisson"}}))};
  for (const FailureScene& scene : config.scenes)
    for (const double severity : scene.severities)
      for (const bool guarded : {false, true})
        for (const std::string& integrator : config.integrators)
          if (const Json* a = journal.find(name_of(scene, severity, guarded, integrator)))
            add_answer(*a, {scene.name, severity, guarded ? 1 : 0, integrator}, tables.rows);
  for (int i = 0; i < config.random_scenes; ++i) {
    const std::uint64_t seed = config.seed + std::uint64_t(i);
    if (const Json* a = journal.find(name_of(seed))) {
      const RandomScene scene = random_scene(seed);
      add_answer(
          *a,
          {std::int64_t(seed), scene.integrator, std::int64_t(scene.environment.planes.size()),
           std::int64_t(scene.body.voxels.count()), scene.body.damping.zeta, scene.body.elastic->poisson},
          tables.random);
    }
  }
  return tables;
}

MapPanel panel_of(const FailureConfig& config, const FailureScene& scene, const Journal& journal) {
  constexpr double gap = 0.06;
  const double rows = double(config.integrators.size());
  MapPanel panel{.title = scene.label,
                 .x = ChartAxis{.label = "", .low = -0.5, .high = double(scene.severities.size()) - 0.5}};
  for (std::size_t s = 0; s < scene.severities.size(); ++s) {
    const double x = double(s);
    panel.x->ticks.push_back(x);
    panel.x->names.push_back(short_number(scene.severities[s]));
    for (std::size_t i = 0; i < config.integrators.size(); ++i)
      for (const bool guarded : {false, true})
        if (const Json* a =
                journal.find(name_of(scene, scene.severities[s], guarded, config.integrators[i]))) {
          const double y = rows - double(i);
          panel.cells.push_back({x - 0.5 + gap, x + 0.5 - gap, guarded ? y - 0.44 : y, guarded ? y : y + 0.44,
                                 (*a)["fate"].get<int>()});
        }
  }
  return panel;
}

MapChart map_of(const FailureConfig& config, const Journal& journal) {
  MapChart chart{
      .title = "Where methods fail",
      .subtitle =
          "each at a step it is sure of, or ten times that; upper half of a bar: plain, lower half: "
          "guarded against folding",
      .x = {.label = ""},
      .y = named_rows(config.integrators),
      .kinds = fate_names(),
      .panel_height = 400};
  for (const FailureScene& scene : config.scenes) chart.panels.push_back(panel_of(config, scene, journal));
  return chart;
}

std::string summary(const FailureTables& tables) {
  std::map<std::string, std::map<bool, std::pair<int, int>>> held;  // by scene and guard, of how many
  for (std::size_t r = 0; r < tables.rows.size(); ++r) {
    auto& [holding, all] = held[tables.rows.text(r, "scene")][tables.rows.number(r, "guarded") != 0];
    holding += tables.rows.text(r, "status") == "holds" ? 1 : 0;
    ++all;
  }
  std::string lines;
  for (const std::string& scene : tables.rows.distinct("scene"))
    lines += fmt::format("{:<16} {:3} of {} runs hold, guarded {:3} of {}\n", scene, held[scene][false].first,
                         held[scene][false].second, held[scene][true].first, held[scene][true].second);
  for (const bool plane : {false, true}) {
    int failed = 0, all = 0;
    for (std::size_t r = 0; r < tables.random.size(); ++r) {
      if ((tables.random.number(r, "planes") != 0) != plane) continue;
      failed += tables.random.text(r, "status") == "holds" ? 0 : 1;
      ++all;
    }
    if (all > 0)  // else interrupted before
      lines += fmt::format("random scenes at the safe step, {}: {} of {} fail\n",
                           plane ? "above a plane" : "free or held", failed, all);
  }
  return lines;
}

Json configuration(const FailureConfig& c) {
  Json scenes = Json::array();
  for (const FailureScene& scene : c.scenes)
    scenes.push_back({{"name", scene.name}, {"severities", scene.severities}});
  return {{"scenes", scenes},
          {"fold_guard", usual_fold_guard},
          {"integrators", c.integrators},
          {"random_scenes", c.random_scenes},
          {"seed", c.seed}};
}

ExperimentResult run_failures(const ExperimentOptions& options, Progress& progress) {
  const FailureConfig config = failure_config(options);
  Journal journal = open_journal(options, configuration(config));
  FailureTables tables = measure_failures(config, options.processes, journal, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  result.maps = {{"failures", map_of(config, journal)}};
  result.summary = summary(tables);
  result.tables = {{"failures", std::move(tables.rows)}, {"failures_random", std::move(tables.random)}};
  return result;
}

/// The step that is called safe is.
Table baseline_table(const BaselineOptions& options, Progress& progress) {
  FailureConfig config = failure_config({.quick = options.quick});
  config.scenes.clear();
  config.random_scenes = options.quick ? 100 : 400;
  Journal journal;
  return measure_failures(config, 1, journal, progress)
      .random.select({"seed", "integrator", "cells", "dt", "status"});
}

}  // namespace

FailureTables measure_failures(const FailureConfig& config, int processes, Journal& journal,
                               Progress& progress) {
  const bool done = find_answers(cases_of(config), processes, journal, progress);
  FailureTables tables = tables_of(config, journal);
  if (!done) tables.status = Status::interrupted;
  return tables;
}

FailureConfig failure_config(const ExperimentOptions& options) {
  FailureConfig config{.scenes = failure_scenes(),
                       .integrators = moving_integrators(options.integrators),
                       .random_scenes = options.quick ? 200 : 2100,
                       .seed = options.seed};
  if (options.quick)
    for (FailureScene& scene : config.scenes)
      scene.severities = {scene.severities.front(), scene.severities.back()};
  return config;
}

ExperimentInfo experiment() {
  return {.name = "failures",
          .under = "stability",
          .summary =
              "cubes dropped, spun, torn, crushed and folded, per integrator; random scenes at the safe step",
          .accepts = {.integrators = moving_integrators, .seed = true, .processes = true},
          .run = run_failures,
          .baseline = {.keys = {"seed"}, .rules = {{"dt", 1e-9}}, .table = baseline_table}};
}

}  // namespace mss::studies::failures

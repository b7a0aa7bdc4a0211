// Where methods fail beyond what linear theory predicts: cubes dropped, spun, stretched, compressed, folded,
// nearly incompressible, with steps that vary; and random scenes at the safe step, where none should fail.
#include "experiments/studies/failures/failures.hpp"

#include <fmt/format.h>

#include <map>
#include <utility>

#include "experiments/harness/workers.hpp"
#include "experiments/simulation/model.hpp"

namespace mss::studies::failures {

namespace {

constexpr const char* caption =
    "A cube of 1 m, 3 x 3 x 3 cells, E = 1 MPa, nu = 0.3, face share t = 0.5, damping ratio 0.1 of every "
    "spring, is simulated for twenty times as long as sound takes through it and back. Methods with a "
    "guaranteed step take 0.9 of it (explicit Euler, which has none, 0.9 of the predicted one), the others "
    "ten times the safe step of semi_implicit_euler, or intervals of that length if they choose their own "
    "steps. Drops begin at the ground with the speed of a fall from the height given, without gravity; spin "
    "is in units of 2 c / L, c the speed of sound, L the edge; merged: so many particles of an edge are "
    "placed where its first one is; step ratio: every other step is shorter by it; cubes with a mass ratio "
    "or "
    "a step ratio are stretched to 1.3 m. Folds: a corner of a cell is inverted at the end. Blows up: ten "
    "times the initial energy. Refused: the method has no step for such a body, as xpbd and vbd for a fold "
    "guard or a negative volume stiffness. Lower halves of bars: with the fold guard, at the step that is "
    "safe if the "
    "guard acts "
    "everywhere (explicit Euler at the same step as without). Random scenes: bodies of up to 5 x 5 x 5 "
    "cells with gaps, E 1 kPa to 1 GPa, nu 0 to 0.45, t 0.25 to 1, damping ratio 0.01 to 1, stretched by up "
    "to 5 percent along each axis, with random velocities, half of them above a plane, three in ten held; "
    "2000 steps; explicit Euler is left out, because no step of it is guaranteed. The safe step is meant for "
    "bodies without contact: impacts add energy, most of all with velocity_verlet.";

std::string name_of(const FailureScene& scene, double severity, bool guarded, const std::string& integrator) {
  return fmt::format("{} {:g}{}, {}", scene.name, severity, guarded ? ", guarded" : "", integrator);
}
std::string name_of(std::uint64_t seed) { return fmt::format("random {}", seed); }

StressCase stress_case_of(const FailureScene& scene, double severity, bool guarded) {
  StressCase stress_case = unloaded_cube();
  scene.set(stress_case, severity);
  if (guarded) stress_case.body.fold_guard = default_fold_guard;
  return stress_case;
}

Json to_json(const FailureRun& run) {
  return {{"outcome", int(run.outcome)},
          {"dt", run.dt},
          {"seconds", run.seconds},
          {"max_energy", run.extremes.max_energy / run.extremes.initial_energy},
          {"min_jacobian", run.extremes.final_jacobian}};
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
                     try_scene(stress_case_of(scene, severity, guarded), find_integrator(integrator)));
               }});
  for (int i = 0; i < config.random_scenes; ++i)
    cases.push_back({name_of(config.seed + std::uint64_t(i)), [seed = config.seed + std::uint64_t(i)] {
                       return to_json(try_scene(random_scene(seed)));
                     }});
  return cases;
}

/// Appends a row that ends with the result of a run.
void add_run(const Json& run, std::vector<Cell> row, Table& table) {
  for (const char* column : {"dt", "seconds", "max_energy", "min_jacobian"})
    row.emplace_back(number(run[column]));
  row.emplace_back(std::string(to_string(Outcome(run["outcome"].get<int>()))));
  table.add(std::move(row));
}

std::vector<Column> with_run(std::vector<Column> columns) {
  for (const Column& column : {Column{"dt", "s"}, Column{"seconds", "s"}, Column{"max_energy"},
                               Column{"min_jacobian"}, Column{"status"}})
    columns.push_back(column);
  return columns;
}

FailureTables tables_of(const FailureConfig& config, const Journal& journal) {
  FailureTables tables{
      .rows = Table(with_run({{"scene"}, {"severity"}, {"guarded"}, {"integrator"}})),
      .random = Table(with_run({{"seed"}, {"integrator"}, {"planes"}, {"cells"}, {"ratio"}, {"poisson"}})),
      .scenes = Table({{"scene"}, {"label"}})};
  for (const FailureScene& scene : config.scenes) tables.scenes.add({scene.name, scene.label});
  for (const FailureScene& scene : config.scenes)
    for (const double severity : scene.severities)
      for (const bool guarded : {false, true})
        for (const std::string& integrator : config.integrators)
          if (const Json* run = journal.find(name_of(scene, severity, guarded, integrator)))
            add_run(*run, {scene.name, severity, guarded ? 1 : 0, integrator}, tables.rows);
  for (int i = 0; i < config.random_scenes; ++i) {
    const std::uint64_t seed = config.seed + std::uint64_t(i);
    if (const Json* run = journal.find(name_of(seed))) {
      const RandomScene scene = random_scene(seed);
      add_run(*run,
              {std::int64_t(seed), scene.integrator, std::int64_t(scene.environment.planes.size()),
               std::int64_t(scene.body.voxels.count()), scene.body.damping.zeta, scene.body.elastic->poisson},
              tables.random);
    }
  }
  return tables;
}

/// How many of the rows are stable, and of how many.
std::pair<std::size_t, std::size_t> stable_of(const Table& rows) {
  return {rows.where("status", to_string(Outcome::stable)).size(), rows.size()};
}

std::string summary(const FailureTables& tables) {
  std::string lines;
  for (const std::string& scene : tables.rows.distinct("scene")) {
    const Table of_scene = tables.rows.where("scene", scene);
    const auto [unguarded, all_unguarded] = stable_of(of_scene.where("guarded", 0.0));
    const auto [guarded, all_guarded] = stable_of(of_scene.where("guarded", 1.0));
    lines += fmt::format("{:<16} {:3} of {} runs stable, with fold guard {:3} of {}\n", scene, unguarded,
                         all_unguarded, guarded, all_guarded);
  }
  std::map<bool, std::pair<int, int>> failed;  // with a plane: of how many
  for (std::size_t r = 0; r < tables.random.size(); ++r) {
    auto& [failures, all] = failed[tables.random.number(r, "planes") != 0];
    failures += tables.random.text(r, "status") == to_string(Outcome::stable) ? 0 : 1;
    ++all;
  }
  for (const auto& [plane, count] : failed)
    lines += fmt::format("random scenes at the safe step, {}: {} of {} fail\n",
                         plane ? "above a plane" : "free or held", count.first, count.second);
  return lines;
}

Json configuration(const FailureConfig& c) {
  Json scenes = Json::array();
  for (const FailureScene& scene : c.scenes)
    scenes.push_back({{"name", scene.name}, {"severities", scene.severities}});
  return {{"scenes", scenes},
          {"fold_guard", default_fold_guard},
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
  result.summary = summary(tables);
  result.tables = failure_files(std::move(tables));
  return result;
}

/// Random scenes at the safe step: all must be stable.
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
  const bool done = compute_cases(cases_of(config), processes, journal, progress);
  FailureTables tables = tables_of(config, journal);
  if (!done) tables.status = Status::interrupted;
  return tables;
}

std::vector<NamedTable> failure_files(FailureTables tables) {
  return {{"failures", std::move(tables.rows)},
          {"failures_random", std::move(tables.random)},
          {"failures_scenes", std::move(tables.scenes)}};
}

FailureConfig failure_config(const ExperimentOptions& options) {
  FailureConfig config{.scenes = failure_scenes(),
                       .integrators = moving_families(options.integrators),
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
          .summary = "cubes dropped, spun, stretched, compressed and folded; random scenes at the safe step",
          .accepts = {.integrators = moving_families, .seed = true, .processes = true},
          .run = run_failures,
          .draw = draw_failures,
          .baseline = {.keys = {"seed"}, .rules = {{"dt", 1e-9}}, .table = baseline_table}};
}

}  // namespace mss::studies::failures

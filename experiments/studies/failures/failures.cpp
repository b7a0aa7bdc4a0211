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
    "guaranteed step take 0.9 of it (explicit Euler, which has none, 0.9 of the predicted one, or without "
    "damping the safe step of semi_implicit_euler), the others ten times the safe step of "
    "semi_implicit_euler, or intervals of that length if they choose their own steps. Three kinds of runs: "
    "without fold guard; without, at the step of the body with it; with fold guard, at the step "
    "that is safe if the guard acts everywhere: a bar each for every severity, which counts methods by "
    "outcome. Drops begin at the ground "
    "with the speed of a fall from the height given, without gravity; spin is in units of 2 c / L, c the "
    "speed of sound, L the edge; merged: so many particles of an edge are placed where its first one is; "
    "step ratio: every other step is shorter by it; cubes with a mass ratio, another damping or a step "
    "ratio are stretched to 1.3 m. Nothing supplies energy. Gains energy: at some sample more than 5 "
    "percent above the initial one; blows up: ten times it; velocities that lag by half a step are advanced "
    "by it before energies are taken. Folds: a corner of a cell is inverted at the end. Behind the plane: a "
    "particle was, at some sample, by more than a millionth of a cell, or the centre of mass. Methods that "
    "take another one's steps, in other variables (verlet) or by another linear solver (cvode_bdf_klu, "
    "cvode_bdf_gmres), are run only if named, and not counted then (same_as); numbers of iterations are "
    "variants that are. arkode_dirk too is run only if named: it would take a third of the time of all. "
    "Refused: the method has no step for such a body, as xpbd and vbd for a fold guard or a negative "
    "volume stiffness. Random scenes: bodies of up to 5 x 5 x 5 cells with gaps, E 1 kPa to 1 GPa, nu 0 to "
    "0.45, t 0.25 to 1, damping ratio 0.01 to 1, stretched by up to 5 percent along each axis, with random "
    "velocities, half of them above a plane, three in ten held; 2000 steps; explicit Euler is left out, "
    "because no step of it is guaranteed. The safe step is meant for bodies without contact: impacts add "
    "energy, most of all with velocity_verlet.";

/// A run that is a row of the table.
struct StressRun {
  const FailureScene& scene;
  double severity;
  Variant variant;
  const std::string& integrator;

  std::string name() const {
    return fmt::format("{} {:g}{}{}, {}", scene.name, severity, variant.guarded ? ", guarded" : "",
                       variant.guarded_step ? ", guarded step" : "", integrator);
  }
};
std::string name_of(std::uint64_t seed) { return fmt::format("random {}", seed); }

/// In the table's order.
std::vector<StressRun> stress_runs(const FailureConfig& config) {
  std::vector<StressRun> runs;
  for (const FailureScene& scene : config.scenes)
    for (const double severity : scene.severities)
      for (const Variant variant : variants)
        for (const std::string& integrator : config.integrators)
          runs.push_back({scene, severity, variant, integrator});
  return runs;
}

Json to_json(const FailureRun& run) {
  return {{"status", run.status()},
          {"dt", run.dt},
          {"seconds", run.seconds},
          {"max_energy", run.extremes.max_energy / run.extremes.initial_energy},
          {"min_jacobian", run.extremes.min_jacobian},
          {"final_jacobian", run.extremes.final_jacobian},
          {"touched", run.touched},
          {"depth", run.depth},
          {"height", run.height}};
}

Json compute(const StressRun& run) {
  StressCase stress_case = unloaded_cube();
  run.scene.set(stress_case, run.severity);
  return to_json(try_scene(stress_case, find_integrator(run.integrator), run.variant));
}

std::vector<Case> cases_of(const FailureConfig& config) {
  std::vector<Case> cases;
  for (const StressRun& run : stress_runs(config))
    cases.push_back({run.name(), [run] { return compute(run); }});
  for (int i = 0; i < config.random_scenes; ++i)
    cases.push_back({name_of(config.seed + std::uint64_t(i)), [seed = config.seed + std::uint64_t(i)] {
                       return to_json(try_scene(random_scene(seed)));
                     }});
  for (Case& one : cases) one.group = one.name;
  return cases;
}

/// Appends a row that ends with the result of a run.
void add_run(const Json& run, std::vector<Cell> row, Table& table) {
  for (const char* column :
       {"dt", "seconds", "max_energy", "min_jacobian", "final_jacobian", "touched", "depth", "height"})
    row.emplace_back(number(run[column]));
  row.emplace_back(run["status"].get<std::string>());
  table.add(std::move(row));
}

std::vector<Column> with_run(std::vector<Column> columns) {
  for (const Column& column : {Column{"dt", "s"}, Column{"seconds", "s"}, Column{"max_energy"},
                               Column{"min_jacobian"}, Column{"final_jacobian"}, Column{"touched"},
                               Column{"depth", "m"}, Column{"height", "m"}, Column{"status"}})
    columns.push_back(column);
  return columns;
}

FailureTables tables_of(const FailureConfig& config, const Journal& journal) {
  FailureTables tables{
      .rows = Table(
          with_run({{"scene"}, {"severity"}, {"guarded"}, {"guarded_step"}, {"integrator"}, {"same_as"}})),
      .random = Table(with_run({{"seed"}, {"integrator"}, {"planes"}, {"cells"}, {"ratio"}, {"poisson"}})),
      .scenes = Table({{"scene"}, {"label"}})};
  for (const FailureScene& scene : config.scenes) tables.scenes.add({scene.name, scene.label});
  for (const StressRun& run : stress_runs(config))
    if (const Json* found = journal.find(run.name()))
      add_run(*found,
              {run.scene.name, run.severity, run.variant.guarded ? 1 : 0, run.variant.guarded_step ? 1 : 0,
               run.integrator, find_integrator(run.integrator).variant_of},
              tables.rows);
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

/// How many of the rows are stable.
std::size_t stable_of(const Table& rows) { return rows.where("status", to_string(Outcome::stable)).size(); }

std::string summary(const FailureTables& tables) {
  std::string lines;
  for (const std::string& scene : tables.rows.distinct("scene")) {
    const Table of_scene = tables.rows.where("scene", scene).where("same_as", "");
    const auto of_variant = [&](Variant variant) {
      return of_scene.where("guarded", variant.guarded ? 1.0 : 0.0)
          .where("guarded_step", variant.guarded_step ? 1.0 : 0.0);
    };
    lines += fmt::format(
        "{:<16} of {:3} runs {:3} are stable, {:3} at the step of the guarded body, {:3} with fold guard\n",
        scene, of_variant(variants[0]).size(), stable_of(of_variant(variants[0])),
        stable_of(of_variant(variants[1])), stable_of(of_variant(variants[2])));
  }
  std::map<bool, std::pair<int, int>> failed;  // on a plane: of how many
  for (std::size_t r = 0; r < tables.random.size(); ++r) {
    auto& [failures, all] = failed[tables.random.number(r, "touched") == 1];
    failures += tables.random.text(r, "status") == to_string(Outcome::stable) ? 0 : 1;
    ++all;
  }
  for (const auto& [plane, count] : failed)
    lines += fmt::format("random scenes at the safe step, {}: {} of {} fail\n",
                         plane ? "that touch a plane" : "that touch none", count.first, count.second);
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

bool runs_only_if_named(const std::string& integrator) {
  return integrator == "arkode_dirk" || !find_integrator(integrator).variant_of.empty();
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
  const bool done = compute_cases(own_cases(cases_of(config), journal), processes, journal, progress);
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
  FailureConfig config{
      .scenes = failure_scenes(), .integrators = moving_families(options.integrators), .seed = options.seed};
  if (options.integrators.empty()) std::erase_if(config.integrators, runs_only_if_named);
  if (!options.quick) return config;
  config.random_scenes = 50;
  if (options.integrators.empty())
    config.integrators = {"explicit_euler",
                          "semi_implicit_euler",
                          "velocity_verlet",
                          "rk4",
                          "backward_euler",
                          "backward_euler_linear",
                          "xpbd",
                          "vbd:5"};
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

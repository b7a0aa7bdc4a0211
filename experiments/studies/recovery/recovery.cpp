// Which cubes recover their shape, and from which states: the thesis's springs, calibrated springs with and
// without the fold guard, finite elements.
#include "experiments/studies/recovery/recovery.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/model.hpp"

namespace mss::studies::recovery {

namespace {

constexpr const char* caption =
    "Cubes of 3 x 3 x 3 cells are put into states that may trap them and released: mirrored, the upper layer "
    "folded down, a corner, an edge, a face or the four inner particles of the top pushed in by 1, 1.5 or "
    "2.5 "
    "cells, flat (1 percent of the height, with random displacements as large), shrunk to a thousandth, "
    "random. Seeds differ by random displacements of a thousandth of a cell; shrunk states are shrunk with "
    "random displacements of a cell, random states have random places. The damping ratio of every spring is "
    "0.05, the step a tenth of the stable one at rest. Recovered: no spring longer or shorter by more than "
    "1e-6, and no cell inverted. Fold guard: corners of which a principal stretch falls below 0.7 are pushed "
    "apart, k_g = 20 shear moduli. Landings: at the speed given, onto a plane with restitution 0.5, then "
    "free. "
    "Stiffer lattices, other shapes and larger bodies are not covered.";

Json configuration(const RecoveryConfig& c) {
  Json models = Json::array();
  for (const RecoveryModel& m : c.models)
    models.push_back(
        {{"name", m.name},
         {"seeds", m.seeds},
         {"model", m.stiffness == Stiffness::corotational_elements ? "corotational" : spring_model},
         {"fold_guard", m.body.fold_guard},
         {"damping_ratio", m.body.damping.zeta},
         {"cell_size", m.body.cell_size},
         {"density", m.body.density},
         {"springs",
          {m.body.springs.edge, m.body.springs.face, m.body.springs.body, m.body.springs.volume}}});
  Json states = Json::array();
  for (const TrappedState& state : c.states) states.push_back(to_string(state));
  return {{"body", "cube of 3 x 3 x 3 cells"},
          {"models", models},
          {"states", states},
          {"seed", c.seed},
          {"landing_speeds", c.landing_speeds}};
}

std::string summary(const Table& rows) {
  std::string lines;
  for (const std::string& model : rows.distinct("model")) {
    const double share = recovered_share(rows.where("model", model));
    lines += fmt::format("{:<40} {:6.1f} % recover\n", model, 100 * share);
  }
  return lines;
}

ExperimentResult run_recovery(const ExperimentOptions& options, Progress& progress) {
  const RecoveryConfig config = recovery_config(options);
  Journal journal = open_journal(options, configuration(config));
  Table costs = measure_costs(config, progress);
  RecoveryTables tables = measure_recovery(config, options.processes, journal, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  result.summary = summary(tables.rows);
  result.tables = recovery_files(std::move(tables), std::move(costs));
  return result;
}

/// Models that the fold guard is meant for, in states where rounding does not change the outcome.
/// What must happen by symmetry. The energy of springs without a volume force (nu = 1/4) depends on lengths
/// alone, so the mirror image of the body is as strict a minimum as the body, and so is the body turned: from
/// near one of them, with less energy than any way out of it needs, a damped body comes to rest there.
RecoveryConfig symmetric_config() {
  RecoveryConfig config = recovery_config({.quick = true});
  std::erase_if(config.models, [](const RecoveryModel& m) {
    return m.guarded() || m.stiffness != Stiffness::calibrated_springs || m.poisson != 0.25 ||
           m.face_share == 0;
  });
  std::erase_if(config.states, [](const TrappedState& state) { return state.name != "mirrored"; });
  config.states.push_back(turned_state());
  config.landing_speeds.clear();
  for (RecoveryModel& model : config.models) model.seeds = 1;
  return config;
}

Table baseline_table(const BaselineOptions& options, Progress& progress) {
  RecoveryConfig config = recovery_config({.quick = true});
  std::erase_if(config.models, [](const RecoveryModel& m) { return !m.guarded() || m.face_share == 0; });
  std::erase_if(config.states,
                [](const TrappedState& state) { return state.amount < 1 || state.amount > 2; });
  config.landing_speeds.clear();
  for (RecoveryModel& model : config.models) model.seeds = options.quick ? 1 : 5;
  Table table({{"model"}, {"state"}, {"trials"}, {"recovered"}, {"status"}});
  for (const RecoveryConfig& each : {symmetric_config(), config}) {
    Journal journal;
    const Table rows = measure_recovery(each, 1, journal, progress)
                           .rows.select({"model", "state", "trials", "recovered", "status"});
    for (const std::vector<Cell>& row : rows.rows()) table.add(row);
  }
  return table;
}

BodyConfig cube(double damping) {
  return {.voxels = VoxelGrid::box(recovery_cells, recovery_cells, recovery_cells),
          .cell_size = 0.2,
          .damping = {.law = Damping::Law::ratio, .zeta = damping}};
}

RecoveryModel thesis_model() {
  RecoveryModel model{.name = "thesis", .unguarded = "thesis", .body = cube(0.05), .lands = true};
  model.body.sharing = Sharing::uniform;
  model.body.density = 1;
  model.body.springs = thesis_springs;
  return model;
}

RecoveryModel material_model(Stiffness stiffness, const std::string& name, double poisson,
                             double face_share) {
  const std::string full_name = fmt::format("{}, nu = {:g}", name, poisson);
  RecoveryModel model{.name = full_name,
                      .unguarded = full_name,
                      .stiffness = stiffness,
                      .body = cube(0.05),
                      .face_share = face_share,
                      .poisson = poisson};
  model.body.fill({.young = 1e6, .poisson = poisson}, face_share);
  return model;
}

RecoveryModel with_guard(RecoveryModel model) {
  model.body.fold_guard = default_fold_guard;
  model.name += ", guarded";
  return model;
}

}  // namespace

RecoveryConfig recovery_config(const ExperimentOptions& options) {
  RecoveryConfig config{.models = {thesis_model(), with_guard(thesis_model())},
                        .states = trapped_states(),
                        .seed = options.seed};
  for (const double t : {0.0, 0.5, 1.0})
    for (const double poisson : {0.25, 0.4, 0.45}) {
      RecoveryModel model =
          material_model(Stiffness::calibrated_springs, fmt::format("springs, t = {:g}", t), poisson, t);
      model.lands = t > 0 && poisson == 0.25;
      config.models.push_back(model);
      config.models.push_back(with_guard(model));
    }
  // The guard is meant for t = 0.5 and 1: a hundred trials each. Elements take a hundred times as long.
  for (RecoveryModel& model : config.models)
    model.seeds = options.quick ? 1 : model.guarded() && model.face_share > 0 ? 6 : 4;
  constexpr int seeds_of_elements = 1;
  for (const double poisson : {0.25, 0.45}) {
    if (options.quick) break;
    config.models.push_back(
        material_model(Stiffness::corotational_elements, "corotational elements", poisson, 0.5));
    config.models.back().seeds = seeds_of_elements;
  }
  for (double speed = 5; speed <= 500; speed *= options.quick ? 1.5 : 1.25)
    config.landing_speeds.push_back(speed);
  return config;
}

ExperimentInfo experiment() {
  return {
      .name = "recovery",
      .summary =
          "how often and how fast bodies recover from folded, shrunk and mirrored states, with and without "
          "the fold guard",
      .accepts = {.seed = true, .processes = true},
      .run = run_recovery,
      .draw = draw_recovery,
      .baseline = {.keys = {"model", "state"},
                   .rules = {{"trials", 1e-12}, {"recovered", 1e-12}},
                   .table = baseline_table}};
}

}  // namespace mss::studies::recovery

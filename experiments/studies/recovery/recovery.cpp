// Which cubes find back to their shape, from how bad a state: the thesis's constants, calibrated springs with
// and without the guard against folding, finite elements. The zoo is recovery_zoo.cpp, runs are
// recovery_runs.cpp.
#include "experiments/studies/recovery/recovery.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/model.hpp"

namespace mss::studies::recovery {

namespace {

constexpr const char* guarded_suffix = ", guarded";

constexpr const char* caption =
    "Cubes of 3 x 3 x 3 cells are put into states that trap lattices and let go: mirrored, the upper "
    "layer folded down, a corner, an edge, a face or the four inner particles of the top pushed in by "
    "1, 1.5 or 2.5 cells, flat (1 percent, and rough by as much of a cell), crushed to a thousandth, "
    "random. Seeds differ by a shake of a thousandth of a cell; crushed and random states are "
    "different altogether. Springs' damping is 0.05 of critical, the step a tenth of the largest at rest. "
    "Recovered: no spring longer or shorter by more than 1e-6, and no cell inside out. Guarded: "
    "corners of which a principal stretch falls below 0.7 are pushed apart, k_g = 20 shear "
    "moduli. Landings: at the speed named, onto a plane with restitution 0.5, then free. Stiffer "
    "lattices, other shapes and larger bodies are left out.";

Json configuration(const RecoveryConfig& c) {
  Json models = Json::array();
  for (const RecoveryModel& m : c.models)
    models.push_back(
        {{"name", m.name},
         {"seeds", m.seeds},
         {"model", m.model},
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

ChartAxis share_axis() { return {.label = "share that recovered", .low = -0.03, .high = 1.03}; }

/// Mean rate of the rows chosen; NaN if there are none.
template <class Chosen>
double mean_rate(const Table& rows, Chosen&& chosen) {
  double recovered = 0, trials = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (!chosen(r)) continue;
    recovered += rows.number(r, "recovered");
    trials += rows.number(r, "trials");
  }
  return recovered / trials;
}

Chart models_chart(const Table& rows, const RecoveryConfig& config) {
  std::vector<std::string> names;
  for (const RecoveryModel& model : config.models)
    if (!model.guarded) names.push_back(model.name);
  const auto [fewest, most] =
      std::minmax_element(config.models.begin(), config.models.end(),
                          [](const RecoveryModel& a, const RecoveryModel& b) { return a.seeds < b.seeds; });
  const std::string seeds = fewest->seeds == most->seeds
                                ? std::to_string(most->seeds)
                                : fmt::format("{} to {}", fewest->seeds, most->seeds);
  Chart chart{
      .title = "Which fillings find back to their shape",
      .subtitle = fmt::format("cube of 3 x 3 x 3 cells, let go from {} trapped states; seeds of each: {}",
                              config.states.size(), seeds),
      .x = share_axis(),
      .y = named_rows(names)};
  for (const bool guarded : {false, true}) {
    ChartSeries series{.label = guarded ? "with the guard against folding" : "without",
                       .style = guarded ? 9 : 0,
                       .joined = false};
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string name = names[i] + (guarded ? guarded_suffix : "");
      series.points.push_back(
          {mean_rate(rows, [&](std::size_t r) { return rows.text(r, "model") == name; }), chart.y.ticks[i]});
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

/// A column of the map of states: a filling, with and without its guard, as t over nu.
std::string short_name(const RecoveryModel& model) {
  if (model.poisson == 0) return "thesis";
  const bool springs = model.model == spring_model;
  return (springs ? short_number(model.face_share) : "FEM") + "\n" + short_number(model.poisson);
}

/// How a rate is drawn: index into the map's kinds.
int kind_of(double rate) { return rate == 1 ? 0 : rate > 0.5 ? 1 : rate > 0 ? 2 : 3; }

MapPanel states_panel(const Table& rows, const RecoveryConfig& config, bool guarded) {
  MapPanel panel{.title = guarded ? "guarded against folding; t over nu" : "plain; t over nu"};
  ChartAxis x{.label = "", .low = 0.4};
  const double states = double(config.states.size());
  for (const RecoveryModel& model : config.models) {
    if (model.guarded != guarded) continue;
    const double column = double(x.ticks.size()) + 1;
    x.ticks.push_back(column);
    x.names.push_back(short_name(model));
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (rows.text(r, "model") != model.name) continue;
      const auto state = std::find_if(config.states.begin(), config.states.end(), [&](const TrappedState& s) {
        return to_string(s) == rows.text(r, "state");
      });
      const double y = states - double(state - config.states.begin());
      panel.cells.push_back(
          {column - 0.45, column + 0.45, y - 0.4, y + 0.4, kind_of(rows.number(r, "rate"))});
    }
  }
  x.high = double(x.ticks.size()) + 0.6;
  panel.x = x;
  return panel;
}

MapChart states_map(const Table& rows, const RecoveryConfig& config) {
  std::vector<std::string> names;
  for (const TrappedState& state : config.states) names.push_back(to_string(state));
  return {.title = "Which states trap which filling",
          .subtitle = "share of seeds that find back to their shape; numbers behind states are cells",
          .x = {.label = ""},
          .y = named_rows(names),
          .kinds = {"all recover", "more than half", "half or less", "none"},
          .panels = {states_panel(rows, config, false), states_panel(rows, config, true)},
          .panel_height = 640};
}

Chart landings_chart(const Table& rows, const RecoveryConfig& config) {
  std::vector<std::string> names;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.number(r, "guarded") == 0)
      names.push_back(rows.text(r, "model") + ", " + rows.text(r, "landing"));
  Chart chart{
      .title = "How hard a cube may land before it stays folded (Fig. 5-4)",
      .subtitle = fmt::format(
          "cube of 3 x 3 x 3 cells; tried from {:.3g} to {:.3g} m/s, each speed {:g} times the last",
          config.landing_speeds.front(), config.landing_speeds.back(),
          config.landing_speeds[1] / config.landing_speeds[0]),
      .x = {.label = "speed of landing [m/s]", .logarithmic = true, .ticks = {5, 10, 20, 50, 100, 200, 500}},
      .y = named_rows(names)};
  struct Kind {
    const char* label;
    int style;
    bool guarded, folds;
  };
  for (const Kind& kind : {Kind{"does not recover first at", 0, false, true},
                           Kind{"guarded: does not recover first at", 9, true, true},
                           Kind{"recovers from all tried, up to", 3, false, false},
                           Kind{"guarded: recovers from all tried, up to", 7, true, false}}) {
    ChartSeries series{.label = kind.label, .style = kind.style, .joined = false};
    for (std::size_t r = 0; r < rows.size(); ++r) {
      std::string model = rows.text(r, "model");
      if (const std::size_t suffix = model.find(guarded_suffix); suffix != std::string::npos)
        model.erase(suffix);
      const auto row = std::find(names.begin(), names.end(), model + ", " + rows.text(r, "landing"));
      const bool folds = std::isfinite(rows.number(r, "folds_at"));
      if ((rows.number(r, "guarded") != 0) != kind.guarded || folds != kind.folds || row == names.end())
        continue;
      series.points.push_back({rows.number(r, folds ? "folds_at" : "recovers_to"),
                               chart.y.ticks[std::size_t(row - names.begin())]});
    }
    if (!series.points.empty()) chart.series.push_back(std::move(series));
  }
  return chart;
}

std::string summary(const Table& rows) {
  std::string lines;
  for (const std::string& model : rows.distinct("model")) {
    const double rate = mean_rate(rows, [&](std::size_t r) { return rows.text(r, "model") == model; });
    lines += fmt::format("{:<40} {:6.1f} % recover\n", model, 100 * rate);
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
  result.charts = {{"recovery", models_chart(tables.rows, config)},
                   {"recovery_landing", landings_chart(tables.landings, config)}};
  result.maps = {{"recovery_states", states_map(tables.rows, config)}};
  result.summary = summary(tables.rows);
  result.tables = {{"recovery", std::move(tables.rows)},
                   {"recovery_landing", std::move(tables.landings)},
                   {"recovery_cost", std::move(costs)}};
  return result;
}

/// What the guard was made for, from states so far from any ridge that rounding decides nothing.
Table baseline_table(const BaselineOptions& options, Progress& progress) {
  RecoveryConfig config = recovery_config({.quick = true});
  std::erase_if(config.models, [](const RecoveryModel& m) { return !m.guarded || m.face_share == 0; });
  std::erase_if(config.states,
                [](const TrappedState& state) { return state.amount < 1 || state.amount > 2; });
  config.landing_speeds.clear();
  for (RecoveryModel& model : config.models) model.seeds = options.quick ? 1 : 5;
  Journal journal;
  return measure_recovery(config, 1, journal, progress)
      .rows.select({"model", "state", "trials", "recovered", "status"});
}

BodyConfig cube(double damping) {
  return {.voxels = VoxelGrid::box(recovery_cells, recovery_cells, recovery_cells),
          .cell_size = 0.2,
          .damping = {.law = Damping::Law::ratio, .zeta = damping}};
}

RecoveryModel thesis_model() {
  RecoveryModel model{.name = "thesis", .model = spring_model, .body = cube(0.05), .lands = true};
  model.body.sharing = Sharing::uniform;
  model.body.density = 1;
  model.body.springs = thesis_springs;
  return model;
}

RecoveryModel material_model(const std::string& name, const std::string& filling, double poisson,
                             double face_share) {
  RecoveryModel model{.name = fmt::format("{}, nu = {:g}", name, poisson),
                      .model = filling,
                      .body = cube(0.05),
                      .face_share = face_share,
                      .poisson = poisson};
  model.body.fill({.young = 1e6, .poisson = poisson}, face_share);
  return model;
}

/// The same, with corners pushed apart before they fold.
RecoveryModel with_guard(RecoveryModel model) {
  model.guarded = true;
  model.body.fold_guard = usual_fold_guard;
  model.name += guarded_suffix;
  return model;
}

}  // namespace

RecoveryConfig recovery_config(const ExperimentOptions& options) {
  RecoveryConfig config{.models = {thesis_model(), with_guard(thesis_model())},
                        .states = trapped_states(),
                        .seed = options.seed};
  for (const double t : {0.0, 0.5, 1.0})
    for (const double poisson : {0.25, 0.4, 0.45}) {
      RecoveryModel model = material_model(fmt::format("springs, t = {:g}", t), spring_model, poisson, t);
      model.lands = t > 0 && poisson == 0.25;
      config.models.push_back(model);
      config.models.push_back(with_guard(model));
    }
  // The guard's promise is for t = 0.5 and 1: a thousand trials each. Elements take a hundred times as long.
  for (RecoveryModel& model : config.models)
    model.seeds = options.quick ? 1 : model.guarded && model.face_share > 0 ? 59 : 12;
  constexpr int seeds_of_elements = 3;
  for (const double poisson : {0.25, 0.45}) {
    if (options.quick) break;
    config.models.push_back(material_model("corotational elements", "corotational", poisson, 0.5));
    config.models.back().seeds = seeds_of_elements;
  }
  for (double speed = 5; speed <= 500; speed *= options.quick ? 1.5 : 1.1)
    config.landing_speeds.push_back(speed);
  return config;
}

ExperimentInfo experiment() {
  return {.name = "recovery",
          .summary =
              "how often and how fast bodies find back from folded, crushed and mirrored states, with and "
              "without the guard",
          .accepts = {.seed = true, .processes = true},
          .run = run_recovery,
          .baseline = {.keys = {"model", "state"},
                       .rules = {{"trials", 1e-12}, {"recovered", 1e-12}},
                       .table = baseline_table}};
}

}  // namespace mss::studies::recovery

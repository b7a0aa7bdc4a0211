// Work and precision: the error of every integrator against its cost, on smooth motions and on scenes that
// people have, some of which come to a plane.
//
// A run integrates from the start to the end time with one step size or tolerance; its error is the root mean
// square difference of positions from the reference, relative to the displacement of the reference. The
// reference is CVODE's Adams method at a tight tolerance; its difference from an unrelated method, the
// explicit Runge-Kutta pair of Dormand and Prince in ARKODE, is its uncertainty. Planes act in fixed steps,
// which these have not: there an explicit method at small steps is the reference. All methods run on one
// thread. Scenes and texts are here, runs in runs.cpp, charts in chart.cpp.
#include "experiments/studies/precision/precision.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace mss::studies::precision {

namespace {

Vec3 twisted(const Vec3& rest) {
  const double angle = 0.6 * rest[2];
  const Vec3 arm = rest - Vec3(0.5, 0.5, 0);
  return Vec3(0.5 + std::cos(angle) * arm[0] - std::sin(angle) * arm[1],
              0.5 + std::sin(angle) * arm[0] + std::cos(angle) * arm[1], rest[2]);
}

Vec3 stretched(const Vec3& rest) { return {rest[0], rest[1], 1.1 * rest[2]}; }

PrecisionScene filled(PrecisionScene s, double young, double damping) {
  s.body.fill({.young = young, .poisson = 0.3}, 0.5);
  if (damping > 0) s.body.damping = {.law = Damping::Law::ratio, .zeta = damping};
  s.description += fmt::format("; E = {:g} kPa, {}", young / 1e3,
                               damping > 0 ? fmt::format("damping ratio {}", damping) : "undamped");
  return s;
}

/// A box of cells from the origin on.
BodyConfig cells(int x, int y, int z, double cell_size) {
  return {.voxels = VoxelGrid::box(x, y, z), .cell_size = cell_size};
}

Environment held_end(double gravity) {
  return {.gravity = Vec3(0, 0, -gravity), .holds = {{.box = {{0, 0, 0}, {0, 1, 1}}}}};
}

/// Bodies two cells wide.
std::vector<PrecisionScene> small_bodies() {
  return {
      filled({.name = "cantilever_soft_undamped",
              .description = "cantilever 3 x 1 x 1 m, 6 x 2 x 2 cells, released from straight under gravity",
              .body = cells(6, 2, 2, 0.5),
              .environment = held_end(1)},
             1e4, 0),
      filled({.name = "twist_soft_damped",
              .description = "block 1 x 1 x 2 m, 2 x 2 x 4 cells, twisted by 69 degrees and released, its "
                             "bottom fixed",
              .body = cells(2, 2, 4, 0.5),
              .environment = {.holds = {{.box = {{0, 0, 0}, {1, 1, 0}}}}},
              .start = twisted},
             1e4, 0.05),
      filled({.name = "stretch_stiff_undamped",
              .description = "free cube of 1 m, 2 cells an edge, stretched by 10 % and released",
              .body = cells(2, 2, 2, 0.5),
              .start = stretched},
             1e6, 0)};
}

/// A cube of 8 cells an edge whose bottom is held: released while it is twisted, or turned slowly at its top.
PrecisionScene twisted_cube() {
  return filled({.name = "cube_8_soft_undamped",
                 .description = "cube of 1 m, 8 cells an edge, twisted by 34 degrees and released",
                 .body = cells(8, 8, 8, 1.0 / 8),
                 .environment = {.holds = {{.box = {{0, 0, 0}, {1, 1, 0}}}}},
                 .start = twisted},
                1e5, 0);
}
PrecisionScene turned_cube() {
  return filled({.name = "cube_8_stiff_damped",
                 .description = "cube of 1 m, 8 cells an edge, its top turned by 29 degrees in 1 s",
                 .body = cells(8, 8, 8, 1.0 / 8),
                 .environment = {.holds = {{.box = {{0, 0, 0}, {1, 1, 0}}},
                                           {.box = {{0, 0, 1}, {1, 1, 1}},
                                            .turn = Turn{.centre = Vec3(0.5, 0.5, 1), .rate = 0.5}}}}},
                1e7, 0.5);
}

/// A cantilever of 16 x 4 x 4 cells under gravity.
PrecisionScene beam(const char* name, double young, double gravity, double damping) {
  return filled(
      {.name = name,
       .description = fmt::format(
           "cantilever 4 x 1 x 1 m, 16 x 4 x 4 cells, released from straight under {:g} m/s^2", gravity),
       .body = cells(16, 4, 4, 0.25),
       .environment = held_end(gravity)},
      young, damping);
}

/// Those of the project's own, small ones first.
std::vector<PrecisionScene> smooth_scenes() {
  std::vector<PrecisionScene> all = small_bodies();
  all.push_back(turned_cube());
  all.push_back(twisted_cube());
  all.push_back(beam("beam_16_damped", 1e6, 1, 0.05));
  all.push_back(beam("beam_16_stiff_damped", 1e7, 9.81, 0.5));
  return all;
}
/// How many of them quick runs take, and which of the scenes that people have all runs and quick ones do.
constexpr std::size_t quick_scenes = 3;
constexpr std::array taken_cases{"held_box_stiff_damped", "bracket_medium", "ball_medium", "spin_soft"};
constexpr std::array quick_cases{"ball_medium"};

PrecisionScene bench_of(const std::string& name, bool quick) {
  const BenchCase& which = find_bench_case(name);
  const BenchScene& scene = find_bench_scene(which.scene);
  return bench_precision(which, quick ? scene.quick_cells : scene.cells);
}

/// Those that are named, else the study's own choice.
std::vector<PrecisionScene> scenes_of(const ExperimentOptions& options) {
  std::vector<PrecisionScene> own = smooth_scenes(), chosen;
  if (options.scenes.empty()) {
    if (options.quick) own.erase(own.begin() + quick_scenes, own.end());
    chosen = std::move(own);
    if (options.quick)
      for (const char* name : quick_cases) chosen.push_back(bench_of(name, true));
    else
      for (const char* name : taken_cases) chosen.push_back(bench_of(name, false));
    return chosen;
  }
  check_scenes(options.scenes, precision_scene_names());
  for (const std::string& name : options.scenes) {
    const auto found =
        std::find_if(own.begin(), own.end(), [&](const PrecisionScene& s) { return s.name == name; });
    chosen.push_back(found == own.end() ? bench_of(name, options.quick) : *found);
  }
  return chosen;
}

Json configuration(const PrecisionConfig& config) {
  Json scenes = Json::object();
  for (const PrecisionScene& s : config.scenes) scenes[s.name] = s.description;
  return {{"scenes", scenes},
          {"model", config.model},
          {"integrators", config.integrators},
          {"seconds_per_run", config.seconds_per_run},
          {"seconds_to_agree", config.seconds_to_agree},
          {"repetitions", config.repetitions},
          {"seconds_per_row", config.seconds_per_row},
          {"reference",
           "cvode_adams; uncertainty: its difference from arkode_erk. On planes semi_implicit_euler or "
           "velocity_verlet at a sixteenth of the safe step or less; uncertainty: the difference of twice "
           "that step"},
          {"reference_tolerance", config.reference_tolerance},
          {"steps", "duration / 8, halved until the error is below ten uncertainties or a run too long"},
          {"tolerances",
           "0.1 to 1e-11 by decades, relative to a cell in length and a tenth of cell x omega in speed"},
          {"threads", config.threads},
          {"linear_solver", fmt::format("automatic up to {} particles, matrix_free above", precision_small)},
          {"tangent", "elastic, projected where that is indefinite"}};
}

constexpr const char* caption =
    "Error of positions at the end time against wall time, for every integrator: root mean square over "
    "particles, relative to the largest displacement of the reference from its start. Each point is one step "
    "size or tolerance, the median of up to 5 runs, all taken in turn; lower left is better. Left out of a "
    "chart are methods that take more than ten times as long as the cheapest one at every error; the table "
    "has "
    "them. Failed runs are markers of their method on the lines above, which give the reason. The reference "
    "is "
    "CVODE's Adams method at a tolerance of 1e-12; its uncertainty is its difference from an unrelated "
    "method "
    "(ARKODE, Dormand and Prince); errors below ten times that, drawn as a line, are not significant. Where "
    "bodies come to a plane, which acts in fixed steps and leaves every method of first order, the reference "
    "is an explicit method at a sixteenth of its safe step or less, its uncertainty the difference of twice "
    "that step, and SUNDIALS' methods are refused. In the first chart, methods without a stability limit are "
    "implicit ones, XPBD and vertex block descent; "
    "explicit ones include adaptive ones. explicit_steps in the table is wall time over that of one explicit "
    "step of the same body, so that "
    "factorisations, products and solves count at what they take. One thread; linear systems by CHOLMOD in "
    "the bodies that are two cells wide and by matrix_free in the others. Not varied: precision.";

std::string agreement_line(const Table& agreement) {
  std::map<std::string, std::size_t> count;
  for (std::size_t r = 0; r < agreement.size(); ++r) ++count[agreement.text(r, "status")];
  std::string line =
      fmt::format("methods within {:g} of the reference, of {}:", precision_agreed, agreement.size());
  for (const auto& [status, n] : count) line += fmt::format(" {} {};", n, status);
  line.back() = '\n';
  return line;
}

ExperimentResult run_precision(const ExperimentOptions& options, Progress& progress) {
  const PrecisionConfig config = precision_config(options);
  PrecisionTables tables = measure_precision(config, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  const std::string agreement = agreement_line(tables.agreement);
  result.tables = precision_files(std::move(tables));
  result.summary = precision_text(find_table(result.tables, "precision_summary")) + agreement;
  return result;
}

}  // namespace

std::string precision_text(const Table& summary) {
  std::string lines;
  for (std::size_t r = 0; r < summary.size(); ++r) {
    const double seconds = summary.number(r, "seconds");
    lines += fmt::format("{:<28} error {:<6g} {:<22} {:>12}  {}\n", summary.text(r, "scene"),
                         summary.number(r, "error"), summary.text(r, "integrator"),
                         std::isnan(seconds) ? "-" : fmt::format("{:.3g} s", seconds),
                         summary.text(r, "comparison"));
  }
  return lines;
}

std::vector<NamedTable> precision_files(PrecisionTables tables) {
  Table summary = precision_summary(tables.rows, tables.references);
  return {{"precision", std::move(tables.rows)},
          {"precision_summary", std::move(summary)},
          {"precision_agreement", std::move(tables.agreement)},
          {"precision_references", std::move(tables.references)}};
}

std::vector<PrecisionScene> small_scenes(std::vector<PrecisionScene> scenes) {
  std::erase_if(scenes,
                [](const PrecisionScene& s) { return Body(s.body).particle_count() > precision_small; });
  return scenes;
}

PrecisionConfig precision_config(const ExperimentOptions& options) {
  PrecisionConfig config;
  config.integrators = moving_families(options.integrators, options.model);
  if (options.integrators.empty())  // those that `regimes` finds the cheapest in stiff bodies
    for (const char* name : {"tr_bdf2/lbfgs:4", "generalized_alpha/lbfgs:5"})
      config.integrators.emplace_back(name);
  config.model = options.model;
  config.scenes = scenes_of(options);
  if (options.quick) {
    config.seconds_per_run = config.seconds_to_agree = 0.03;
    config.seconds_per_row = 0.02;
  }
  return config;
}

PrecisionScene bench_precision(const BenchCase& which, int cells) {
  const BenchScene& scene = find_bench_scene(which.scene);
  BenchSetup setup = bench_setup(scene, cells, {which.young, damping_of_ratio(which.ratio)});
  return {.name = which.name(),
          .description = which.description(cells),
          .body = std::move(setup.body),
          .environment = std::move(setup.environment),
          .duration = scene.frames * frame,
          .bench = &which,
          .cells = cells};
}

std::vector<std::string> precision_scene_names() {
  std::vector<std::string> names;
  for (const PrecisionScene& s : smooth_scenes()) names.push_back(s.name);
  for (const std::string& name : bench_case_names()) names.push_back(name);
  return names;
}

namespace {

/// Which steps the references take hangs on rounding, and with them their energies, which energy_drift is
/// relative to: of the undamped cube they are 3e-9 apart between GCC 12 and Clang 14.
constexpr double energy_of_references = 1e-8;

constexpr double error_rounding = 1e-9;  ///< how far errors may move with it
/// Smaller errors prove nothing, and rounding decides after which of them a method stops; the errors next to
/// this limit are half and twice as large.
constexpr double smallest_error = 5e-10;
constexpr double largest_error = 0.05;  ///< errors above are not yet of the method's order

/// Methods of fixed step at steps well inside their stability: these errors are the same on every machine.
Table baseline_table(const BaselineOptions& options, Progress& progress) {
  PrecisionConfig config = precision_config({.quick = options.quick, .integrators = moving_integrators({})});
  config.scenes = small_scenes(config.scenes);
  config.seconds_per_run = config.seconds_to_agree = 3600;
  config.repetitions = 1;
  config.finest_halving = options.quick ? 7 : 9;
  std::erase_if(config.integrators,
                [](const std::string& name) { return find_integrator(name).stepping != Stepping::fixed; });
  config.threads = options.threads;
  const Table rows = measure_precision(config, progress).rows;
  Table table({{"scene"},
               {"integrator"},
               {"value"},
               {"error"},
               {"energy_drift"},
               {"volume_drift"},
               {"steps"},
               {"status"}});
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const double error = rows.number(r, "error");
    if (rows.text(r, "status") != "ok" || error < smallest_error || error > largest_error) continue;
    table.add({rows.text(r, "scene"), rows.text(r, "integrator"), rows.number(r, "value"), error,
               rows.number(r, "energy_drift"), rows.number(r, "volume_drift"),
               std::int64_t(rows.number(r, "steps")), rows.text(r, "status")});
  }
  return table;
}

}  // namespace

ExperimentInfo experiment() {
  return {
      .name = "precision",
      .summary = "error against cost for every integrator, on smooth motions and on scenes that people have",
      .accepts = {.integrators = moving_families, .scenes = precision_scene_names, .model = true},
      .run = run_precision,
      .draw = draw_precision,
      .baseline = {.keys = {"scene", "integrator", "value"},
                   .rules = {{"error", 1e-4, error_rounding},
                             {"energy_drift", 1e-4, energy_of_references},
                             {"volume_drift", 1e-4, 1e-9}},
                   .table = baseline_table}};
}

}  // namespace mss::studies::precision

// Work and precision: the error of every integrator against its cost, on scenes with smooth solutions.
//
// A run integrates from the start to the end time with one step size or tolerance; its error is the root mean
// square difference of positions from the reference, relative to the displacement of the reference. The
// reference is CVODE's Adams method at a tight tolerance; its difference from an unrelated method, the
// explicit Runge-Kutta pair of Dormand and Prince in ARKODE, is its uncertainty. All methods run on one
// thread. Scenes and texts are here, runs in runs.cpp, charts in chart.cpp.
#include "experiments/studies/precision/precision.hpp"

#include <fmt/format.h>

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

enum class Shape { cantilever, twist, stretch };

const char* to_string(Shape shape) {
  return shape == Shape::cantilever ? "cantilever" : shape == Shape::twist ? "twist" : "stretch";
}

void set_shape(PrecisionScene& s, Shape shape) {
  constexpr int n = 2;  // cells per metre
  s.body.cell_size = 1.0 / n;
  switch (shape) {
    case Shape::cantilever:
      s.description = "cantilever 3 x 1 x 1 m, released from straight under gravity";
      s.body.voxels = VoxelGrid::box(3 * n, n, n);
      s.environment = {.gravity = Vec3(0, 0, -1), .holds = {{.box = {{0, 0, 0}, {0, 1, 1}}}}};
      break;
    case Shape::twist:
      s.description = "block 1 x 1 x 2 m, twisted by 69 degrees and released, its bottom fixed";
      s.body.voxels = VoxelGrid::box(n, n, 2 * n);
      s.environment = {.holds = {{.box = {{0, 0, 0}, {1, 1, 0}}}}};
      s.start = twisted;
      break;
    case Shape::stretch:
      s.description = "free cube of 1 m, stretched by 10 % and released";
      s.body.voxels = VoxelGrid::box(n, n, n);
      s.start = stretched;
      break;
  }
}

/// One of three bodies, soft or a hundred times stiffer, undamped or damped. The simulated time is the same
/// for all, so that it is ten times as many periods of a stiff body.
PrecisionScene scene(Shape shape, double young, double damping) {
  PrecisionScene s{.name = fmt::format("{}_{}_{}", to_string(shape), young > 1e5 ? "stiff" : "soft",
                                       damping > 0 ? "damped" : "undamped"),
                   .description = {},
                   .body = {}};
  set_shape(s, shape);
  s.body.fill({.young = young, .poisson = 0.3}, 0.5);
  if (damping > 0) s.body.damping = {.law = Damping::Law::ratio, .zeta = damping};
  s.description += fmt::format("; E = {:g} kPa, {}", young / 1e3,
                               damping > 0 ? fmt::format("damping ratio {}", damping) : "undamped");
  return s;
}

Json configuration(const PrecisionConfig& config) {
  Json scenes = Json::object();
  for (const PrecisionScene& s : config.scenes) scenes[s.name] = s.description;
  return {{"scenes", scenes},
          {"model", config.model},
          {"integrators", config.integrators},
          {"seconds_per_run", config.seconds_per_run},
          {"seconds_to_agree", config.seconds_to_agree},
          {"reference", "cvode_adams; uncertainty: its difference from arkode_erk"},
          {"reference_tolerance", config.reference_tolerance},
          {"steps", "duration / 8, halved until the error is below ten uncertainties or a run too long"},
          {"tolerances",
           "0.1 to 1e-11 by decades, relative to a cell in length and a tenth of cell x omega in speed"},
          {"threads", config.threads},
          {"linear_solver", IntegratorOptions{}.linear_solver},
          {"tangent", "elastic, projected where that is indefinite"}};
}

constexpr const char* caption =
    "Error of positions at the end time against the cost of a run, for every integrator: root mean square "
    "over particles, relative to the largest displacement of the reference from its start. Each point is one "
    "run with one step size or tolerance; lower left is better. Markers on the upper edge are runs that "
    "failed, with the reason in the legend. The reference is CVODE's Adams method at a tolerance of "
    "1e-12; its uncertainty is its difference from an unrelated method (ARKODE, Dormand and Prince); errors "
    "below ten times that, drawn as a line, are not significant. One thread; implicit methods use CHOLMOD. "
    "Methods without a curve in the overview reach none of these errors on every scene. Left out: single "
    "precision, other linear solvers, other sizes.";

std::string agreement_line(const Table& agreement) {
  std::map<std::string, std::size_t> count;
  for (std::size_t r = 0; r < agreement.size(); ++r) ++count[agreement.text(r, "status")];
  std::string line =
      fmt::format("methods within {:g} of the reference, of {}:", precision_agreed, agreement.size());
  for (const auto& [status, n] : count) line += fmt::format(" {} {};", n, status);
  line.back() = '\n';
  return line;
}

std::string summary_lines(const Table& summary) {
  std::string lines;
  for (std::size_t r = 0; r < summary.size(); ++r)
    lines += fmt::format("{:<28} error {:<6g} {:<22} {:>10.3g} s  {}\n", summary.text(r, "scene"),
                         summary.number(r, "error"), summary.text(r, "integrator"),
                         summary.number(r, "seconds"), summary.text(r, "comparison"));
  return lines;
}

ExperimentResult run_precision(const ExperimentOptions& options, Progress& progress) {
  const PrecisionConfig config = precision_config(options);
  PrecisionTables tables = measure_precision(config, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  result.summary = summary_lines(precision_summary(tables.rows)) + agreement_line(tables.agreement);
  result.tables = precision_files(std::move(tables));
  return result;
}

}  // namespace

std::vector<NamedTable> precision_files(PrecisionTables tables) {
  Table summary = precision_summary(tables.rows);
  return {{"precision", std::move(tables.rows)},
          {"precision_summary", std::move(summary)},
          {"precision_agreement", std::move(tables.agreement)},
          {"precision_references", std::move(tables.references)}};
}

PrecisionConfig precision_config(const ExperimentOptions& options) {
  PrecisionConfig config;
  config.integrators = moving_families(options.integrators, options.model);
  config.model = options.model;
  if (options.quick) {
    config.seconds_per_run = config.seconds_to_agree = 0.3;
    config.scenes = {scene(Shape::cantilever, 1e4, 0), scene(Shape::twist, 1e4, 0.05),
                     scene(Shape::stretch, 1e6, 0)};
  } else {
    for (const Shape shape : {Shape::cantilever, Shape::twist, Shape::stretch})
      for (const double young : {1e4, 1e6})
        for (const double damping : {0.0, 0.05}) config.scenes.push_back(scene(shape, young, damping));
  }
  return config;
}

namespace {

/// Methods of fixed step at steps well inside their stability: these errors are the same on every machine.
Table baseline_table(const BaselineOptions& options, Progress& progress) {
  PrecisionConfig config = precision_config({.quick = options.quick, .integrators = moving_integrators({})});
  config.seconds_per_run = config.seconds_to_agree = 3600;
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
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.text(r, "status") == "ok" && rows.number(r, "error") < 0.05)
      table.add({rows.text(r, "scene"), rows.text(r, "integrator"), rows.number(r, "value"),
                 rows.number(r, "error"), rows.number(r, "energy_drift"), rows.number(r, "volume_drift"),
                 std::int64_t(rows.number(r, "steps")), rows.text(r, "status")});
  return table;
}

}  // namespace

ExperimentInfo experiment() {
  return {.name = "precision",
          .summary = "error against cost for every integrator, on scenes with smooth solutions",
          .accepts = {.integrators = moving_families, .model = true},
          .run = run_precision,
          .draw = draw_precision,
          .baseline = {
              .keys = {"scene", "integrator", "value"},
              .rules = {{"error", 1e-4, 1e-9}, {"energy_drift", 1e-4, 1e-9}, {"volume_drift", 1e-4, 1e-9}},
              .table = baseline_table}};
}

}  // namespace mss::studies::precision

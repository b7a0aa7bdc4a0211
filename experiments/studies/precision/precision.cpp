// Work and precision: the error of every integrator against what it costs, on scenes with smooth solutions.
//
// A run goes from the start to the end time with one step size or tolerance; the error is the root mean
// square of positions against the reference, over that of the reference's displacement from the start. The
// reference is CVODE's Adams method at a tight tolerance; what an unrelated method, the explicit Runge-Kutta
// pair of Dormand and Prince in ARKODE, says differently is its uncertainty. All methods run on one thread.
// Scenes and texts are here, runs in precision_runs.cpp, what is drawn in precision_chart.cpp.
#include "experiments/studies/precision/precision.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "experiments/simulation/model.hpp"

namespace mss::studies::precision {

namespace {

Vec3 twisted(const Vec3& rest) {
  const double angle = 0.6 * rest[2];
  const Vec3 arm = rest - Vec3(0.5, 0.5, 0);
  return Vec3(0.5 + std::cos(angle) * arm[0] - std::sin(angle) * arm[1],
              0.5 + std::sin(angle) * arm[0] + std::cos(angle) * arm[1], rest[2]);
}

Vec3 stretched(const Vec3& rest) { return {rest[0], rest[1], 1.1 * rest[2]}; }

/// The same three bodies, soft or a hundred times stiffer, undamped or damped. A stiffer body moves faster:
/// it is followed for the same time, so for more periods.
PrecisionScene scene(const std::string& shape, double young, double damping, int refinement) {
  const int n = 2 * refinement;
  const std::string name =
      fmt::format("{}_{}_{}", shape, young > 1e5 ? "stiff" : "soft", damping > 0 ? "damped" : "undamped");
  PrecisionScene s{.name = name, .description = {}, .body = {.cell_size = 1.0 / n}};
  const Box bottom{{0, 0, 0}, {1, 1, 0}}, left{{0, 0, 0}, {0, 1, 1}};
  if (shape == "cantilever") {
    s.description = "cantilever 3 x 1 x 1 m, released from straight under gravity";
    s.body.voxels = VoxelGrid::box(3 * n, n, n);
    s.environment = {.gravity = Vec3(0, 0, -1), .holds = {{.box = left}}};
  } else if (shape == "twist") {
    s.description = "block 1 x 1 x 2 m, twisted by 69 degrees and released, its bottom held";
    s.body.voxels = VoxelGrid::box(n, n, 2 * n);
    s.environment = {.holds = {{.box = bottom}}};
    s.start = twisted;
  } else {
    s.description = "free cube of 1 m, stretched by 10 % and released";
    s.body.voxels = VoxelGrid::box(n, n, n);
    s.start = stretched;
  }
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
          {"reference", "cvode_adams; uncertainty: its difference to arkode_erk"},
          {"reference_tolerance", config.reference_tolerance},
          {"steps", "duration / 8, halved until the error is ten uncertainties or a run too long"},
          {"tolerances", "0.1 to 1e-11 by decades; lengths over a cell, speeds over a tenth of cell x omega"},
          {"threads", config.threads},
          {"linear_solver", IntegratorOptions{}.linear_solver},
          {"tangent", "elastic, projected where that is indefinite"}};
}

constexpr const char* caption =
    "Error of positions at the end time against what a run costs, for every integrator: root mean square "
    "over particles, relative to how far the reference moves from its start. Each point is one run with "
    "one step size or tolerance; down and to the left is better. Crosses on the upper edge are runs that "
    "failed, with the reason in the legend. The reference is CVODE's Adams method at a tolerance of "
    "1e-12; an unrelated method (ARKODE, Dormand and Prince) differs from it by the uncertainty, and "
    "below ten times that, drawn as a line, errors say nothing. One thread; implicit methods use CHOLMOD."
    " Methods without a curve in the overview reach none of these errors on every scene. Left out: single "
    "precision, other linear solvers, "
    "other sizes.";

std::string agreement_line(const Table& agreement) {
  std::map<std::string, std::size_t> count;
  for (std::size_t r = 0; r < agreement.size(); ++r) ++count[agreement.text(r, "status")];
  std::string line = fmt::format("methods within 1e-6 of the reference, of {}:", agreement.size());
  for (const auto& [status, n] : count) line += fmt::format(" {} {};", n, status);
  line.back() = '\n';
  return line;
}

ExperimentResult run_precision(const ExperimentOptions& options, Progress& progress) {
  const PrecisionConfig config = precision_config(options);
  PrecisionTables tables = measure_precision(config, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  Table summary = precision_summary(tables.rows);
  if (tables.rows.size() > 0) result.charts.push_back({"precision", precision_overview(tables.rows)});
  const auto measured = tables.rows.distinct("scene");  // not those without a reference
  for (const PrecisionScene& s : config.scenes) {
    if (std::find(measured.begin(), measured.end(), s.name) == measured.end()) continue;
    for (const char* cost : {"seconds", "force_evaluations"})
      result.charts.push_back({fmt::format("precision_{}_{}", s.name, cost),
                               precision_chart(tables.rows, tables.references, s, cost)});
  }
  for (NamedChart& chart : result.charts) tell_model(chart.chart, config.model);
  for (std::size_t r = 0; r < summary.size(); ++r)
    result.summary += fmt::format("{:<28} error {:<6g} {:<22} {:>10.3g} s  {}\n", summary.text(r, "scene"),
                                  summary.number(r, "error"), summary.text(r, "integrator"),
                                  summary.number(r, "seconds"), summary.text(r, "comparison"));
  result.summary += agreement_line(tables.agreement);
  result.tables = {{"precision", std::move(tables.rows)},
                   {"precision_summary", std::move(summary)},
                   {"precision_agreement", std::move(tables.agreement)},
                   {"precision_references", std::move(tables.references)}};
  return result;
}

}  // namespace

PrecisionConfig precision_config(const ExperimentOptions& options) {
  PrecisionConfig config;
  config.integrators = moving_integrators(options.integrators);
  config.model = options.model;
  if (options.quick) {
    config.seconds_per_run = config.seconds_to_agree = 0.3;
    config.scenes = {scene("cantilever", 1e4, 0, 1), scene("twist", 1e4, 0.05, 1),
                     scene("stretch", 1e6, 0, 1)};
  } else {
    for (const char* shape : {"cantilever", "twist", "stretch"})
      for (const double young : {1e4, 1e6})
        for (const double damping : {0.0, 0.05}) config.scenes.push_back(scene(shape, young, damping, 1));
  }
  return config;
}

namespace {

/// Methods of fixed step at steps where they are not about to blow up: these errors are the same everywhere.
Table baseline_table(const BaselineOptions& options, Progress& progress) {
  PrecisionConfig config = precision_config({.quick = options.quick});
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
          .accepts = {.integrators = moving_integrators, .model = true},
          .run = run_precision,
          .baseline = {
              .keys = {"scene", "integrator", "value"},
              .rules = {{"error", 1e-4, 1e-9}, {"energy_drift", 1e-4, 1e-9}, {"volume_drift", 1e-4, 1e-9}},
              .table = baseline_table}};
}

}  // namespace mss::studies::precision

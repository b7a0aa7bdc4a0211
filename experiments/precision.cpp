// Work and precision: the error of every integrator against what it costs, on scenes with smooth solutions.
//
// A run goes from the start to the end time with one step size or tolerance; the error is the root mean
// square of positions against the reference, over that of the reference's displacement from the start. The
// reference is CVODE's Adams method at a tight tolerance; what an unrelated method, the explicit Runge-Kutta
// pair of Dormand and Prince in ARKODE, says differently is its uncertainty. All methods run on one thread.
#include "experiments/precision.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "core/measures.hpp"
#include "experiments/simulation.hpp"
#include "experiments/statistics.hpp"

namespace mss {

namespace {

using Clock = std::chrono::steady_clock;
constexpr double none = std::numeric_limits<double>::quiet_NaN();

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
  s.body.springs = calibrate({.young = young, .poisson = 0.3}, s.body.cell_size, 0.5);
  if (damping > 0) s.body.damping = {.law = Damping::Law::ratio, .zeta = damping};
  s.description += fmt::format("; E = {:g} kPa, {}", young / 1e3,
                               damping > 0 ? fmt::format("damping ratio {}", damping) : "undamped");
  return s;
}

/// One scene ready to run.
struct Problem {
  explicit Problem(const PrecisionScene& s)
      : scene(s), body(s.body), system(body, s.environment, {.threads = 1}), start(system.rest_state()) {
    if (scene.start)
      for (const std::ptrdiff_t site : body.sites()) start.x.set(site, scene.start(start.x.at(site)));
    system.constrain(0, start.x, start.v);
    scale_errors(options, body);
  }
  const PrecisionScene& scene;
  Body body;
  SpringSystem<double> system;
  State<double> start;
  IntegratorOptions options;
};

/// Root mean square of the distances between two states' particles [m].
double distance(const Body& body, const State<double>& a, const State<double>& b) {
  double sum = 0;
  for (const std::ptrdiff_t site : body.sites()) sum += (a.x.at(site) - b.x.at(site)).squaredNorm();
  return std::sqrt(sum / double(body.particle_count()));
}

struct Reference {
  State<double> state;
  Measures measures;
  double displacement = 0;  ///< largest root mean square from the start, of 32 looks [m]
  double uncertainty = 0;   ///< relative to it
  double energy = 0;        ///< largest of the energies that move [J]
};

Reference find_reference(Problem& p, double tolerance) {
  IntegratorOptions options = p.options;
  options.dt = 0;
  options.tolerance = tolerance;
  Work work;
  Reference r{.state = p.start, .measures = measure(p.system, p.start)};
  r.energy = r.measures.elastic;
  const auto adams = find_integrator("cvode_adams").make<double>(options);
  constexpr int looks = 32;
  for (int look = 1; look <= looks; ++look) {
    adams->advance(p.system, r.state, p.scene.duration * look / looks, work);
    r.measures = measure(p.system, r.state);
    r.displacement = std::max(r.displacement, distance(p.body, r.state, p.start));
    r.energy = std::max({r.energy, r.measures.elastic, r.measures.kinetic});
  }
  State<double> other = p.start;
  find_integrator("arkode_erk").make<double>(options)->advance(p.system, other, p.scene.duration, work);
  r.uncertainty = distance(p.body, r.state, other) / r.displacement;
  return r;
}

/// What came of one run.
struct Run {
  Status status = Status::ok;
  Work work;
  double seconds = 0;
  double error = none, energy_drift = none, volume_drift = none;
};

Run run_once(Problem& p, const Reference& reference, const IntegratorInfo& info,
             const IntegratorOptions& options) {
  Run run;
  State<double> state = p.start;
  const auto method = info.make<double>(options);
  const auto begin = Clock::now();
  run.status = method->advance(p.system, state, p.scene.duration, run.work);
  run.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  if (run.status != Status::ok) return run;
  const Measures m = measure(p.system, state);
  run.error = distance(p.body, state, reference.state) / reference.displacement;
  run.energy_drift = std::abs(m.total() - reference.measures.total()) / reference.energy;
  run.volume_drift = std::abs(m.volume_ratio - reference.measures.volume_ratio);
  if (!std::isfinite(run.error) || !std::isfinite(run.energy_drift)) {  // squares overflow before coordinates
    run.status = Status::non_finite;
    run.error = run.energy_drift = run.volume_drift = none;
  }
  return run;
}

/// Short runs are repeated, and the median time is kept.
Run run_timed(Problem& p, const Reference& reference, const IntegratorInfo& info,
              const IntegratorOptions& options) {
  Run run = run_once(p, reference, info, options);
  std::vector<double> seconds{run.seconds};
  while (run.status == Status::ok && seconds.size() < 5 && run.seconds < 0.02)
    seconds.push_back(run_once(p, reference, info, options).seconds);
  run.seconds = quantile(seconds, 0.5);
  return run;
}

void add_row(Table& rows, const PrecisionScene& s, const IntegratorInfo& info, const IntegratorOptions& o,
             const Run& run) {
  rows.add({s.name, info.name, std::string(info.adaptive ? "tolerance" : "dt"),
            info.adaptive ? o.tolerance : o.dt, run.error, run.energy_drift, run.volume_drift, run.seconds,
            run.work.steps, run.work.force_evaluations, run.work.jacobians, run.work.factorisations,
            run.work.linear_solves, run.work.products, std::string(to_string(run.status))});
}

/// One method from coarse to fine, until it is as good as the reference or too slow; false if stopped.
bool measure_method(Problem& p, const Reference& reference, const IntegratorInfo& info,
                    const PrecisionConfig& config, Table& rows, const Progress& progress) {
  IntegratorOptions options = p.options;
  const int runs = info.adaptive ? 11 : config.finest_halving;
  double before = 0;
  for (int i = 0; i < runs; ++i) {
    if (progress.stopped()) return false;
    options.dt = info.adaptive ? 0 : p.scene.duration / std::ldexp(8.0, i);
    options.tolerance = std::pow(10.0, -1 - i);
    const Run run = run_timed(p, reference, info, options);
    add_row(rows, p.scene, info, options, run);
    if (run.error < 10 * reference.uncertainty) break;
    const double growth = before > 0 ? std::clamp(run.seconds / before, 1.0, 4.0) : 2.0;
    if (run.status == Status::ok && run.seconds * growth > config.seconds_per_run) break;
    if (run.status == Status::ok) before = run.seconds;
  }
  return true;
}

Table empty_rows() {
  return Table({{"scene"},
                {"integrator"},
                {"parameter"},
                {"value"},
                {"error"},
                {"energy_drift"},
                {"volume_drift"},
                {"seconds", "s"},
                {"steps"},
                {"force_evaluations"},
                {"jacobians"},
                {"factorisations"},
                {"linear_solves"},
                {"products"},
                {"status"}});
}

Table empty_references() {
  return Table({{"scene"},
                {"description"},
                {"particles"},
                {"springs"},
                {"duration", "s"},
                {"displacement", "m"},
                {"uncertainty"}});
}

Json configuration(const PrecisionConfig& config) {
  Json scenes = Json::object();
  for (const PrecisionScene& s : config.scenes) scenes[s.name] = s.description;
  return {{"scenes", scenes},
          {"integrators", config.integrators},
          {"seconds_per_run", config.seconds_per_run},
          {"reference", "cvode_adams; uncertainty: its difference to arkode_erk"},
          {"reference_tolerance", config.reference_tolerance},
          {"steps", "duration / 8, halved until the error is ten uncertainties or a run too long"},
          {"tolerances", "0.1 to 1e-11 by decades; lengths over a cell, speeds over a tenth of cell x omega"},
          {"threads", 1},
          {"linear_solver", IntegratorOptions{}.linear_solver},
          {"tangent", "elastic, projected where that is indefinite"}};
}

constexpr const char* caption =
    "Error of positions at the end time against what a run costs, for every integrator: root mean square "
    "over "
    "particles, relative to how far the reference moves from its start. Each point is one run with one step "
    "size or tolerance; down and to the left is better. Crosses on the upper edge are runs that failed, with "
    "the reason in the legend. The reference is CVODE's Adams method at a tolerance of 1e-12; an unrelated "
    "method (ARKODE, Dormand and Prince) differs from it by the uncertainty, and below ten times that, drawn "
    "as "
    "a line, errors say nothing. One thread; implicit methods use CHOLMOD. Left out: single precision, other "
    "linear solvers, other sizes.";

ExperimentResult run_precision(const ExperimentOptions& options, Progress& progress) {
  const PrecisionConfig config = precision_config(options);
  PrecisionTables tables = measure_precision(config, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  Table summary = precision_summary(tables.rows);
  if (tables.rows.size() > 0) result.charts.push_back({"precision", precision_overview(tables.rows)});
  for (const PrecisionScene& s : config.scenes) {
    const auto finished = [&] {
      for (std::size_t r = 0; r < tables.references.size(); ++r)
        if (tables.references.text(r, "scene") == s.name) return true;
      return false;
    };
    if (!finished()) continue;
    for (const char* cost : {"seconds", "force_evaluations"})
      result.charts.push_back({fmt::format("precision_{}_{}", s.name, cost),
                               precision_chart(tables.rows, tables.references, s, cost)});
  }
  for (std::size_t r = 0; r < summary.size(); ++r)
    result.summary += fmt::format("{:<28} error {:<6g} {:<22} {:>10.3g} s  {}\n", summary.text(r, "scene"),
                                  summary.number(r, "error"), summary.text(r, "integrator"),
                                  summary.number(r, "seconds"), summary.text(r, "comparison"));
  result.tables = {{"precision", std::move(tables.rows)},
                   {"precision_summary", std::move(summary)},
                   {"precision_references", std::move(tables.references)}};
  return result;
}

}  // namespace

PrecisionConfig precision_config(const ExperimentOptions& options) {
  PrecisionConfig config;
  config.integrators = options.integrators;
  if (config.integrators.empty())
    for (const IntegratorInfo& info : integrators()) config.integrators.push_back(info.name);
  if (options.quick) {
    config.seconds_per_run = 0.3;
    config.scenes = {scene("cantilever", 1e4, 0, 1), scene("twist", 1e4, 0.05, 1),
                     scene("stretch", 1e6, 0, 1)};
  } else {
    for (const char* shape : {"cantilever", "twist", "stretch"})
      for (const double young : {1e4, 1e6})
        for (const double damping : {0.0, 0.05}) config.scenes.push_back(scene(shape, young, damping, 1));
  }
  return config;
}

PrecisionTables measure_precision(const PrecisionConfig& config, Progress& progress) {
  PrecisionTables tables{empty_rows(), empty_references()};
  for (std::size_t i = 0; i < config.scenes.size(); ++i) {
    Problem problem(config.scenes[i]);
    progress.report(double(i) / double(config.scenes.size()), config.scenes[i].name + ": reference");
    const Reference reference = find_reference(problem, config.reference_tolerance);
    tables.references.add({problem.scene.name, problem.scene.description,
                           std::int64_t(problem.body.particle_count()),
                           std::int64_t(problem.body.spring_count()), problem.scene.duration,
                           reference.displacement, reference.uncertainty});
    for (std::size_t m = 0; m < config.integrators.size(); ++m) {
      progress.report(
          (double(i) + double(m) / double(config.integrators.size())) / double(config.scenes.size()),
          config.scenes[i].name + ": " + config.integrators[m]);
      if (!measure_method(problem, reference, find_integrator(config.integrators[m]), config, tables.rows,
                          progress)) {
        tables.status = Status::interrupted;
        return tables;
      }
    }
  }
  return tables;
}

ExperimentInfo precision() {
  return {.name = "precision",
          .summary = "error against cost for every integrator, on scenes with smooth solutions",
          .accepts = {.integrators = true},
          .run = run_precision};
}

}  // namespace mss

// One hard step, solved by every nonlinear and linear solver: how far from the solution it is after so many
// iterations, and after so much time. Papers on solvers show this of one scene that suits them (Liu,
// Bargteil, O'Brien and Kavan 2013; Liu, Bouaziz and Kavan 2017); here are five that suit nobody, and in
// scenes.cpp frames of bodies of many shapes and of the scenes that people have.
#include "experiments/studies/convergence/convergence.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "core/base/error.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/processor_time.hpp"
#include "experiments/harness/settings.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/studies/convergence/scenes.hpp"
#include "integrators/linear/linear_solver.hpp"
#include "integrators/nonlinear/implicit_stage.hpp"

namespace mss::studies::convergence {

namespace {

constexpr double charted_dt_omega = 300;
constexpr double smallest_gap = 1e-12;  ///< below is rounding

/// A free cube of 1 m in a hard state: how it is deformed, and what it is made of.
struct Start {
  const char* name;
  const char* description;
  double poisson = 0.3;
  double corner_mass = 0;  ///< of one corner in addition, over the mass of an interior particle
  Vec3 (*place)(const Vec3& rest);
  double noise = 0;  ///< of every coordinate, in cells
};

Vec3 twisted(const Vec3& x, double turn) {
  const double angle = turn * x[2], c = std::cos(angle), s = std::sin(angle);
  const double a = x[0] - 0.5, b = x[1] - 0.5;
  return {0.5 + c * a - s * b, 0.5 + s * a + c * b, x[2]};
}

const std::vector<Start>& all_starts() {
  static const std::vector<Start> starts{
      {.name = "twisted",
       .description = "twisted by 1.5 rad",
       .place = [](const Vec3& x) { return twisted(x, 1.5); }},
      {.name = "crushed",
       .description = "crushed to 40 percent of its height",
       .place = [](const Vec3& x) { return Vec3(x[0], x[1], 0.4 * x[2]); }},
      {.name = "noisy",
       .description = "every coordinate off by up to a third of a cell",
       .place = [](const Vec3& x) { return x; },
       .noise = 1.0 / 3},
      {.name = "heavy_corner",
       .description = "stretched by 20 percent, one corner a million times as heavy as a particle",
       .corner_mass = 1e6,
       .place = [](const Vec3& x) { return Vec3(x[0], x[1], 1.2 * x[2]); }},
      {.name = "nearly_incompressible",
       .description = "nu = 0.45, stretched by 20 percent and twisted by 0.5 rad",
       .poisson = 0.45,
       .place = [](const Vec3& x) { return twisted(Vec3(x[0], x[1], 1.2 * x[2]), 0.5); }}};
  return starts;
}

const Start& find_start(const std::string& name) {
  const auto& all = all_starts();
  return *std::find_if(all.begin(), all.end(), [&](const Start& s) { return s.name == name; });
}

BodyConfig body_of(const Start& start, int n) {
  BodyConfig body{.voxels = VoxelGrid::box(n, n, n), .cell_size = 1.0 / n};
  body.fill({.young = 1e5, .poisson = start.poisson}, 0.5);
  if (start.corner_mass > 0)
    body.weights.push_back({.box = {}, .mass = start.corner_mass * body.density / double(n * n * n)});
  return body;
}

/// A start, deformed and in motion, and the objective of a step from it.
class Problem {
 public:
  Problem(const ConvergenceConfig& config, const Start& start)
      : body_(body_of(start, config.cells)),
        system_(body_, {}, {.threads = config.threads}),
        before_(system_.rest_state()),
        force_(system_.size()) {
    std::mt19937 random(1);
    std::uniform_real_distribution<> off(-start.noise / config.cells, start.noise / config.cells);
    const Vec3 travel(0.6, 0, 0.8), spin(0, 1, 2);  // [m/s], [1/s]
    for (const std::ptrdiff_t site : body_.sites()) {
      Vec3 x = start.place(body_.rest_position(site));
      for (int axis = 0; axis < 3; ++axis) x[axis] += off(random);
      before_.x.set(site, x);
      before_.v.set(site, travel + spin.cross(x - Vec3(0.5, 0.5, 0.5)));
    }
  }

  void set_step(double dt_omega) { dt_ = dt_omega / system_.spectral_bound().omega; }
  double dt() const { return dt_; }
  SpringSystem<double>& system() { return system_; }
  const State<double>& before() const { return before_; }

  /// y, where the particles would be without forces.
  State<double> inertial() const {
    State<double> state = before_;
    state.x.array() += dt_ * state.v.array();
    return state;
  }

  double objective(const Field<double>& x) const {
    const StoredEnergy energy = system_.stored_energy(x);
    double sum = dt_ * dt_ * (energy.elastic + energy.volume);
    for (const std::ptrdiff_t site : body_.sites())
      sum += 0.5 * body_.mass(site) * offset(x, site).squaredNorm();
    return sum;
  }

  /// |grad g|.
  double residual(const Field<double>& x, const Field<double>& v) {
    system_.force(0, x, v, force_);
    double sum = 0;
    for (const std::ptrdiff_t site : body_.sites())
      sum += (body_.mass(site) * offset(x, site) - dt_ * dt_ * force_.at(site)).squaredNorm();
    return std::sqrt(sum);
  }

  /// Change of momentum over sum m |v|.
  double momentum_change(const State<double>& after) const {
    Vec3 change = Vec3::Zero();
    double size = 0;
    for (const std::ptrdiff_t site : body_.sites()) {
      change += body_.mass(site) * (after.v.at(site) - before_.v.at(site));
      size += body_.mass(site) * after.v.at(site).norm();
    }
    return change.norm() / size;
  }

  double spin_change(const State<double>& after) const {
    const Vec3 spin = spin_of(before_);
    return (spin_of(after) - spin).norm() / spin.norm();
  }

 private:
  Vec3 offset(const Field<double>& x, std::ptrdiff_t site) const {
    return x.at(site) - before_.x.at(site) - dt_ * before_.v.at(site);
  }

  /// Angular momentum about the centre of mass.
  Vec3 spin_of(const State<double>& state) const {
    Vec3 middle = Vec3::Zero(), momentum = Vec3::Zero(), spin = Vec3::Zero();
    for (const std::ptrdiff_t site : body_.sites()) {
      middle += body_.mass(site) / body_.total_mass() * state.x.at(site);
      momentum += body_.mass(site) / body_.total_mass() * state.v.at(site);
    }
    for (const std::ptrdiff_t site : body_.sites())
      spin += body_.mass(site) * (state.x.at(site) - middle).cross(state.v.at(site) - momentum);
    return spin;
  }

  Body body_;
  SpringSystem<double> system_;
  State<double> before_;
  Field<double> force_;
  double dt_ = 0;
};

/// What a solver reaches after so many iterations.
struct Reached {
  Status status = Status::ok;
  Quartiles seconds{};
  double objective = no_value, residual = no_value, momentum = no_value, spin = no_value;
};

Reached reach(Problem& p, const SolverPair& solver, int iterations, int repetitions) {
  IntegratorOptions options{.dt = p.dt()};
  if (!solver.nonlinear.empty()) options.nonlinear_solver = solver.nonlinear;
  options.iterations = iterations;
  if (!solver.linear.empty()) options.linear_solver = solver.linear;
  Reached reached;
  State<double> state;
  std::vector<double> seconds;
  for (int i = 0; i < repetitions; ++i) {
    state = p.before();
    Work work;
    seconds.push_back(processor_seconds_of([&] {
      reached.status = find_integrator(solver.method)
                           .make<double>(options)
                           ->advance(p.system(), state, state.t + p.dt(), work);
    }));
  }
  reached.seconds = quartiles(seconds);
  if (reached.status != Status::ok && reached.status != Status::newton_stalled) return reached;
  reached.objective = p.objective(state.x);
  reached.residual = p.residual(state.x, state.v);
  reached.momentum = p.momentum_change(state);
  reached.spin = p.spin_change(state);
  if (!std::isfinite(reached.objective)) reached = {.status = Status::non_finite, .seconds = reached.seconds};
  return reached;
}

Table empty_rows() {
  return Table({{"start"},
                {"dt_omega"},
                {"solver"},
                {"iterations"},
                {"seconds", "s"},
                {"q1", "s"},
                {"q3", "s"},
                {"gap"},
                {"residual"},
                {"momentum_change"},
                {"spin_change"},
                {"status"}});
}

/// All solvers on one step; false if stopped, with nothing added.
bool measure_step(const ConvergenceConfig& config, Problem& p, const std::string& start, double dt_omega,
                  Table& rows, const Progress& progress) {
  p.set_step(dt_omega);
  std::vector<Reached> all;
  for (const SolverPair& solver : config.solvers)
    for (const int iterations : config.iterations) {
      if (progress.stopped()) return false;
      all.push_back(reach(p, solver, iterations, config.repetitions));
    }
  double lowest = std::numeric_limits<double>::infinity();
  for (const Reached& r : all)
    if (std::isfinite(r.objective)) lowest = std::min(lowest, r.objective);
  const State<double> inertial = p.inertial();
  const double span = p.objective(inertial.x) - lowest, slope = p.residual(inertial.x, inertial.v);
  std::size_t next = 0;
  for (const SolverPair& solver : config.solvers)
    for (const int iterations : config.iterations) {
      const Reached& r = all[next++];
      rows.add({start, dt_omega, solver.name(), iterations, r.seconds.median, r.seconds.q1, r.seconds.q3,
                (r.objective - lowest) / span, r.residual / slope, r.momentum, r.spin,
                std::string(to_string(r.status))});
    }
  return true;
}

Json configuration(const ConvergenceConfig& c) {
  Json starts = Json::object(), solvers = Json::array();
  for (const std::string& name : c.starts) starts[name] = find_start(name).description;
  for (const SolverPair& solver : c.solvers) solvers.push_back(solver.name());
  return {
      {"body", fmt::format("free cube, 1 m, {} cells an edge, E = 100 kPa, nu = 0.3, 1000 kg/m^3, undamped, "
                           "no gravity, in motion and turning",
                           c.cells)},
      {"step", "one step of backward Euler, from x_0 and v_0"},
      {"starts", starts},
      {"dt_omega", c.dt_omega},
      {"solvers", solvers},
      {"iterations", c.iterations},
      {"repetitions", c.repetitions},
      {"threads", c.threads}};
}

constexpr const char* caption =
    "One step of backward Euler from five hard states of a free cube, by every nonlinear solver, Newton's "
    "method with every linear solver, and by xpbd and vbd, which are meant to lead there. The step minimises "
    "an objective, kinetic and potential; the gap is how far the objective is above the lowest value that "
    "any "
    "solver reached, divided by how far it was at the start, where every particle keeps its velocity. Times "
    "are processor time on one thread, medians of a whole step with its set-up. A solver is stopped after so "
    "many iterations "
    "and keeps what it has; a marker is such a run, a black one on the upper edge a run that failed. Values "
    "below 1e-12 are rounding and not drawn. Free bodies have a constant linear momentum, which all solvers "
    "but vbd keep in every iteration; spin, in the table, is lost by backward Euler itself, so that a "
    "converged step loses some too. Bodies and scenes: frame after frame of 1/60 s, each from the converged "
    "step before it, the distance from the converged step, which Newton's method confirms "
    "(convergence_references.csv), over the largest displacement in a frame until then, median over six "
    "frames; costs in steps of semi-implicit Euler of the same body, medians of ratios within a round, an "
    "iteration as the difference of seven and two; times of scenes are of a step after set-up. Bodies are "
    "held, of 10 MPa and a damping ratio of 0.5, and begin in a motion that "
    "bends and shears them.";

std::string step_lines(const Table& bodies) {
  std::string lines;
  for (std::size_t r = 0; r < bodies.size(); ++r)
    lines += fmt::format("{:<22} {:<20} {}; an iteration takes {:.3g} explicit steps\n",
                         bodies.text(r, "scene"), bodies.text(r, "solver"),
                         bodies.text(r, "status") != "ok"
                             ? bodies.text(r, "status")
                             : fmt::format("1 / 0.1 percent in {:.1f} / {:.1f} iterations",
                                           bodies.number(r, "iterations_to_1_percent"),
                                           bodies.number(r, "iterations_to_1_permille")),
                         bodies.number(r, "iteration"));
  return lines;
}

ExperimentResult run_convergence(const ExperimentOptions& options, Progress& progress) {
  const ConvergenceConfig config = convergence_config(options);
  const StepsConfig steps_of = steps_config(options);
  const ConvergenceTables tables = measure_convergence(config, progress);
  const Table summary = convergence_summary(tables.rows);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config)};
  result.configuration["steps"] = step_configuration(steps_of);
  for (std::size_t r = 0; r < summary.size(); ++r)
    if (summary.number(r, "dt_omega") == charted_dt_omega)
      result.summary +=
          fmt::format("{:<22} {:<20} {}\n", summary.text(r, "start"), summary.text(r, "solver"),
                      summary.text(r, "status") != "ok"
                          ? summary.text(r, "status")
                          : fmt::format("1 percent in {} iterations, {:.3g} ms",
                                        summary.number(r, "iterations"), 1e3 * summary.number(r, "seconds")));
  result.tables = convergence_files(config, tables.rows);
  const StepTables steps = measure_steps(steps_of, progress);
  if (progress.stopped()) result.status = Status::interrupted;
  result.summary += step_lines(steps.bodies);
  for (NamedTable& table : step_files(steps)) result.tables.push_back(std::move(table));
  return result;
}

/// The rows of one start, step and solver as points; those without a solution and rounding are left out.
std::vector<ChartPoint> points(const Table& rows, const std::string& solver, const char* x, double scale,
                               const char* y) {
  std::vector<ChartPoint> result;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.text(r, "solver") == solver && rows.number(r, y) > smallest_gap)
      result.push_back({scale * rows.number(r, x), rows.number(r, y)});
  return result;
}

/// One series a solver that reached anything, in a style that it has in all charts, and markers on the upper
/// edge for runs that failed.
void add_series(Chart& chart, const Table& rows, const std::vector<std::string>& solvers, const char* x,
                double scale, const char* y) {
  for (std::size_t i = 0; i < solvers.size(); ++i) {
    chart.series.push_back(
        {.label = solvers[i], .points = points(rows, solvers[i], x, scale, y), .style = int(i)});
    if (chart.series.back().points.empty()) chart.series.pop_back();
  }
  std::map<std::string, std::vector<ChartPoint>> failed;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (const std::string& status = rows.text(r, "status"); status != "ok")
      failed[rows.text(r, "solver") + ": " + status].push_back({scale * rows.number(r, x), chart.y.high});
  for (const auto& [reason, points] : failed)
    chart.series.push_back({.label = reason, .points = points, .lines = false});
}

Chart base_chart(const Table& settings, const std::string& start, double dt_omega) {
  Chart chart;
  chart.subtitle = fmt::format("one step of backward Euler, dt ω = {:g}; free cube of {:g} cells an edge, {}",
                               dt_omega, setting_number(settings, "cells"), find_start(start).description);
  return chart;
}

Chart gap_chart(const Table& rows, const Table& settings, const std::string& start) {
  Chart chart = base_chart(settings, start, charted_dt_omega);
  chart.title = "How near the solution of a hard step, against time";
  chart.x = {.label = "processor time, set-up included [ms]", .logarithmic = true};
  chart.y = {.label = "objective gap / gap at the start", .logarithmic = true, .high = 10};
  add_series(chart, rows.where("start", start).where("dt_omega", charted_dt_omega), rows.distinct("solver"),
             "seconds", 1e3, "gap");
  return chart;
}

Chart iterations_chart(const Table& rows, const Table& settings, double dt_omega) {
  Chart chart = base_chart(settings, "twisted", dt_omega);
  chart.title = "How near the solution of a hard step, against iterations";
  chart.x = {.label = "iterations", .logarithmic = true};
  chart.y = {.label = "residual / residual at the start", .logarithmic = true, .high = 10};
  add_series(chart, rows.where("start", "twisted").where("dt_omega", dt_omega), rows.distinct("solver"),
             "iterations", 1, "residual");
  return chart;
}

/// What a step that is stopped early does not keep.
Chart momentum_chart(const Table& rows, const Table& settings) {
  Chart chart = base_chart(settings, "twisted", charted_dt_omega);
  chart.title = "What a step that is stopped early changes of the linear momentum";
  chart.x = {.label = "iterations", .logarithmic = true};
  chart.y = {.label = "change of the linear momentum, relative", .logarithmic = true, .high = 10};
  add_series(chart, rows.where("start", "twisted").where("dt_omega", charted_dt_omega),
             rows.distinct("solver"), "iterations", 1, "momentum_change");
  return chart;
}

/// Time to a gap of 1 percent from every start with the longest two steps.
Chart starts_chart(const Table& summary, const Table& settings) {
  std::vector<double> steps = summary.distinct_numbers("dt_omega");
  if (steps.size() > 2) steps.erase(steps.begin(), steps.end() - 2);
  std::vector<std::string> names;
  std::vector<Table> rows;
  for (const std::string& start : summary.distinct("start"))
    for (const double dt_omega : steps) {
      names.push_back(fmt::format("{}, {:g}", start, dt_omega));
      std::replace(names.back().begin(), names.back().end(), '_', ' ');
      rows.push_back(summary.where("start", start).where("dt_omega", dt_omega));
    }
  Chart chart = time_to_percent(names, rows, summary.distinct("solver"));
  chart.title = "Time to within 1 percent of the solution of a hard step";
  chart.subtitle = fmt::format("start, dt w of one step of backward Euler; free cube of {:g} cells an edge",
                               setting_number(settings, "cells"));
  chart.x.label = "processor time, set-up included [ms]";
  return chart;
}

Drawings draw_convergence(const std::vector<NamedTable>& tables) {
  const Table& rows = find_table(tables, "convergence");
  const Table& settings = find_table(tables, "convergence_settings");
  Drawings drawings{
      .charts = {{"convergence", gap_chart(rows, settings, "twisted")},
                 {"convergence_starts", starts_chart(find_table(tables, "convergence_summary"), settings),
                  "convergence_summary"},
                 {"convergence_iterations", iterations_chart(rows, settings, charted_dt_omega)},
                 {"convergence_momentum", momentum_chart(rows, settings)}}};
  for (NamedChart& chart : step_charts(tables)) drawings.charts.push_back(std::move(chart));
  std::erase_if(drawings.charts, [](const NamedChart& chart) { return !has_points(chart.chart); });
  return drawings;
}

/// Gaps of few iterations are the same on every machine.
Table baseline_table(const BaselineOptions& options, Progress& progress) {
  ConvergenceConfig config = convergence_config({.quick = true});
  if (options.quick) config.starts = {"twisted"};
  config.dt_omega = {30, 300};
  config.iterations = {1, 3};  // later ones depend on rounding
  config.repetitions = 1;
  config.threads = options.threads;
  return measure_convergence(config, progress)
      .rows.select({"start", "dt_omega", "solver", "iterations", "gap", "momentum_change", "status"});
}

}  // namespace

Chart time_to_percent(const std::vector<std::string>& names, const std::vector<Table>& tables,
                      const std::vector<std::string>& solvers) {
  double latest = 1e-3;
  for (const Table& rows : tables)
    for (std::size_t r = 0; r < rows.size(); ++r) latest = std::fmax(latest, 1e3 * rows.number(r, "seconds"));
  const double edge = std::pow(10, std::ceil(std::log10(latest)));
  Chart chart{.title = "",
              .subtitle = "",
              .x = {.label = "", .logarithmic = true, .high = 10 * edge},
              .y = named_rows(names),
              .lines = {{ReferenceLine::Direction::vertical, edge, "not within 1 percent, or stalled"}}};
  for (std::size_t i = 0; i < solvers.size(); ++i) {
    ChartSeries series{.label = solvers[i], .style = int(i), .joined = false};
    for (std::size_t row = 0; row < tables.size(); ++row) {
      const Table of_solver = tables[row].where("solver", solvers[i]);
      if (of_solver.size() == 0) continue;
      const bool ok = of_solver.text(0, "status") == "ok";
      const double right = edge * std::pow(10, (double(i) + 1) / (double(solvers.size()) + 1));
      series.points.push_back(
          {ok ? 1e3 * of_solver.number(0, "seconds") : right, double(tables.size() - row)});
    }
    chart.series.push_back(std::move(series));
  }
  return chart;
}

std::vector<SolverPair> all_solvers() {
  std::vector<SolverPair> all;
  for (const LinearSolverInfo& linear : linear_solvers())  // separable refuses the start with weights
    if (linear.name != "automatic" && linear.name != "separable") all.push_back({"newton", linear.name});
  for (const NonlinearSolverInfo& solver : nonlinear_solvers())
    if (solver.name != "newton") all.push_back({solver.name});
  for (const char* method : {"xpbd", "vbd"}) all.push_back({.method = method});
  return all;
}

std::vector<std::string> convergence_scene_names() {
  std::vector<std::string> names;
  for (const Start& start : all_starts()) names.emplace_back(start.name);
  for (const std::string& name : step_scene_names()) names.push_back(name);
  return names;
}

ConvergenceConfig convergence_config(const ExperimentOptions& options) {
  ConvergenceConfig config;
  if (options.cells.size() > 1)
    throw InputError(
        fmt::format("--cells: one size, as the charts are of one body; {} were given", options.cells.size()));
  if (!options.cells.empty()) config.cells = options.cells.front();
  check_scenes(options.scenes, convergence_scene_names());
  for (const Start& start : all_starts())
    if (options.scenes.empty() || std::count(options.scenes.begin(), options.scenes.end(), start.name) > 0)
      config.starts.emplace_back(start.name);
  config.dt_omega = {3, 30, 300, 3000};
  config.solvers = all_solvers();
  config.iterations = {1, 2, 3, 5, 10, 20, 50};
  if (options.quick) {
    config.cells = options.cells.empty() ? 4 : config.cells;
    config.repetitions = 1;
  }
  return config;
}

ConvergenceTables measure_convergence(const ConvergenceConfig& config, Progress& progress) {
  ConvergenceTables tables{empty_rows()};
  const double total = double(config.starts.size() * config.dt_omega.size());
  double done = 0;
  for (const std::string& start : config.starts) {
    Problem problem(config, find_start(start));
    for (const double dt_omega : config.dt_omega) {
      progress.report(done++ / total, fmt::format("{}, dt w = {:g}", start, dt_omega));
      if (!measure_step(config, problem, start, dt_omega, tables.rows, progress)) {
        tables.status = Status::interrupted;
        return tables;
      }
    }
  }
  return tables;
}

Table convergence_summary(const Table& rows) {
  constexpr double near = 0.01;
  Table summary({{"start"}, {"dt_omega"}, {"solver"}, {"iterations"}, {"seconds", "s"}, {"status"}});
  for (const std::string& start : rows.distinct("start"))
    for (const double dt_omega : rows.distinct_numbers("dt_omega"))
      for (const std::string& solver : rows.distinct("solver")) {
        const Table runs = rows.where("start", start).where("dt_omega", dt_omega).where("solver", solver);
        if (runs.size() == 0) continue;
        std::string status = fmt::format("gap above 1 percent after {} iterations",
                                         runs.number(runs.size() - 1, "iterations"));
        double iterations = no_value, seconds = no_value;
        for (std::size_t r = runs.size(); r-- > 0;) {
          if (!(runs.number(r, "gap") <= near)) break;
          iterations = runs.number(r, "iterations");
          seconds = runs.number(r, "seconds");
          status = "ok";
        }
        if (const std::string& last = runs.text(runs.size() - 1, "status"); status != "ok" && last != "ok")
          status = last;
        summary.add({start, dt_omega, solver, iterations, seconds, status});
      }
  return summary;
}

std::vector<NamedTable> convergence_files(const ConvergenceConfig& config, const Table& rows) {
  return {{"convergence", rows},
          {"convergence_summary", convergence_summary(rows)},
          {"convergence_settings", settings_table({{"cells", std::int64_t(config.cells)}})}};
}

ExperimentInfo experiment() {
  return {.name = "convergence",
          .summary =
              "implicit steps, hard ones and those of many bodies: distance from the solution against "
              "iterations and time, every solver",
          .accepts = {.cells = true, .largest_cells = 20, .scenes = convergence_scene_names},
          .run = run_convergence,
          .draw = draw_convergence,
          .baseline = {.keys = {"start", "dt_omega", "solver", "iterations"},
                       .rules = {{"gap", 1e-2, 1e-4}, {"momentum_change", 0, 1e-7}},
                       .table = baseline_table}};
}

}  // namespace mss::studies::convergence

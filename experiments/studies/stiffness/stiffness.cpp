// Stiff bodies: the cost of CVODE's BDF with each linear solver, against Young's modulus and size, for the
// same frame of 1/60 s of a damped cube. Adams and an explicit method at its safe step need no linear solver:
// they show from which stiffness on BDF is worth its cost.
#include "experiments/studies/stiffness/stiffness.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "experiments/harness/measure.hpp"
#include "experiments/harness/settings.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/simulation.hpp"
#include "integrators/analysis/stable_step.hpp"

namespace mss::studies::stiffness {

namespace {

constexpr const char* cholmod = "cvode_bdf/cholmod";
constexpr const char* klu = "cvode_bdf_klu";

BodyConfig cube(const StiffnessConfig& config, int n, double young) {
  BodyConfig body{.voxels = VoxelGrid::box(n, n, n), .cell_size = 1.0 / n};
  body.fill({.young = young, .poisson = 0.3}, 0.5);
  body.damping = {.law = Damping::Law::ratio, .zeta = config.damping_ratio};
  return body;
}

/// A stretched cube of one size and stiffness, its bottom held.
struct Problem {
  Problem(const StiffnessConfig& c, int n, double young)
      : config(c),
        body(cube(c, n, young)),
        owned(make_system<double>(c.model, body,
                                  {.gravity = Vec3(0, 0, -9.81), .holds = {{.box = {{0, 0, 0}, {1, 1, 0}}}}},
                                  c.threads)),
        system(*owned),
        start(stretched_state(system, c.stretch)) {}
  const StiffnessConfig& config;
  Body body;
  std::unique_ptr<BodySystem<double>> owned;
  BodySystem<double>& system;
  State<double> start;
};

/// Results of the repetitions of one method.
struct Result {
  Status status = Status::ok;
  Work work{};
  std::vector<double> seconds{};
  Field<double> x{};  ///< at the end
};

void run(Problem& p, const StiffMethod& method, Result& result) {
  const IntegratorInfo& info = find_integrator(method.integrator);
  IntegratorOptions options{.dt = 0, .tolerance = p.config.tolerance};
  if (info.stepping == Stepping::fixed) {
    const double safe = safe_share * stable_step(info, p.system.spectral_bound());
    options.dt = p.config.duration / std::ceil(p.config.duration / safe);
  }
  if (!method.linear_solver.empty()) options.linear_solver = method.linear_solver;
  scale_errors(options, p.system);
  State<double> state = p.start;
  result.work = {};
  std::unique_ptr<Integrator<double>> integrator;
  Status status = Status::ok;
  result.seconds.push_back(seconds_of([&] {
    integrator = info.make<double>(options);
    status = integrator->advance(p.system, state, p.config.duration, result.work);
  }));
  if (result.status == Status::ok) result.status = status;  // one failure is enough
  result.x = std::move(state.x);
}

double largest_difference(const Field<double>& a, const Field<double>& b) {
  return (a.array() - b.array()).abs().maxCoeff();
}

/// One row per method. Final states are compared with that of the first method that did not fail.
void add_rows(Table& rows, const Problem& p, int n, double young, const std::vector<StiffMethod>& methods,
              const std::vector<Result>& results) {
  const double omega = p.system.spectral_bound().omega;
  const auto first =
      std::find_if(results.begin(), results.end(), [](const Result& r) { return r.status == Status::ok; });
  for (std::size_t i = 0; i < methods.size(); ++i) {
    const Result& r = results[i];
    const double difference =
        r.status == Status::ok ? largest_difference(r.x, first->x) / largest_difference(p.start.x, first->x)
                               : no_value;
    const Quartiles time = quartiles(r.seconds);
    std::vector<Cell> row{methods[i].name(), n,       young,   omega * p.config.duration,
                          time.median,       time.q1, time.q3, std::int64_t(r.seconds.size())};
    for (Cell& cell : work_cells(r.work)) row.push_back(std::move(cell));
    row.insert(row.end(), {difference, std::string(to_string(r.status))});
    rows.add(std::move(row));
  }
}

/// Interleaves all methods; false if stopped.
bool measure_body(const StiffnessConfig& config, int n, double young, Table& rows, const Progress& progress) {
  Problem p(config, n, young);
  std::vector<StiffMethod> methods;
  for (const StiffMethod& m : config.methods)
    if (n <= m.largest_cells) methods.push_back(m);
  std::vector<Result> results(methods.size());
  if (!interleave(config.repetitions, methods.size(), progress,
                  [&](std::size_t i) { run(p, methods[i], results[i]); }))
    return false;
  add_rows(rows, p, n, young, methods, results);
  return true;
}

Table empty_rows() {
  std::vector<Column> columns{{"method"},       {"cells"},   {"young", "Pa"}, {"omega_duration"},
                              {"seconds", "s"}, {"q1", "s"}, {"q3", "s"},     {"repeats"}};
  for (Column& column : work_columns()) columns.push_back(std::move(column));
  columns.insert(columns.end(), {{"difference"}, {"status"}});
  return Table(std::move(columns));
}

/// Times of a method at one size, by stiffness, without failed runs.
std::vector<ChartPoint> times(const Table& rows, const std::string& method, int cells) {
  std::vector<ChartPoint> points;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.text(r, "method") == method && rows.number(r, "cells") == cells &&
        rows.text(r, "status") == "ok")
      points.push_back(
          {rows.number(r, "young"), rows.number(r, "seconds"), rows.number(r, "q1"), rows.number(r, "q3")});
  return points;
}

/// Times of a method divided by CHOLMOD's at the same size and stiffness.
std::vector<ChartPoint> ratios(const Table& rows, const std::string& method, int cells) {
  std::vector<ChartPoint> points;
  for (const ChartPoint& p : times(rows, method, cells))
    for (const ChartPoint& q : times(rows, cholmod, cells))
      if (p.x == q.x) points.push_back({p.x, p.y / q.y});
  return points;
}

std::vector<int> sizes(const Table& rows) {
  const std::vector<double> cells = rows.distinct_numbers("cells");
  return {cells.begin(), cells.end()};
}

std::pair<double, double> range_of(const std::vector<ChartPoint>& points) {
  if (points.empty()) return {no_value, no_value};
  const auto [low, high] = std::minmax_element(
      points.begin(), points.end(), [](const ChartPoint& a, const ChartPoint& b) { return a.y < b.y; });
  return {low->y, high->y};
}

Json configuration(const StiffnessConfig& c, const LinearSolveConfig& linear,
                   const CrossoverConfig& crossover) {
  Json methods = Json::array();
  for (const StiffMethod& m : c.methods)
    methods.push_back({{"name", m.name()}, {"largest_cells", m.largest_cells}});
  return {{"body", "cube of 1 m, nu = 0.3, density 1000 kg/m^3, its bottom held, under gravity"},
          {"model", c.model},
          {"stretch_z", c.stretch},
          {"damping_ratio", c.damping_ratio},
          {"cells", c.cells},
          {"young", c.young},
          {"methods", methods},
          {"duration", c.duration},
          {"tolerance", c.tolerance},
          {"repetitions", c.repetitions},
          {"order", "methods in turn, the first one changing from repetition to repetition"},
          {"threads", c.threads},
          {"linear_solvers",
           {{"body", "cube of 1 m, bent by 0.5 rad, stretched by 10 %, noise of 0.01 cells, its bottom held"},
            {"damping_ratio", 0.01},
            {"solvers", linear.solvers},
            {"cells", linear.cells},
            {"dt_omega", linear.dt_omega},
            {"poisson", linear.poisson},
            {"poisson_cells", linear.poisson_cells},
            {"more_poisson", linear.more_poisson},
            {"tolerance", linear.tolerance},
            {"repetitions", linear.repetitions},
            {"seconds_per_row", linear.seconds_per_row}}},
          {"crossover",
           {{"body", "the same without noise"},
            {"implicit", crossover.implicit},
            {"cells", crossover.cells},
            {"dt_omega", crossover.dt_omega},
            {"frame", crossover.frame},
            {"repetitions", crossover.repetitions},
            {"seconds_per_row", crossover.seconds_per_row}}}};
}

constexpr const char* caption =
    "Wall time of one frame of 1/60 s of a damped cube (damping ratio 0.5 of every spring), stretched by 10 "
    "% and "
    "released, against Young's modulus: CVODE's BDF with each linear solver at the same tolerance, "
    "CVODE's Adams method, which needs none, and damped Verlet at its safe step. Medians of interleaved "
    "runs, including "
    "setup; one thread. The column difference is the distance between a method's final state and that of the "
    "first "
    "method, divided by the distance that the body moved. KLU factors the whole first-order system and is "
    "left "
    "out above 7 cells per edge. Not varied: undamped bodies, whose vibrations BDF would have to resolve. "
    "Linear "
    "solvers alone are compared on one solve of an implicit step, and one step of backward Euler with the "
    "fastest of them with the explicit steps of the same 1/60 s.";

std::string crossover_sentence(const Table& summary, std::size_t row) {
  const double from = summary.number(row, "cheaper_from_dt_omega");
  return fmt::format("n = {:<3} implicit step of 1/60 s ({}) and the explicit ones it replaces: {}\n",
                     summary.number(row, "cells"), summary.text(row, "step"),
                     std::isnan(from) ? summary.text(row, "status")
                                      : fmt::format("cheaper from dt omega = {:.0f} on", from));
}

ExperimentResult run_stiffness(const ExperimentOptions& options, Progress& progress) {
  const StiffnessConfig config = stiffness_config(options);
  const LinearSolveConfig linear = linear_solve_config(options);
  const CrossoverConfig crossover = crossover_config(options);
  const StiffnessTables tables = measure_stiffness(config, progress);
  ExperimentResult result{
      .status = tables.status, .caption = caption, .configuration = configuration(config, linear, crossover)};
  result.tables = stiffness_files(config, tables.rows);
  const Table& summary = find_table(result.tables, "stiffness_summary");
  for (std::size_t r = 0; r < summary.size(); ++r)
    result.summary += fmt::format("n = {:<3} {}\n", summary.number(r, "cells"), summary.text(r, "sentence"));
  Table solves = measure_linear_solves(linear, progress), frames = measure_crossover(crossover, progress);
  if (progress.stopped()) result.status = Status::interrupted;
  result.tables.push_back({"stiffness_solver_ratios", linear_solve_ratios(solves)});
  result.tables.push_back({"stiffness_solvers", std::move(solves)});
  const Table cheaper = crossover_summary(frames);
  for (std::size_t r = 0; r < cheaper.size(); ++r) result.summary += crossover_sentence(cheaper, r);
  result.tables.push_back({"stiffness_crossover_summary", cheaper});
  result.tables.push_back({"stiffness_crossover", std::move(frames)});
  return result;
}

std::string sentence(const std::string& competitor, double from, double low, double high) {
  const std::string faster = std::isnan(from) ? "is faster than CHOLMOD at the largest stiffness"
                             : from == 0      ? "is slower than CHOLMOD at every stiffness"
                                         : fmt::format("is slower than CHOLMOD from E = {:.2g} Pa on", from);
  return fmt::format("{} {}; it takes {:.3g} to {:.3g} times as long", competitor, faster, low, high);
}

}  // namespace

StiffnessConfig stiffness_config(const ExperimentOptions& options) {
  StiffnessConfig config;
  config.cells = options.cells;
  config.model = options.model;
  if (config.cells.empty()) config.cells = options.quick ? std::vector<int>{3, 5} : std::vector<int>{3, 5, 7};
  for (int decade = 4; decade <= 10; ++decade) config.young.push_back(std::pow(10.0, decade));
  constexpr int any = std::numeric_limits<int>::max();
  for (const std::string& linear : compared_solvers())
    if (linear != "separable") config.methods.push_back({"cvode_bdf", linear, any});  // for boxes alone
  config.methods.push_back({"cvode_bdf_gmres", "", any});
  config.methods.push_back({klu, "", 7});
  config.methods.push_back({"cvode_adams", "", any});
  config.methods.push_back({"damped_verlet", "", any});
  return config;
}

LinearSolveConfig linear_solve_config(const ExperimentOptions& options) {
  LinearSolveConfig config;
  config.model = options.model;
  config.solvers = compared_solvers(options.model);
  if (options.quick) {
    config.cells = {5, 10};
    config.repetitions = 3;
  }
  if (!options.cells.empty()) config.cells = options.cells;
  constexpr int most = 20;  // larger ones would take long
  config.poisson_cells = 0;
  for (const int n : config.cells)
    if (n <= most) config.poisson_cells = std::max(n, config.poisson_cells);
  return config;
}

CrossoverConfig crossover_config(const ExperimentOptions& options) {
  CrossoverConfig config;
  config.model = options.model;
  if (options.quick) {
    config.cells = {5, 10};
    config.repetitions = 3;
  }
  if (!options.cells.empty()) config.cells = options.cells;
  return config;
}

StiffnessTables measure_stiffness(const StiffnessConfig& config, Progress& progress) {
  StiffnessTables tables{empty_rows()};
  const auto total = double(config.cells.size() * config.young.size());
  double done = 0;
  for (const int n : config.cells)
    for (const double young : config.young) {
      progress.report(done++ / total, fmt::format("{} cells per edge, E = {:g} Pa", n, young));
      if (!measure_body(config, n, young, tables.rows, progress)) {
        tables.status = Status::interrupted;
        return tables;
      }
    }
  return tables;
}

double last_crossing(const std::vector<ChartPoint>& ratios) {
  if (ratios.empty() || ratios.back().y <= 1) return no_value;
  for (std::size_t i = ratios.size() - 1; i-- > 0;) {
    const ChartPoint &a = ratios[i], &b = ratios[i + 1];
    if (a.y > 1) continue;
    return a.x * std::pow(b.x / a.x, std::log(1 / a.y) / std::log(b.y / a.y));
  }
  return 0;
}

Table stiffness_summary(const Table& rows) {
  Table summary(
      {{"cells"}, {"competitor"}, {"slower_from", "Pa"}, {"lowest"}, {"highest"}, {"sentence"}, {"status"}});
  for (const int n : sizes(rows))
    for (const std::string& competitor : rows.distinct("method")) {
      const std::vector<ChartPoint> times_as_long = ratios(rows, competitor, n);
      if (competitor == cholmod || times_as_long.empty()) continue;
      const double from = last_crossing(times_as_long);
      const auto [low, high] = range_of(times_as_long);
      summary.add({n, competitor, from, low, high, sentence(competitor, from, low, high),
                   std::string(std::isnan(from) ? "faster at the largest stiffness" : "ok")});
    }
  return summary;
}

Chart stiffness_overview(const Table& rows) {
  Chart chart{.title = "The best linear solver for BDF",
              .subtitle =
                  "CVODE's BDF, 1/60 s of a damped cube; PCG, whose iterations are those of matrix-free, is "
                  "left out",
              .x = {.label = "Young's modulus", .logarithmic = true, .unit = "Pa"},
              .y = {.label = "time / time with CHOLMOD", .logarithmic = true}};
  for (const auto& [method, name] :
       {std::pair{klu, "KLU"}, std::pair{"cvode_bdf_gmres", "GMRES"},
        std::pair{"cvode_bdf/matrix_free", "matrix-free"}, std::pair{"cvode_bdf/multigrid", "multigrid"}})
    for (const int n : sizes(rows))
      if (ChartSeries series{.label = fmt::format("{}, n = {}", name, n), .points = ratios(rows, method, n)};
          !series.points.empty())
        chart.series.push_back(std::move(series));
  chart.lines.push_back({ReferenceLine::Direction::horizontal, 1, "CHOLMOD", true});
  return chart;
}

std::vector<NamedTable> stiffness_files(const StiffnessConfig& config, const Table& rows) {
  return {{"stiffness", rows},
          {"stiffness_summary", stiffness_summary(rows)},
          {"stiffness_settings", settings_table({{"model", config.model}})}};
}

namespace {

Drawings draw_stiffness(const std::vector<NamedTable>& tables) {
  const Table& rows = find_table(tables, "stiffness");
  const std::string model = setting_text(find_table(tables, "stiffness_settings"), "model");
  Drawings drawings;
  if (rows.size() > 0) drawings.charts.push_back({"stiffness", stiffness_overview(rows)});
  for (const auto& [name, table] : tables) {  // results of earlier versions have none of these
    if (table.size() == 0) continue;
    if (name == "stiffness_solvers") drawings.charts.push_back({name, linear_solve_chart(table)});
    if (name == "stiffness_crossover") drawings.charts.push_back({name, crossover_chart(table)});
  }
  for (NamedChart& chart : drawings.charts) add_model_to_subtitle(chart.chart, model);
  return drawings;
}

/// Final states agree within the tolerance on every machine; counts and times need not.
Table baseline_table(const BaselineOptions& options, Progress& progress) {
  StiffnessConfig config =
      stiffness_config({.cells = options.quick ? std::vector<int>{3} : std::vector<int>{3, 7}});
  config.young = options.quick ? std::vector<double>{1e4, 1e7} : std::vector<double>{1e4, 1e6, 1e8};
  config.repetitions = 1;
  config.threads = options.threads;
  return measure_stiffness(config, progress)
      .rows.select({"method", "cells", "young", "omega_duration", "difference", "status"});
}

}  // namespace

ExperimentInfo experiment() {
  return {.name = "stiffness",
          .summary =
              "the cost of linear solvers and of CVODE's BDF with each; when implicit steps are cheaper than "
              "explicit ones",
          .accepts = {.cells = true, .largest_cells = 30, .model = true},
          .run = run_stiffness,
          .draw = draw_stiffness,
          .baseline = {.keys = {"method", "cells", "young"},
                       .rules = {{"omega_duration", 1e-10}, {"difference", 0, 2e-4}},
                       .table = baseline_table}};
}

}  // namespace mss::studies::stiffness

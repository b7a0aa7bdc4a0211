// One linear solve of an implicit step with every linear solver, against cells, Poisson's ratio and the
// length of the step: what it costs to prepare, to prepare again, and to solve.
#include <fmt/format.h>

#include <algorithm>

#include "experiments/harness/measure.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/studies/stiffness/bent_cube.hpp"
#include "experiments/studies/stiffness/stiffness.hpp"
#include "integrators/linear/linear_solver.hpp"

namespace mss::studies::stiffness {

namespace {

constexpr double young = 1e6;  ///< [Pa]; nothing depends on it
constexpr double noise = 0.01;
constexpr const char* compared_with = "matrix_free";

struct Case {
  int n;
  double poisson;
  double dt_omega;  ///< 0: static

  /// Whether slow solvers are tried in larger bodies too: in the case of the charts, and in statics.
  bool charted() const {
    return poisson == charted_poisson && (dt_omega == charted_dt_omega || dt_omega == 0);
  }
};

/// At each size all steps and a static solve; of large bodies nearly incompressible at the charted step only.
std::vector<Case> cases(const LinearSolveConfig& config) {
  std::vector<Case> all;
  for (const int n : config.cells) {
    for (const double poisson : config.poisson) {
      for (const double dt_omega : config.dt_omega)
        if (n <= config.poisson_cells || poisson == charted_poisson || dt_omega == charted_dt_omega)
          all.push_back({n, poisson, dt_omega});
      all.push_back({n, poisson, 0});
    }
    if (n != config.poisson_cells) continue;
    for (const double poisson : config.more_poisson) all.push_back({n, poisson, charted_dt_omega});
  }
  return all;
}

TangentCoefficients matrix_of(const Case& c, double omega) {
  if (c.dt_omega == 0) return {.stiffness = 1, .kind = Tangent::projected};
  const double dt = c.dt_omega / omega;
  return {.mass = 1, .damping = dt, .stiffness = dt * dt, .kind = Tangent::projected};
}

/// What was measured of one solver.
struct Samples {
  std::vector<double> total, setup, again, solve;  ///< [s]
  Work work;                                       ///< of the last one
  double residual = no_value;
  Status status = Status::ok;
  double spent = 0;  ///< [s]
};

/// |r - A y| / |r| over unknowns.
double relative_residual(System<double>& system, const State<double>& state, const TangentCoefficients& sum,
                         const Field<double>& rhs, const Field<double>& solution) {
  Field<double> difference(system.size()), right = rhs;
  tangents_of(system).product(0, state.x, state.v, sum, solution, difference);
  difference.array() -= rhs.array();
  system.clear_prescribed(difference);
  system.clear_prescribed(right);
  return difference.array().matrix().norm() / right.array().matrix().norm();
}

/// Prepares and solves with a new solver on a new system: what a solver keeps in the system counts too.
void take(const LinearSolveConfig& config, const LinearSolverInfo& info, const BentCube& cube, const Case& c,
          Samples& samples) {
  const auto owned = cube.system(config.model);
  BodySystem<double>& system = *owned;
  const TangentCoefficients sum = matrix_of(c, system.spectral_bound().omega);
  const State<double>& state = cube.state;
  Field<double> rhs(system.size()), solution(system.size());
  system.force(0, state.x, state.v, rhs);
  const auto solver = info.make(config.tolerance);
  Work work;
  const Stopwatch watch;
  const auto prepare = [&] {
    return seconds_of([&] {
      if (samples.status == Status::ok)
        samples.status = solver->prepare(system, 0, state.x, state.v, sum, work);
    });
  };
  const double setup = prepare(), again = prepare();
  const double solve = seconds_of([&] {
    if (samples.status == Status::ok) samples.status = solver->solve(rhs, solution, work);
  });
  samples.setup.push_back(setup);
  samples.again.push_back(again);
  samples.solve.push_back(solve);
  samples.total.push_back(setup + solve);
  samples.work = work;
  samples.residual = relative_residual(system, state, sum, rhs, solution);
  samples.spent += watch.seconds();
}

void add_row(Table& table, const std::string& solver, const Case& c, const Samples& s) {
  std::vector<Cell> row{solver, c.n, c.poisson, c.dt_omega};
  row.push_back(s.total.empty() ? Cell(no_value) : Cell(s.work.products));
  for (const std::vector<double>* sample : {&s.total, &s.setup, &s.again, &s.solve}) {
    const Quartiles q = quartiles(*sample);
    row.insert(row.end(), {q.median, q.q1, q.q3});
  }
  const std::string status = s.total.empty() ? "skipped: too large" : std::string(to_string(s.status));
  row.insert(row.end(), {s.residual, std::int64_t(s.total.size()), status});
  table.add(std::move(row));
}

/// Interleaves all solvers; false if stopped.
bool measure_case(const LinearSolveConfig& config, const Case& c, Table& table, const Progress& progress) {
  const BentCube cube(c.n, {.young = young, .poisson = c.poisson}, noise);
  std::vector<Samples> samples(config.solvers.size());
  const auto sample = [&](std::size_t i) {
    const LinearSolverInfo& info = find_linear_solver(config.solvers[i]);
    if (is_too_large(info.name, c.n, c.charted()) || samples[i].spent > config.seconds_per_row) return;
    take(config, info, cube, c, samples[i]);
  };
  if (!interleave(config.repetitions, samples.size(), progress, sample)) return false;
  for (std::size_t i = 0; i < samples.size(); ++i) add_row(table, config.solvers[i], c, samples[i]);
  return true;
}

/// Rows of a table that succeeded, as points of a series per solver.
std::vector<ChartSeries> series_of(const Table& rows, ChartPoint (*point)(const Table& rows, std::size_t r)) {
  std::vector<ChartSeries> all;
  int style = 0;  // of a solver the same on all charts
  for (const std::string& solver : rows.distinct("solver")) {
    ChartSeries series{.label = solver, .style = style++};
    for (std::size_t r = 0; r < rows.size(); ++r)
      if (rows.text(r, "solver") == solver && rows.text(r, "status") == "ok")
        series.points.push_back(point(rows, r));
    if (!series.points.empty()) all.push_back(std::move(series));
  }
  return all;
}

}  // namespace

std::vector<std::string> compared_solvers(const std::string& model) {
  std::vector<std::string> names;
  for (const LinearSolverInfo& info : linear_solvers()) {
    const bool refused = info.name == "separable" && model != spring_model;
    if (info.name != "automatic" && !refused) names.push_back(info.name);  // automatic is one of the others
  }
  return names;
}

bool is_too_large(const std::string& solver, int cells, bool charted) {
  if (solver == "cholmod") return cells > 20;
  if (solver == "pcg") return cells > (charted ? 40 : 20);
  if (solver == "matrix_free") return cells > (charted ? 60 : 20);
  return false;
}

Table measure_linear_solves(const LinearSolveConfig& config, Progress& progress) {
  std::vector<Column> columns{{"solver"}, {"cells"}, {"poisson"}, {"dt_omega"}, {"products"}};
  for (const std::string name : {"", "setup_", "repeated_setup_", "solve_"})
    columns.insert(columns.end(), {{name + "seconds", "s"}, {name + "q1", "s"}, {name + "q3", "s"}});
  columns.insert(columns.end(), {{"residual"}, {"repeats"}, {"status"}});
  Table table(std::move(columns));
  const std::vector<Case> all = cases(config);
  for (std::size_t i = 0; i < all.size(); ++i) {
    progress.report(double(i) / double(all.size()),
                    fmt::format("linear solvers, {} cells per edge", all[i].n));
    if (!measure_case(config, all[i], table, progress)) break;
  }
  return table;
}

Table linear_solve_ratios(const Table& rows) {
  Table ratios({{"solver"},
                {"cells"},
                {"poisson"},
                {"dt_omega"},
                {"over_matrix_free"},
                {"repeated_over_matrix_free"}});
  const auto repeated = [&](std::size_t row) {
    return rows.number(row, "repeated_setup_seconds") + rows.number(row, "solve_seconds");
  };
  for (std::size_t r = 0; r < rows.size(); ++r)
    for (std::size_t other = 0; other < rows.size(); ++other) {
      const auto equal = [&](const char* column) {
        return rows.number(r, column) == rows.number(other, column);
      };
      if (rows.text(other, "solver") == compared_with && rows.text(r, "solver") != compared_with &&
          rows.text(r, "status") == "ok" && rows.text(other, "status") == "ok" && equal("cells") &&
          equal("poisson") && equal("dt_omega"))
        ratios.add({rows.text(r, "solver"), rows.number(r, "cells"), rows.number(r, "poisson"),
                    rows.number(r, "dt_omega"), rows.number(r, "seconds") / rows.number(other, "seconds"),
                    repeated(r) / repeated(other)});
    }
  return ratios;
}

Chart linear_solve_chart(const Table& rows) {
  const Table charted = rows.where("poisson", charted_poisson).where("dt_omega", charted_dt_omega);
  Chart chart{
      .title = "Time of one linear solve of an implicit step",
      .subtitle =
          fmt::format("set-up and solve to 1e-6; Δt ω = {}, ν = {}; bent and stretched cube, one face "
                      "held; one thread; bars are quartiles",
                      charted_dt_omega, charted_poisson),
      .x = {.label = "cells per edge n", .logarithmic = true, .ticks = charted.distinct_numbers("cells")},
      .y = {.label = "set-up and solve", .logarithmic = true, .unit = "s"},
      .series = series_of(charted, [](const Table& t, std::size_t r) {
        return ChartPoint{t.number(r, "cells"), t.number(r, "seconds"), t.number(r, "q1"), t.number(r, "q3")};
      })};
  if (chart.x.ticks.empty()) return chart;
  chart.x.low = 0.9 * chart.x.ticks.front();
  chart.x.high = 1.1 * chart.x.ticks.back();
  return chart;
}

}  // namespace mss::studies::stiffness

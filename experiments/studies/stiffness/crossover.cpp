// From which stiffness on one implicit step of 1/60 s is cheaper than the explicit steps it replaces, and
// what error either makes in that time. The motion begins at rest in a bent, stretched shape; as nothing else
// acts, it depends on the product of the step and the largest frequency alone.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/harness/measure.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/simulation/explicit_steps.hpp"
#include "experiments/studies/stiffness/bent_cube.hpp"
#include "experiments/studies/stiffness/stiffness.hpp"

namespace mss::studies::stiffness {

namespace {

constexpr const char* reference_method = "damped_verlet";
constexpr double reference_share = 0.25;  ///< of the safe step; of second order, so a 16th of its error

/// A way to advance a frame, and what was measured of it.
struct Runner {
  std::string name;
  const IntegratorInfo* info = nullptr;
  IntegratorOptions options{};
  long steps = 1;
  std::vector<double> first = {};     ///< seconds of a frame by a new integrator
  std::vector<double> repeated = {};  ///< and of one by the same integrator later
  double error = no_value;
  Status status = Status::ok;
  double spent = 0;  ///< [s]

  double median() const { return status == Status::ok ? quartiles(repeated).median : no_value; }
};

Runner runner_of(const ExplicitSteps& choice) {
  return {
      .name = choice.info->name, .info = choice.info, .options = {.dt = choice.dt}, .steps = choice.steps};
}

/// A frame's motion of a cube whose largest frequency is dt_omega / frame.
struct Frame {
  Frame(const CrossoverConfig& config, int n, double dt_omega)
      : duration(config.frame),
        young(stiffness_for(config, n, dt_omega / config.frame)),
        cube(n, {.young = young, .poisson = charted_poisson}, 0),
        owned(cube.system(config.model)),
        system(*owned) {
    Runner reference = runner_of(explicit_steps(find_integrator(reference_method), system.spectral_bound(),
                                                duration, reference_share));
    State<double> end = advance(reference, *reference.info->make<double>(reference.options));
    if (reference.status == Status::ok) x_end = std::move(end.x);
  }

  /// Frequencies grow as the root of Young's modulus.
  static double stiffness_for(const CrossoverConfig& config, int n, double omega) {
    constexpr double probe = 1e6;
    const BentCube soft(n, {.young = probe, .poisson = charted_poisson}, 0);
    return probe * std::pow(omega / soft.system(config.model)->spectral_bound().omega, 2);
  }

  /// From the beginning to the end, which it returns.
  State<double> advance(Runner& runner, Integrator<double>& integrator) {
    State<double> state = cube.state;
    Work work;
    integrator.reset();
    const Status status = integrator.advance(system, state, duration, work);
    if (runner.status == Status::ok) runner.status = status;
    return state;
  }

  void take(Runner& runner) {
    State<double> end;
    std::unique_ptr<Integrator<double>> integrator;
    runner.first.push_back(seconds_of([&] {
      integrator = runner.info->make<double>(runner.options);
      end = advance(runner, *integrator);
    }));
    runner.repeated.push_back(seconds_of([&] { end = advance(runner, *integrator); }));
    runner.spent += runner.first.back() + runner.repeated.back();
    runner.error = error_of(end.x);
  }

  /// Root mean square of the distances from the reference, over that of how far it moved.
  double error_of(const Field<double>& x) const {
    if (x_end.size() == 0) return no_value;
    double distance = 0, moved = 0;
    for (const std::ptrdiff_t site : cube.body.sites()) {
      distance += (x.at(site) - x_end.at(site)).squaredNorm();
      moved += (cube.state.x.at(site) - x_end.at(site)).squaredNorm();
    }
    return std::sqrt(distance / moved);
  }

  double duration, young;
  BentCube cube;
  std::unique_ptr<BodySystem<double>> owned;
  BodySystem<double>& system;
  Field<double> x_end{};  ///< of the reference; empty if it failed
};

/// The cheapest explicit methods at their safe steps.
std::vector<Runner> explicit_runners(Frame& frame) {
  std::vector<Runner> runners;
  for (const ExplicitSteps& choice : cheapest_explicit_steps(frame.system, frame.cube.state, frame.duration))
    runners.push_back(runner_of(choice));
  return runners;
}

/// An implicit step with every linear solver that is not too large.
std::vector<Runner> implicit_runners(const CrossoverConfig& config, int n) {
  std::vector<Runner> all;
  for (const std::string& solver : compared_solvers(config.model))
    if (!is_too_large(solver, n, false))
      all.push_back({.name = config.implicit + "/" + solver,
                     .info = &find_integrator(config.implicit),
                     .options = {.dt = config.frame,
                                 .linear_solver = solver,
                                 .tangent = Tangent::projected,
                                 .linear_tolerance = 1e-6}});
  return all;
}

const Runner& fastest(const std::vector<Runner>& runners) {
  return *std::min_element(runners.begin(), runners.end(), [](const Runner& a, const Runner& b) {
    return a.median() < b.median() || (!std::isnan(a.median()) && std::isnan(b.median()));
  });
}

std::string status_of(const Frame& frame, const Runner& implicit, const Runner& best) {
  if (frame.x_end.size() == 0) return "the reference failed";
  return std::string(to_string(implicit.status != Status::ok ? implicit.status : best.status));
}

void add_row(Table& table, int n, double dt_omega, const Frame& frame, const Runner& implicit,
             const Runner& best) {
  std::vector<Cell> row{n, dt_omega, frame.young};
  for (const Runner* runner : {&implicit, &best}) {
    const Quartiles time = quartiles(runner->repeated);
    row.insert(row.end(),
               {runner->name, std::int64_t(runner->steps), time.median, time.q1, time.q3, runner->error});
  }
  const Quartiles over_repeated = quartiles_of_ratio(best.repeated, implicit.repeated),
                  over_first = quartiles_of_ratio(best.first, implicit.first);
  row.insert(row.end(), {over_repeated.median, over_repeated.q1, over_repeated.q3,
                         quartiles(implicit.first).median, over_first.median, over_first.q1, over_first.q3,
                         std::int64_t(std::min(implicit.repeated.size(), best.repeated.size())),
                         status_of(frame, implicit, best)});
  table.add(std::move(row));
}

/// Interleaves all methods; false if stopped.
bool measure_frame(const CrossoverConfig& config, int n, double dt_omega, Table& table,
                   const Progress& progress) {
  Frame frame(config, n, dt_omega);
  std::vector<Runner> implicit = implicit_runners(config, n), explicit_ones = explicit_runners(frame);
  const auto take = [&](std::size_t i) {
    Runner& runner = i < implicit.size() ? implicit[i] : explicit_ones[i - implicit.size()];
    if (runner.spent < config.seconds_per_row) frame.take(runner);
  };
  if (!interleave(config.repetitions, implicit.size() + explicit_ones.size(), progress, take)) return false;
  add_row(table, n, dt_omega, frame, fastest(implicit), fastest(explicit_ones));
  return true;
}

/// How many times as long as an implicit step the explicit ones take, by dt omega: a step in a run, or the
/// first one, for which the solver has to be set up.
std::vector<ChartPoint> ratios(const Table& rows, double cells, bool first) {
  const std::string name = first ? "first_" : "";
  std::vector<ChartPoint> points;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.number(r, "cells") == cells && rows.text(r, "status") == "ok")
      points.push_back({rows.number(r, "dt_omega"), rows.number(r, name + "ratio"),
                        rows.number(r, name + "ratio_q1"), rows.number(r, name + "ratio_q3")});
  return points;
}

}  // namespace

Table measure_crossover(const CrossoverConfig& config, Progress& progress) {
  std::vector<Column> columns{{"cells"}, {"dt_omega"}, {"young", "Pa"}};
  for (const std::string kind : {"implicit", "explicit"})
    columns.insert(columns.end(), {{kind},
                                   {kind + "_steps"},
                                   {kind + "_seconds", "s"},
                                   {kind + "_q1", "s"},
                                   {kind + "_q3", "s"},
                                   {kind + "_error"}});
  columns.insert(columns.end(), {{"ratio"},
                                 {"ratio_q1"},
                                 {"ratio_q3"},
                                 {"implicit_first_seconds", "s"},
                                 {"first_ratio"},
                                 {"first_ratio_q1"},
                                 {"first_ratio_q3"},
                                 {"repeats"},
                                 {"status"}});
  Table table(std::move(columns));
  for (const int n : config.cells)
    for (const double dt_omega : config.dt_omega) {
      progress.report(0.99, fmt::format("implicit and explicit steps, {} cells per edge", n));
      if (!measure_frame(config, n, dt_omega, table, progress)) return table;
    }
  return table;
}

Table crossover_summary(const Table& rows) {
  Table summary({{"cells"}, {"step"}, {"cheaper_from_dt_omega"}, {"status"}});
  for (const bool first : {false, true})
    for (const double n : rows.distinct_numbers("cells")) {
      const double from = last_crossing(ratios(rows, n, first));
      std::string status = "ok";
      if (from == 0) status = "cheaper at every one measured";
      if (std::isnan(from)) status = "not cheaper at the largest one measured";
      summary.add({std::int64_t(n), first ? "first" : "later", from > 0 ? from : no_value, status});
    }
  return summary;
}

Chart crossover_chart(const Table& rows) {
  Chart chart{
      .title = "When one implicit step is cheaper than the explicit steps it replaces",
      .subtitle =
          "1/60 s of a cube: linearised backward Euler with the fastest solver, fastest explicit method "
          "at its safe step",
      .x = {.label = "Δt ω, step of 1/60 s times the largest frequency", .logarithmic = true},
      .y = {.label = "time of explicit steps / time of the implicit step", .logarithmic = true},
      .legend_title = "the implicit step is cheaper from Δt ω ="};
  const Table summary = crossover_summary(rows);
  for (std::size_t s = 0; s < summary.size(); ++s) {
    const double n = summary.number(s, "cells"), from = summary.number(s, "cheaper_from_dt_omega");
    const std::string& status = summary.text(s, "status");
    chart.series.push_back({.label = fmt::format("n = {}, {} step: {}", n, summary.text(s, "step"),
                                                 std::isnan(from) ? status : fmt::format("{:.0f}", from)),
                            .points = ratios(rows, n, summary.text(s, "step") == "first")});
  }
  chart.lines.push_back({ReferenceLine::Direction::horizontal, 1, "equally long"});
  return chart;
}

}  // namespace mss::studies::stiffness

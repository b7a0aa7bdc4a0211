// What a step, or one iteration of a step, of the methods that engines use costs beside an explicit step.
#include <fmt/format.h>

#include <memory>

#include "core/springs/spring_system.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/timing/timing.hpp"
#include "integrators/fixed_step.hpp"

namespace mss::studies::timing {

namespace {

using Workload = TimingWorkload;

constexpr const char* compared_with = "semi_implicit_euler";

/// One iteration of a method at the step it is made for.
struct Candidate {
  const char* method;
  const char* nonlinear_solver;  ///< nullptr: it has none
  double dt;                     ///< [s]
  int iterations;                ///< of a step; what begins and ends it is a part of each
};
constexpr double frame = 1.0 / 60;
constexpr Candidate candidates[] = {{compared_with, nullptr, Workload::dt, 1},
                                    {"xpbd", nullptr, frame / 20, 1},
                                    {"vbd", nullptr, frame, 10},
                                    {"backward_euler", "lbfgs", frame, 5},
                                    {"shape_matching", nullptr, frame, 1}};

std::string label(const Candidate& c) {
  return c.nonlinear_solver ? fmt::format("{}/{}", c.method, c.nonlinear_solver) : c.method;
}

template <class Real>
struct TimedMethod {
  TimedMethod(const Candidate& c, int n, int threads)
      : candidate(c),
        body(timing_cube(n)),
        system(body, {.gravity = Vec3(0, 0, Workload::gravity)}, {.threads = threads}),
        start(stretched_state(system, Workload::stretch)),
        state(start) {
    IntegratorOptions options{.dt = c.dt, .iterations = c.iterations};
    if (c.nonlinear_solver) options.nonlinear_solver = c.nonlinear_solver;
    integrator = find_integrator(c.method).make<Real>(options);
  }

  /// Seconds for that many steps, always from the start, so that all samples do the same.
  double take(long steps) {
    state = start;
    integrator->reset();
    Work work;
    return seconds_of(
        [&] { status = integrator->advance(system, state, double(steps) * candidate.dt, work); });
  }

  double seconds_per_iteration(long steps) {
    return take(steps) / (double(steps) * double(candidate.iterations));
  }

  Candidate candidate;
  Body body;
  SpringSystem<Real> system;
  State<Real> start, state;
  std::unique_ptr<Integrator<Real>> integrator;
  Status status = Status::ok;
};

template <class Real>
bool add_rows(int n, int threads, const MethodTimingConfig& config, const Progress& progress, Table& table) {
  std::vector<std::unique_ptr<TimedMethod<Real>>> all;
  for (const Candidate& c : candidates) {
    const IntegratorInfo& info = find_integrator(c.method);
    if (sizeof(Real) == sizeof(double) || info.make_single)
      all.push_back(std::make_unique<TimedMethod<Real>>(c, n, threads));
  }
  std::vector<long> steps;
  for (const auto& c : all) {
    c->take(1);
    const long lasting =
        sample_length(config.sample_seconds, [&](long count) { return c->take(count); }).steps;
    steps.push_back(std::max(steps_between_checks, lasting));
  }
  std::vector<std::vector<double>> samples =
      measure_interleaved(config.repetitions, all.size(), progress,
                          [&](std::size_t i) { return all[i]->seconds_per_iteration(steps[i]); });
  if (progress.stopped()) return false;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Quartiles time = quartiles(samples[i]), ratio = quartiles_of_ratio(samples[i], samples[0]);
    table.add({label(all[i]->candidate), std::string(sizeof(Real) == sizeof(float) ? "single" : "double"),
               all[i]->candidate.iterations, threads, n, time.median, time.q1, time.q3, ratio.median,
               ratio.q1, ratio.q3, std::string(to_string(all[i]->status))});
  }
  return true;
}

}  // namespace

double step_of_method(const std::string& method) {
  for (const Candidate& c : candidates)
    if (label(c) == method) return c.dt;
  return no_value;
}

Table measure_methods(const MethodTimingConfig& config, Progress& progress) {
  Table table({{"method"},
               {"precision"},
               {"iterations"},
               {"threads"},
               {"cells"},
               {"seconds_per_iteration", "s"},
               {"q1", "s"},
               {"q3", "s"},
               {"over_explicit"},
               {"over_explicit_q1"},
               {"over_explicit_q3"},
               {"status"}});
  for (const int n : config.cells)
    for (const int threads : config.threads) {
      progress.report(0.99, fmt::format("methods, {} cells per edge", n));
      if (!add_rows<double>(n, threads, config, progress, table) ||
          !add_rows<float>(n, threads, config, progress, table))
        return table;
    }
  return table;
}

Chart methods_chart(const Table& table) {
  Chart chart{
      .title = "The cost of one iteration of engines' methods",
      .subtitle =
          "damped cube with volume forces, one thread; over a step of semi-implicit Euler of the same "
          "precision",
      .x = {.label = "time of an iteration / time of an explicit step", .low = 0},
      .y = named_rows(table.distinct("method"))};
  chart.times = true;
  chart.notice = spread_notice(table, "over_explicit_q1", "over_explicit_q3");
  const std::vector<std::string> names = table.distinct("method");
  const Table single_thread = table.where("threads", 1);
  for (const double n : single_thread.distinct_numbers("cells"))
    for (const std::string& precision : single_thread.distinct("precision")) {
      const Table rows = single_thread.where("cells", n).where("precision", precision);
      ChartSeries series{.label = fmt::format("n = {}, {}", n, precision), .joined = false};
      for (std::size_t r = 0; r < rows.size(); ++r) {
        const auto row = std::find(names.begin(), names.end(), rows.text(r, "method")) - names.begin();
        series.points.push_back({rows.number(r, "over_explicit"), double(names.size()) - double(row)});
      }
      chart.series.push_back(std::move(series));
    }
  chart.lines.push_back({ReferenceLine::Direction::vertical, 1, ""});
  return chart;
}

}  // namespace mss::studies::timing

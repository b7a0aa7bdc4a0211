// The cost of every feature of a body per step, and the time that lean sweeps save over the general one.
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>
#include <string_view>

#include "core/springs/spring_system.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/timing/timing.hpp"
#include "integrators/fixed_step.hpp"

namespace mss::studies::timing {

namespace {

using Workload = TimingWorkload;

/// The workload with one feature more or less.
struct Variant {
  const char* name;
  void (*change)(BodyConfig& body, Environment& environment);
  bool lean = false;  ///< SpringSystem chooses a sweep that computes less than the general one
};

void refill(BodyConfig& body, double face_share) {
  const double volume = body.springs.volume;
  body.springs = calibrate(Workload::material, body.cell_size, face_share);
  body.springs.volume = volume;
}

constexpr const char* workload_name = "workload";
constexpr std::array<Variant, 9> variants{
    {{"with contact",
      [](BodyConfig&, Environment& environment) {
        environment.planes = {{.point = Vec3(0, 0, -1)}};  // lower than the body falls
      }},
     {"with fold guard", [](BodyConfig& body, Environment&) { body.fold_guard = default_fold_guard; }},
     {workload_name, [](BodyConfig&, Environment&) {}},
     {"no damping", [](BodyConfig& body, Environment&) { body.damping = {}; }, true},
     {"no volume force", [](BodyConfig& body, Environment&) { body.springs.volume = 0; }, true},
     {"no body diagonals", [](BodyConfig& body, Environment&) { refill(body, 1); }, true},
     {"no body diagonals, with fold guard",
      [](BodyConfig& body, Environment&) {
        refill(body, 1);
        body.fold_guard = default_fold_guard;
      }},
     {"no face diagonals", [](BodyConfig& body, Environment&) { refill(body, 0); }, true},
     {"edges and faces only",
      [](BodyConfig& body, Environment&) {
        refill(body, 1);
        body.springs.volume = 0;
        body.damping = {};
      },
      true}}};

template <class Real>
struct TimedFeature {
  TimedFeature(const Variant& variant, int n)
      : body([&] {
          BodyConfig config = timing_cube(n);
          variant.change(config, environment);
          return config;
        }()),
        system(body, environment, {.threads = 1}),
        integrator(find_integrator("semi_implicit_euler").make<Real>({.dt = Workload::dt})),
        state(stretched_state(system, Workload::stretch)) {
    if (!variant.lean) return;
    general.emplace(body, environment, general_kernel<Real>(), Execution{.threads = 1});
    general_state = state;
  }

  /// Seconds for that many steps.
  double take(long steps) {
    return seconds_of(
        [&] { integrator->advance(system, state, state.t + double(steps) * Workload::dt, work); });
  }
  /// The same steps with the general sweep, called directly.
  double take_general(long steps) {
    return seconds_of([&] {
      general->kick_drift({.kick_before = Workload::dt, .drift_new = Workload::dt}, Workload::dt, steps,
                          general_state);
    });
  }

  Environment environment{.gravity = Vec3(0, 0, Workload::gravity)};
  Body body;
  SpringSystem<Real> system;
  std::optional<SpringSystem<Real>> general;
  std::unique_ptr<Integrator<Real>> integrator;
  State<Real> state, general_state;
  Work work;
};

/// Samples of a competitor with its own sweep and with the general one, taken in pairs.
struct Samples {
  std::vector<double> own, general, ratio;
  void add(double seconds, double seconds_general) {
    own.push_back(seconds);
    general.push_back(seconds_general);
    ratio.push_back(seconds / seconds_general);
  }
};

template <class Real>
bool add_rows(int n, const FeatureTimingConfig& config, const Progress& progress, FeatureTables& tables) {
  std::vector<std::unique_ptr<TimedFeature<Real>>> all;
  all.reserve(variants.size());
  for (const Variant& variant : variants) all.push_back(std::make_unique<TimedFeature<Real>>(variant, n));
  std::vector<Samples> samples(all.size());
  std::vector<long> steps;
  for (const auto& competitor : all) {
    competitor->take(1);
    if (competitor->general) competitor->take_general(1);
    const auto seconds_for = [&](long count) { return competitor->take(count); };
    const long lasting = sample_length(config.sample_seconds, seconds_for).steps;
    steps.push_back(std::max(steps_between_checks, lasting));  // fewer would be checked more often
  }
  const auto take_both = [&](std::size_t i) {
    TimedFeature<Real>& competitor = *all[i];
    const bool second = samples[i].own.size() % 2 != 0;  // the first of the two runs with colder caches
    const auto count = double(steps[i]);
    if (second || !competitor.general) {
      const double own = competitor.take(steps[i]) / count;
      samples[i].add(own, competitor.general ? competitor.take_general(steps[i]) / count : std::nan(""));
    } else {
      const double general = competitor.take_general(steps[i]) / count;
      samples[i].add(competitor.take(steps[i]) / count, general);
    }
  };
  if (!interleave(config.repetitions, all.size(), progress, take_both)) return false;
  double workload = 0;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (variants[i].name == std::string(workload_name)) workload = quartiles(samples[i].own).median;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Quartiles own = quartiles(samples[i].own);
    const std::string precision = sizeof(Real) == sizeof(float) ? "single" : "double";
    const std::string status(to_string(is_finite(all[i]->state) ? Status::ok : Status::non_finite));
    tables.features.add({std::string(variants[i].name), precision, n, own.median, own.q1, own.q3,
                         own.median / workload, status});
    if (!all[i]->general) continue;
    const Quartiles ratio = quartiles(samples[i].ratio);
    tables.lean.add({std::string(variants[i].name), precision, n, own.median,
                     quartiles(samples[i].general).median, ratio.median, ratio.q1, ratio.q3, status});
  }
  return true;
}

}  // namespace

template <class Real>
SweepKernel<Real> general_kernel() {
  SweepKernel<Real> kernel = fastest_copy<SweepKernel<Real>>();
  const Sweep<Real> own = kernel.plain.own_dampings.any, weighted = kernel.plain.weighted_dampers.any;
  kernel.plain.own_dampings = {own, own, own, own, own};
  kernel.plain.weighted_dampers = kernel.plain.undamped = {weighted, weighted, weighted, weighted, weighted};
  return kernel;
}

template SweepKernel<float> general_kernel();
template SweepKernel<double> general_kernel();

FeatureTables measure_features(const FeatureTimingConfig& config, Progress& progress) {
  FeatureTables tables{Table({{"variant"},
                              {"precision"},
                              {"cells"},
                              {"seconds_per_step", "s"},
                              {"q1", "s"},
                              {"q3", "s"},
                              {"share"},
                              {"status"}}),
                       Table({{"variant"},
                              {"precision"},
                              {"cells"},
                              {"seconds_per_step", "s"},
                              {"general_seconds_per_step", "s"},
                              {"over_general"},
                              {"q1"},
                              {"q3"},
                              {"status"}})};
  for (const int n : config.cells) {
    progress.report(0.99, fmt::format("features, {} cells per edge", n));
    if (!add_rows<double>(n, config, progress, tables) || !add_rows<float>(n, config, progress, tables))
      break;
  }
  return tables;
}

Chart features_chart(const Table& table) {
  Chart chart{.title = "The cost of features of a body",
              .subtitle = "time of one step, with one feature more or less than the workload; one thread",
              .x = {.label = "time of a step / time of a step of the workload", .low = 0.4},
              .y = named_rows(table.distinct("variant"))};
  chart.times = true;
  chart.notice = spread_notice(table, "q1", "q3");
  const std::vector<std::string> names = table.distinct("variant");
  for (std::size_t r = 0; r < table.size(); ++r) {
    const std::string label = fmt::format("n = {}, {}", table.number(r, "cells"), table.text(r, "precision"));
    auto series = std::find_if(chart.series.begin(), chart.series.end(),
                               [&](const ChartSeries& s) { return s.label == label; });
    if (series == chart.series.end())
      series = chart.series.insert(series, ChartSeries{.label = label, .joined = false});
    const auto row = std::find(names.begin(), names.end(), table.text(r, "variant")) - names.begin();
    series->points.push_back({table.number(r, "share"), double(names.size()) - double(row)});
  }
  chart.lines.push_back({ReferenceLine::Direction::vertical, 1, ""});
  return chart;
}

}  // namespace mss::studies::timing

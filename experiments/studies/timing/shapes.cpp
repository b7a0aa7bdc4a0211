// What a particle costs in bodies that are not boxes: a ball, and a box of which 30 percent of the cells are
// missing at random. Most blocks of particles have neighbourhoods of their own there.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <utility>

#include "core/springs/spring_system.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/timing/timing.hpp"
#include "integrators/fixed_step.hpp"

namespace mss::studies::timing {

namespace {

using Workload = TimingWorkload;

/// The cells of an n x n x n box for which inside(i, j, k).
template <class Inside>
VoxelGrid cells_where(int n, Inside&& inside) {
  VoxelGrid grid(n, n, n);
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) grid.set(i, j, k, inside(i, j, k));
  return grid;
}

/// The cells whose centres lie in the ball that touches the box from within.
VoxelGrid ball(int n) {
  const auto off_centre = [n](int i) { return (2 * i + 1 - n) * (2 * i + 1 - n); };
  return cells_where(
      n, [=](int i, int j, int k) { return off_centre(i) + off_centre(j) + off_centre(k) <= n * n; });
}

VoxelGrid random_70_percent(int n) {
  std::mt19937_64 random(1);
  return cells_where(n, [&](int, int, int) { return random() % 10 < 7; });
}

struct Shape {
  const char* name;
  VoxelGrid (*cells)(int n);
};
/// The first is what the others are compared with.
constexpr std::array<Shape, 3> shapes{{{"box", [](int n) { return VoxelGrid::box(n, n, n); }},
                                       {"ball", ball},
                                       {"random70", random_70_percent}}};

/// What a step of an implicit method multiplies by, at 1/60 s.
constexpr TangentCoefficients tangent{
    .mass = 1, .damping = 1.0 / 60, .stiffness = 1.0 / 3600, .kind = Tangent::projected};

/// One body and both operations on it.
template <class Real>
struct TimedShape {
  TimedShape(const Shape& shape, int n)
      : body([&] {
          BodyConfig config = timing_cube(n);
          config.voxels = shape.cells(n);
          return config;
        }()),
        system(body, {.gravity = Vec3(0, 0, Workload::gravity)}, {.threads = 1}),
        integrator(find_integrator("semi_implicit_euler").make<Real>({.dt = Workload::dt})),
        start(stretched_state(system, Workload::stretch)),
        state(start),
        vector(system.size()),
        image(system.size()) {
    system.force(0, start.x, start.v, vector);
  }

  double take_steps(long count) {
    const double t_end = state.t + double(count) * Workload::dt;
    return seconds_of([&] { integrator->advance(system, state, t_end, work); });
  }
  double take_products(long count) {
    return seconds_of([&] {
      for (long i = 0; i < count; ++i)
        system.tangents()->product(0, start.x, start.v, tangent, vector, image);
    });
  }
  bool is_sound() const { return is_finite(state) && image.array().isFinite().all(); }

  Body body;
  SpringSystem<Real> system;
  std::unique_ptr<Integrator<Real>> integrator;
  State<Real> start, state;
  Field<Real> vector, image;
  Work work;
};

template <class Real>
struct Operation {
  const char* name;
  double (TimedShape<Real>::*take)(long count);
  long fewest;  ///< in a sample
};
template <class Real>
constexpr std::array<Operation<Real>, 2> operations{
    {{"step", &TimedShape<Real>::take_steps, steps_between_checks},  // fewer would be checked more often
     {"tangent_product", &TimedShape<Real>::take_products, 1}}};

/// Nanoseconds per particle of all shapes, in the order of `shapes`; empty if stopped.
template <class Real>
std::vector<std::vector<double>> samples(const Operation<Real>& operation,
                                         const std::vector<std::unique_ptr<TimedShape<Real>>>& subjects,
                                         const ShapeTimingConfig& config, const Progress& progress) {
  std::vector<long> counts;
  for (const auto& subject : subjects) {
    const auto seconds_for = [&](long count) { return (*subject.*operation.take)(count); };
    counts.push_back(std::max(operation.fewest, sample_length(config.sample_seconds, seconds_for).steps));
  }
  std::vector<std::vector<double>> taken(subjects.size());
  const auto take = [&](std::size_t i) {
    TimedShape<Real>& subject = *subjects[i];
    (subject.*operation.take)(1);  // its data back into the caches
    const double seconds = (subject.*operation.take)(counts[i]);
    taken[i].push_back(1e9 * seconds / double(counts[i]) / double(subject.body.particle_count()));
  };
  if (!interleave(config.repetitions, subjects.size(), progress, take)) return {};
  return taken;
}

template <class Real>
bool add_rows(int n, const ShapeTimingConfig& config, const Progress& progress, Table& table) {
  std::vector<std::unique_ptr<TimedShape<Real>>> subjects;
  subjects.reserve(std::size(shapes));
  for (const Shape& shape : shapes) subjects.push_back(std::make_unique<TimedShape<Real>>(shape, n));
  Table grown = table;
  for (const Operation<Real>& operation : operations<Real>) {
    const std::vector<std::vector<double>> ns = samples(operation, subjects, config, progress);
    if (ns.empty()) return false;
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      const Quartiles own = quartiles(ns[i]), over_box = quartiles_of_ratio(ns[i], ns.front());
      const std::string precision = sizeof(Real) == sizeof(float) ? "single" : "double";
      const Status status = subjects[i]->is_sound() ? Status::ok : Status::non_finite;
      grown.add({std::string(shapes[i].name), std::string(operation.name), precision, n,
                 std::int64_t(subjects[i]->body.particle_count()), own.median, own.q1, own.q3,
                 over_box.median, over_box.q1, over_box.q3, std::int64_t(ns[i].size()),
                 std::string(to_string(status))});
    }
  }
  table = std::move(grown);
  return true;
}

/// As in "ball, step, double".
std::string label_of(const Table& table, std::size_t row) {
  const bool product = table.text(row, "operation") == "tangent_product";
  const bool random = table.text(row, "body") == "random70";
  return fmt::format("{}, {}, {}", random ? "random" : table.text(row, "body"), product ? "product" : "step",
                     table.text(row, "precision"));
}

}  // namespace

Table measure_shapes(const ShapeTimingConfig& config, Progress& progress) {
  Table table({{"body"},
               {"operation"},
               {"precision"},
               {"cells"},
               {"particles"},
               {"ns_per_particle", "ns"},
               {"q1", "ns"},
               {"q3", "ns"},
               {"over_box"},
               {"over_box_q1"},
               {"over_box_q3"},
               {"repeats"},
               {"status"}});
  for (const int n : config.cells) {
    progress.report(0.99, fmt::format("shapes, {} cells per edge", n));
    if (!add_rows<double>(n, config, progress, table) || !add_rows<float>(n, config, progress, table)) break;
  }
  return table;
}

Chart shapes_chart(const Table& table) {
  Chart chart{.title = "The cost of a particle in bodies that are not boxes",
              .subtitle =
                  "one explicit step, or one product with the tangent, on one thread; medians, bars are "
                  "quartiles",
              .x = {.label = "cells per edge n", .low = 0, .ticks = table.distinct_numbers("cells")},
              .y = {.label = "time per particle / that in a box of n cells per edge", .low = 0.9}};
  chart.times = true;
  chart.notice = spread_notice(table, "over_box_q1", "over_box_q3");
  for (std::size_t r = 0; r < table.size(); ++r) {
    if (table.text(r, "body") == shapes.front().name || table.text(r, "status") != "ok") continue;
    const std::string label = label_of(table, r);
    auto series = std::find_if(chart.series.begin(), chart.series.end(),
                               [&](const ChartSeries& s) { return s.label == label; });
    if (series == chart.series.end()) series = chart.series.insert(series, ChartSeries{.label = label});
    series->points.push_back({table.number(r, "cells"), table.number(r, "over_box"),
                              table.number(r, "over_box_q1"), table.number(r, "over_box_q3")});
  }
  chart.lines.push_back({ReferenceLine::Direction::horizontal, 1, "box"});
  return chart;
}

}  // namespace mss::studies::timing

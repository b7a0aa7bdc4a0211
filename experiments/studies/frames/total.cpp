// Total errors at frame rate: of space and time together, against a motion in finer cells of the same
// material, beside the error of time alone. What a user buys is the total: below the error of the cells,
// accuracy in time is paid for and not seen.
#include "experiments/studies/frames/total.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>

#include "core/base/error.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/simulation/bench_scenes.hpp"
#include "experiments/simulation/explicit_steps.hpp"

namespace mss::studies::frames {

namespace {

/// A scene in cells of one size, with its true motion.
struct TotalBody {
  TotalBody(const BenchScene& scene, int of_cells, const BenchMaterial& material)
      : cells(of_cells),
        body(scene, of_cells, material),
        truth(find_true_motion(body, std::numeric_limits<double>::infinity(), as_many_threads_as_pay)) {}
  int cells;
  BenchBody body;
  TrueMotion truth;
};

/// The places of the particles of the coarsest cells that every body has a particle at, and where each body
/// has it in its fields.
class CommonPlaces {
 public:
  explicit CommonPlaces(const std::vector<const Body*>& bodies) : sites_(bodies.size()) {
    std::vector<std::map<std::array<long, 3>, std::ptrdiff_t>> by_place(bodies.size());
    const double unit = bodies.back()->config().cell_size / 2;
    const auto place = [&](const Vec3& x) {
      return std::array{std::lround(x[0] / unit), std::lround(x[1] / unit), std::lround(x[2] / unit)};
    };
    for (std::size_t b = 0; b < bodies.size(); ++b)
      for (const std::ptrdiff_t site : bodies[b]->sites())
        by_place[b].emplace(place(bodies[b]->rest_position(site)), site);
    for (const auto& entry : by_place.front()) {
      const std::array<long, 3>& at = entry.first;
      if (std::all_of(by_place.begin(), by_place.end(), [&](const auto& all) { return all.contains(at); }))
        for (std::size_t b = 0; b < bodies.size(); ++b) sites_[b].push_back(by_place[b].at(at));
    }
  }

  std::size_t count() const { return sites_.front().size(); }

  /// Sum over frames and places of squared distances between motions of two bodies [m^2].
  double squared_distance(std::size_t a, const FramePositions& of_a, std::size_t b,
                          const FramePositions& of_b) const {
    double sum = 0;
    for (std::size_t i = 0; i < of_a.size(); ++i)
      for (std::size_t p = 0; p < count(); ++p)
        sum += (of_a[i].at(sites_[a][p]) - of_b[i].at(sites_[b][p])).squaredNorm();
    return sum;
  }
  /// The same from where the body begins.
  double squared_displacement(std::size_t a, const FramePositions& motion, const Field<double>& start) const {
    double sum = 0;
    for (const Field<double>& x : motion)
      for (const std::ptrdiff_t site : sites_[a]) sum += (x.at(site) - start.at(site)).squaredNorm();
    return sum;
  }

 private:
  std::vector<std::vector<std::ptrdiff_t>> sites_;  ///< by body
};

/// One way to move a body, and what was measured of it.
struct TotalRun {
  std::size_t level;
  std::string name;
  const IntegratorInfo* info;
  IntegratorOptions options;
  long steps;  ///< a frame
  std::vector<double> seconds = {};
  double error_time = no_value, error_total = no_value;
  Status status = Status::ok;
  bool in_time = true;

  std::string outcome() const { return in_time ? std::string(to_string(status)) : too_slow; }
};

/// A problem in all of its cells, the reference's last.
class TotalStudy {
 public:
  TotalStudy(const TotalConfig& config, const TotalProblem& problem) : config_(config), problem_(problem) {
    BenchScene scene = find_bench_scene(problem.scene);
    if (config.frames > 0) scene.frames = config.frames;
    const double nominal = scene.set_up(problem.cells.back()).body.cell_size;
    material_ = {problem.young, viscosity_like_ratio(problem.ratio, problem.young, nominal)};
    for (const int cells : problem.cells)
      bodies_.push_back(std::make_unique<TotalBody>(scene, cells, material_));
    bodies_.push_back(std::make_unique<TotalBody>(scene, problem.reference_cells, material_));
    std::vector<const Body*> lattices;
    for (const auto& b : bodies_) lattices.push_back(&b->body.body);
    places_ = std::make_unique<CommonPlaces>(lattices);
    if (is_known())
      scale_ = places_->squared_displacement(reference(), finest().truth.positions, finest().body.start.x);
  }

  /// Whether all true motions are.
  bool is_known() const {
    return places_->count() > 0 && std::all_of(bodies_.begin(), bodies_.end(),
                                               [](const auto& b) { return b->truth.complaint.empty(); });
  }

  std::vector<TotalRun> runs() {
    std::vector<TotalRun> all;
    for (std::size_t level = 0; level < reference(); ++level) {
      BenchBody& body = bodies_[level]->body;
      for (const ExplicitSteps& choice : cheapest_explicit_steps(body.system, body.start, frame))
        for (const double share : {1.0, 0.25}) {
          const ExplicitSteps steps =
              explicit_steps(*choice.info, body.system.spectral_bound(), frame, share);
          all.push_back({level, choice.info->name, choice.info, {.dt = steps.dt}, steps.steps});
        }
      for (const Family& family : config_.families)
        for (const int steps : family.steps)
          for (const int iterations : family.iterations) add_family(family, steps, iterations, level, all);
    }
    return all;
  }

  /// Once more; its errors from the first.
  void take(TotalRun& run) const {
    if (!run.in_time || run.status != Status::ok) return;
    const TotalBody& b = *bodies_[run.level];
    const MeasuredMotion measured =
        measure_motion(b.body, *run.info, run.options, b.body.scene.frames, config_.most_seconds);
    run.seconds.push_back(measured.seconds);
    if (run.seconds.size() > 1) return;
    run.status = measured.status;
    run.in_time = measured.in_time;
    if (!measured.ok()) return;
    run.error_time = distance(run.level, measured.motion, run.level, b.truth.positions);
    run.error_total = distance(run.level, measured.motion, reference(), finest().truth.positions);
    if (!std::isfinite(run.error_time + run.error_total)) run.status = Status::non_finite;
  }

  void add_cells(Table& cells) const {
    for (std::size_t level = 0; level < bodies_.size(); ++level) {
      const TotalBody& b = *bodies_[level];
      std::vector<Cell> row = row_begin(b.cells);
      row.insert(
          row.end(),
          {std::int64_t(b.body.body.particle_count()), std::int64_t(places_->count()),
           is_known() ? distance(level, b.truth.positions, reference(), finest().truth.positions) : no_value,
           b.truth.complaint.empty() ? b.truth.uncertainty : no_value,
           std::string(!b.truth.complaint.empty() ? b.truth.complaint
                       : is_known()               ? "ok"
                                                  : "nothing to compare with")});
      cells.add(std::move(row));
    }
  }

  void add_rows(const std::vector<TotalRun>& runs, Table& rows) const {
    for (const TotalRun& run : runs) {
      const Quartiles time = quartiles(run.seconds);
      std::vector<Cell> row = row_begin(bodies_[run.level]->cells);
      row.insert(row.end(),
                 {run.name, std::string(run.info->implicit || !run.info->limit ? "family" : "explicit"),
                  run.options.iterations, std::int64_t(run.steps), time.median, time.q1, time.q3,
                  run.error_time, run.error_total, run.outcome()});
      rows.add(std::move(row));
    }
  }

 private:
  std::size_t reference() const { return bodies_.size() - 1; }
  const TotalBody& finest() const { return *bodies_.back(); }

  std::vector<Cell> row_begin(int cells) const {
    return {
        problem_.name(), problem_.scene, problem_.young, problem_.ratio, material_.damping.viscosity, cells};
  }

  double distance(std::size_t a, const FramePositions& of_a, std::size_t b,
                  const FramePositions& of_b) const {
    return std::sqrt(places_->squared_distance(a, of_a, b, of_b) / scale_);
  }

  static void add_family(const Family& family, int steps, int iterations, std::size_t level,
                         std::vector<TotalRun>& all) {
    IntegratorOptions options{
        .dt = frame / steps, .iterations = iterations, .chebyshev_radius = family.chebyshev_radius};
    if (!family.nonlinear.empty()) options.nonlinear_solver = family.nonlinear;
    if (!family.linear.empty()) options.linear_solver = family.linear, options.linear_tolerance = 1e-3;
    all.push_back({level, family.name(), &find_integrator(family.integrator), options, steps});
  }

  const TotalConfig& config_;
  const TotalProblem& problem_;
  BenchMaterial material_;
  std::vector<std::unique_ptr<TotalBody>> bodies_;
  std::unique_ptr<CommonPlaces> places_;
  double scale_ = 0;  ///< sum over frames and places of the reference's squared displacements [m^2]
};

std::vector<Column> total_columns(std::vector<Column> more) {
  std::vector<Column> columns{{"problem"},           {"scene"}, {"young", "Pa"}, {"ratio"},
                              {"viscosity", "Pa s"}, {"cells"}};
  columns.insert(columns.end(), more.begin(), more.end());
  return columns;
}

TotalTables empty_totals() {
  return {Table(total_columns({{"method"},
                               {"kind"},
                               {"iterations"},
                               {"steps_per_frame"},
                               {"seconds", "s"},
                               {"q1", "s"},
                               {"q3", "s"},
                               {"error_time"},
                               {"error_total"},
                               {"status"}})),
          Table(total_columns({{"particles"}, {"places"}, {"error_space"}, {"uncertainty"}, {"status"}}))};
}

/// False if stopped.
bool measure_total(const TotalConfig& config, const TotalProblem& problem, TotalTables& tables,
                   const Progress& progress) {
  TotalStudy study(config, problem);
  study.add_cells(tables.cells);
  if (!study.is_known()) return true;
  std::vector<TotalRun> runs = study.runs();
  if (!interleave(config.repetitions, runs.size(), progress, [&](std::size_t i) { study.take(runs[i]); }))
    return false;
  study.add_rows(runs, tables.rows);
  return true;
}

Chart total_chart(const Table& rows, const Table& cells) {
  const std::string& scene = rows.text(0, "scene");
  Chart chart{.title = fmt::format("Total error against time: {}", find_bench_scene(scene).label),
              .subtitle = fmt::format(
                  "E = {:g} MPa, viscosity {:.2g} Pa s; against {:g} cells; markers without a line: "
                  "error of time alone, of the same runs",
                  rows.number(0, "young") / 1e6, rows.number(0, "viscosity"),
                  cells.number(cells.size() - 1, "cells")),
              .x = {.label = "wall time, set-up included", .logarithmic = true, .unit = "s"},
              .y = {.label = "error over displacement", .logarithmic = true, .low = 1e-4, .high = 2}};
  int style = 0;
  for (const std::string& method : rows.distinct("method")) {
    const Table of_method = rows.where("method", method);
    ChartSeries total{.label = method, .style = style}, time{.style = style, .joined = false};
    for (const std::size_t r : best_totals(of_method)) {
      if (of_method.number(r, "error_total") > chart.y.high) continue;
      const double seconds = of_method.number(r, "seconds");
      total.points.push_back({seconds, of_method.number(r, "error_total")});
      time.points.push_back({seconds, std::max(of_method.number(r, "error_time"), chart.y.low)});
    }
    if (total.points.empty()) continue;
    chart.series.push_back(std::move(total));
    chart.series.push_back(std::move(time));
    ++style;
  }
  for (std::size_t r = 0; r + 1 < cells.size(); ++r)
    if (cells.text(r, "status") == "ok")
      chart.lines.push_back({ReferenceLine::Direction::horizontal, cells.number(r, "error_space"),
                             fmt::format("{:g} cells", cells.number(r, "cells"))});
  return chart;
}

}  // namespace

std::string TotalProblem::name() const { return fmt::format("{}, {:g} Pa, ratio {:g}", scene, young, ratio); }

TotalConfig total_config(const ExperimentOptions& options) {
  TotalConfig config{
      .problems = {},
      .families = {
          {.integrator = "backward_euler_linear", .linear = "multigrid", .steps = {1, 4, 16}},
          {.integrator = "backward_euler", .nonlinear = "lbfgs", .iterations = {2, 5}, .steps = {1, 4, 16}},
          {.integrator = "tr_bdf2", .nonlinear = "lbfgs", .iterations = {2, 5}, .steps = {1, 4, 16}},
          {.integrator = "generalized_alpha",
           .nonlinear = "lbfgs",
           .iterations = {2, 5},
           .steps = {1, 4, 16}},
          {.integrator = "xpbd", .iterations = {1, 5}, .steps = {1, 4, 16, 64}},
          {.integrator = "vbd", .iterations = {5, 20}, .steps = {1, 4, 16}},
          {.integrator = "vbd", .iterations = {5, 20}, .steps = {1, 4, 16}, .chebyshev_radius = 0.95}}};
  if (options.quick) {
    config.problems = {{"held_box", 1e6, 0.01, {2, 4}, 8},
                       {"bracket", 1e6, 0.01, {2, 4}, 8},
                       {"ball", 1e6, 0.01, {4, 8}, 16}};
    config.repetitions = 1;
    config.most_seconds = 0.1;
    return config;
  }
  config.problems = {{"held_box", 1e6, 0.01, {3, 6, 12}, 24},
                     {"bracket", 1e7, 0.5, {1, 3, 6}, 12},
                     {"ball", 1e6, 0.01, {4, 8, 16}, 32}};
  return config;
}

TotalTables measure_totals(const TotalConfig& config, Progress& progress) {
  TotalTables tables = empty_totals();
  for (std::size_t i = 0; i < config.problems.size(); ++i) {
    progress.report(double(i) / double(config.problems.size()), "total errors: " + config.problems[i].name());
    if (progress.stopped() || !measure_total(config, config.problems[i], tables, progress)) {
      tables.status = Status::interrupted;
      break;
    }
  }
  return tables;
}

std::vector<NamedTable> total_files(const TotalTables& tables) {
  return {{"frames_total", tables.rows}, {"frames_total_cells", tables.cells}};
}

std::vector<std::size_t> best_totals(const Table& rows) {
  constexpr double better = 0.98;
  std::vector<std::size_t> ok, best;
  for (std::size_t r = 0; r < rows.size(); ++r)
    if (rows.text(r, "status") == "ok") ok.push_back(r);
  std::sort(ok.begin(), ok.end(), [&](std::size_t a, std::size_t b) {
    return rows.number(a, "seconds") < rows.number(b, "seconds");
  });
  for (const std::size_t r : ok)
    if (best.empty() || rows.number(r, "error_total") < better * rows.number(best.back(), "error_total"))
      best.push_back(r);
  return best;
}

std::vector<NamedChart> total_charts(const Table& rows, const Table& cells) {
  std::vector<NamedChart> charts;
  for (const std::string& problem : rows.distinct("problem")) {
    const Table of_problem = rows.where("problem", problem);
    const std::string& scene = of_problem.text(0, "scene");
    std::string name = fmt::format("frames_total_{}_{:g}", scene, of_problem.number(0, "young"));
    std::erase(name, '+');
    charts.push_back({name, total_chart(of_problem, cells.where("problem", problem)), "frames_total"});
  }
  return charts;
}

}  // namespace mss::studies::frames

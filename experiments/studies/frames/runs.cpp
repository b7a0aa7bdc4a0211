// Motions at frame rate: references, timed runs, distances.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/harness/measure.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/simulation/explicit_steps.hpp"
#include "experiments/simulation/held_cube.hpp"
#include "experiments/studies/frames/frames.hpp"

namespace mss::studies::frames {

namespace {

constexpr const char* reference_method = "damped_verlet";
constexpr double reference_share = 0.25;  ///< of the safe step; of second order, so a 16th of its error

/// One row: a method with its options, and what was measured of it.
struct Run {
  std::string name;
  const IntegratorInfo* info;
  IntegratorOptions options;
  long steps;  ///< a frame
  bool is_explicit;
  std::vector<double> seconds = {};
  Work work{};
  Status status = Status::ok;
  double error = no_value, distance = no_value;
  double spent = 0;  ///< [s]
};

/// How the stiffness of a method without a modulus was chosen: by the mean deflection of the free end at
/// rest.
struct Fit {
  std::string method;
  long steps;       ///< a frame
  double wanted;    ///< the springs' deflection [m]; NaN: their rest was not found
  double stiffest;  ///< the method's with alpha = 1 [m]; NaN: it does not come to rest
  double alpha;     ///< 1 where that is as good as any

  std::string status() const {
    if (std::isnan(wanted)) return "no rest of the springs";
    if (std::isnan(stiffest)) return "no rest with alpha = 1";
    return wanted < stiffest ? "too soft even with alpha = 1" : "ok";
  }
};

HeldCube cube_of(const FrameScene& scene, int threads) {
  return {{.young = scene.young, .poisson = scene.poisson}, scene.cells, scene.damping_ratio, threads};
}

/// A scene with its references.
class Problem {
 public:
  Problem(const FramesConfig& config, const FrameScene& scene)
      : config_(config), cube_(cube_of(scene, config.threads)) {
    const HeldCube mover = cube_of(scene, as_many_threads_as_pay);
    Run truth = explicit_run(explicit_steps(find_integrator(reference_method), cube_.system.spectral_bound(),
                                            frame, reference_share));
    Run converged{.name = "backward_euler",
                  .info = &find_integrator("backward_euler"),
                  .options = {.dt = frame},
                  .steps = 1,
                  .is_explicit = false};
    true_ = move(mover, truth);
    converged_ = move(mover, converged);
    displacement_ = squared_displacement(cube_, true_);
  }

  bool has_references() const { return !true_.empty() && !converged_.empty(); }

  static Run explicit_run(const ExplicitSteps& choice) {
    return {.name = choice.info->name,
            .info = choice.info,
            .options = {.dt = choice.dt},
            .steps = choice.steps,
            .is_explicit = true};
  }

  std::vector<Run> runs() {
    std::vector<Run> all;
    for (const ExplicitSteps& choice : cheapest_explicit_steps(cube_.system, cube_.start, frame))
      all.push_back(explicit_run(choice));
    for (const Family& family : config_.families)
      for (const int steps : family.steps)
        for (const int iterations : family.iterations) {
          IntegratorOptions options{
              .dt = frame / steps, .iterations = iterations, .chebyshev_radius = family.chebyshev_radius};
          if (!family.nonlinear.empty()) options.nonlinear_solver = family.nonlinear;
          if (!family.linear.empty()) options.linear_solver = family.linear;
          if (!find_integrator(family.integrator).has_modulus) options.alpha = fit(family, steps);
          all.push_back({.name = family.name(),
                         .info = &find_integrator(family.integrator),
                         .options = options,
                         .steps = steps,
                         .is_explicit = false});
        }
    return all;
  }

  const std::vector<Fit>& fits() const { return fits_; }

  void take(Run& run) const {
    const bool first = run.seconds.empty();
    const FramePositions motion = move(cube_, run);
    run.spent += run.seconds.back();
    if (!first || motion.empty()) return;
    run.error = distance(motion, true_);
    run.distance = distance(motion, converged_);
  }

 private:
  /// The alpha with which the free end hangs as far through as that of springs. At rest alpha (goal - x) is
  /// -dt^2 g, so deflections grow as dt^2 / alpha.
  double fit(const Family& family, int steps) {
    if (deflection_ == 0) {
      State<double> rest = cube_.start;
      Work work;
      const Status found = find_integrator("static").make<double>({})->advance(cube_.system, rest, 0, work);
      deflection_ = found == Status::ok ? deflection(rest.x) : no_value;
      stiffest_ = stiffest_deflection(find_integrator(family.integrator));
    }
    Fit fit{family.name(), steps, deflection_, stiffest_ / double(steps) / double(steps), 1};
    if (fit.stiffest < fit.wanted) fit.alpha = fit.stiffest / fit.wanted;
    fits_.push_back(fit);
    return fit.alpha;
  }

  /// With alpha = 1 and a step a frame: steps from rest each, until they hardly move the free end. NaN if
  /// they do not stop moving it.
  double stiffest_deflection(const IntegratorInfo& info) {
    constexpr int most_steps = 20000;
    constexpr double negligible = 1e-6;
    const auto integrator = info.make<double>({.dt = frame});
    State<double> state = cube_.start;
    Work work;
    double before = 0;
    for (int i = 1; i <= most_steps; ++i) {
      if (integrator->advance(cube_.system, state, state.t + frame, work) != Status::ok) return no_value;
      state.v.array() = 0;
      const double now = deflection(state.x);
      if (std::abs(now - before) < negligible * std::abs(now)) return now;
      before = now;
    }
    return no_value;
  }

  /// Mean of the free end, downwards [m].
  double deflection(const Field<double>& x) const {
    double sum = 0;
    const std::vector<std::ptrdiff_t> end = cube_.body.select({1, 0, 0}, {1, 1, 1});
    for (const std::ptrdiff_t site : end) sum += cube_.start.x.at(site)[2] - x.at(site)[2];
    return sum / double(end.size());
  }

  /// The motion, its time in run.seconds; empty if a frame failed.
  FramePositions move(const HeldCube& cube, Run& run) const {
    MeasuredMotion measured = measure_motion(cube, *run.info, run.options, config_.frames);
    run.work = measured.work;
    run.status = measured.status;
    run.seconds.push_back(measured.seconds);
    return std::move(measured.motion);
  }

  /// NaN if there is no reference.
  double distance(const FramePositions& motion, const FramePositions& reference) const {
    if (reference.empty()) return no_value;
    return std::sqrt(squared_distance(cube_, motion, reference) / displacement_);
  }

  const FramesConfig& config_;
  HeldCube cube_;
  FramePositions true_, converged_;
  double displacement_ = 0;               ///< sum of squares of the true one [m^2]
  double deflection_ = 0, stiffest_ = 0;  ///< at rest: of springs, of a method without a modulus [m]
  std::vector<Fit> fits_;
};

/// The explicit run with the smallest median.
const Run& fastest_explicit(const std::vector<Run>& runs) {
  const auto time = [](const Run& run) {
    return run.is_explicit ? quartiles(run.seconds).median : std::numeric_limits<double>::infinity();
  };
  return *std::min_element(runs.begin(), runs.end(),
                           [&](const Run& a, const Run& b) { return time(a) < time(b); });
}

std::string status_of(const Run& run, bool has_references) {
  if (run.status == Status::ok && !has_references) return "the reference failed";
  return std::string(to_string(run.status));
}

void add_rows(Table& table, const FrameScene& scene, const std::vector<Run>& runs, bool has_references) {
  const Run& fastest = fastest_explicit(runs);
  for (const Run& run : runs) {
    const Quartiles time = quartiles(run.seconds), over = quartiles_of_ratio(run.seconds, fastest.seconds);
    std::vector<Cell> row{scene.name,
                          scene.cells,
                          scene.young,
                          scene.poisson,
                          scene.damping_ratio,
                          run.name,
                          std::string(run.is_explicit ? "explicit" : "family"),
                          run.options.iterations,
                          std::int64_t(run.steps),
                          time.median,
                          time.q1,
                          time.q3,
                          over.median,
                          over.q1,
                          over.q3,
                          std::int64_t(run.seconds.size()),
                          run.error,
                          run.distance};
    for (Cell& cell : work_cells(run.work)) row.push_back(std::move(cell));
    row.emplace_back(status_of(run, has_references));
    table.add(std::move(row));
  }
}

Table empty_rows() {
  std::vector<Column> columns{
      {"scene"},   {"cells"},   {"young", "Pa"},   {"poisson"},          {"damping_ratio"},
      {"method"},  {"kind"},    {"iterations"},    {"steps_per_frame"},  {"seconds", "s"},
      {"q1", "s"}, {"q3", "s"}, {"over_explicit"}, {"over_explicit_q1"}, {"over_explicit_q3"},
      {"repeats"}, {"error"},   {"distance"}};
  for (Column& column : work_columns()) columns.push_back(std::move(column));
  columns.push_back({"status"});
  return Table(std::move(columns));
}

/// Interleaves all runs; false if stopped.
bool measure_scene(const FramesConfig& config, const FrameScene& scene, FrameTables& tables,
                   const Progress& progress) {
  Problem problem(config, scene);
  std::vector<Run> runs = problem.runs();
  const auto take = [&](std::size_t i) {
    if (runs[i].spent < config.seconds_per_row) problem.take(runs[i]);
  };
  if (!interleave(config.repetitions, runs.size(), progress, take)) return false;
  add_rows(tables.rows, scene, runs, problem.has_references());
  for (const Fit& fit : problem.fits())
    tables.fits.add(
        {scene.name, fit.method, std::int64_t(fit.steps), fit.wanted, fit.stiffest, fit.alpha, fit.status()});
  return true;
}

/// A round of one equilibrium.
struct Rest {
  const Family* family;
  IntegratorOptions options;
  std::vector<double> seconds = {};
  Work work{};
  Status status = Status::ok;
  Field<double> x = {};
  double spent = 0;  ///< [s]
};

void find_rest(const HeldCube& cube, Rest& rest) {
  const IntegratorInfo& info = find_integrator(rest.family->integrator);
  State<double> state = cube.start;
  rest.work = {};
  rest.seconds.push_back(seconds_of(
      [&] { rest.status = info.make<double>(rest.options)->advance(cube.system, state, 0, rest.work); }));
  rest.spent += rest.seconds.back();
  rest.x = std::move(state.x);
}

bool stops_at_tolerance(const Family& family) {
  return family.integrator != "static" || !(family.nonlinear.empty() || family.nonlinear == "newton");
}

std::vector<Rest> rests(const RestConfig& config, const HeldCube& cube) {
  std::vector<Rest> all;
  for (const Family& family : config.families) {
    const IntegratorInfo& info = find_integrator(family.integrator);
    IntegratorOptions options;
    options.dt = info.limit ? safe_share * stable_step(info, cube.system.spectral_bound()) : frame;
    if (!family.nonlinear.empty()) options.nonlinear_solver = family.nonlinear;
    if (!family.linear.empty()) options.linear_solver = family.linear;
    for (const double tolerance : config.tolerances) {
      options.tolerance = tolerance;
      all.push_back({.family = &family, .options = options});
      if (!stops_at_tolerance(family)) break;
    }
  }
  return all;
}

/// False if stopped.
bool measure_rest_of(const RestConfig& config, const FrameScene& scene, Table& table,
                     const Progress& progress) {
  const HeldCube cube = cube_of(scene, config.threads);
  const Family newton{.integrator = "static"};
  Rest truth{.family = &newton, .options = {}};
  find_rest(cube, truth);
  std::vector<Rest> all = rests(config, cube);
  const auto take = [&](std::size_t i) {
    if (all[i].spent < config.seconds_per_row) find_rest(cube, all[i]);
  };
  if (!interleave(config.repetitions, all.size(), progress, take)) return false;
  const double displacement = cube.squared_distance(truth.x, cube.start.x);
  for (const Rest& rest : all) {
    const Quartiles time = quartiles(rest.seconds);
    const double error = rest.status == Status::ok
                             ? std::sqrt(cube.squared_distance(rest.x, truth.x) / displacement)
                             : no_value;
    std::vector<Cell> row{scene.name,
                          scene.cells,
                          rest.family->name(),
                          stops_at_tolerance(*rest.family) ? rest.options.tolerance : 0,
                          time.median,
                          time.q1,
                          time.q3,
                          std::int64_t(rest.seconds.size()),
                          error};
    for (Cell& cell : work_cells(rest.work)) row.push_back(std::move(cell));
    row.emplace_back(std::string(to_string(rest.status)));
    table.add(std::move(row));
  }
  return true;
}

}  // namespace

std::string FrameScene::description() const {
  return fmt::format("{} cells an edge, E = {:g} MPa, ν = {:g}, damping ratio {:g}", cells, young / 1e6,
                     poisson, damping_ratio);
}

std::string Family::name() const {
  std::string name = integrator;
  if (!nonlinear.empty()) name += "/" + nonlinear;
  if (!linear.empty()) name += "/" + linear;
  if (chebyshev_radius > 0) name += fmt::format(", rho = {}", chebyshev_radius);
  return name;
}

FrameTables measure_frames(const FramesConfig& config, Progress& progress) {
  FrameTables tables{empty_rows(), Table({{"scene"},
                                          {"method"},
                                          {"steps_per_frame"},
                                          {"deflection", "m"},
                                          {"deflection_with_alpha_1", "m"},
                                          {"alpha"},
                                          {"status"}})};
  for (std::size_t i = 0; i < config.scenes.size(); ++i) {
    progress.report(double(i) / double(config.scenes.size()), config.scenes[i].description());
    if (!measure_scene(config, config.scenes[i], tables, progress)) {
      tables.status = Status::interrupted;
      break;
    }
  }
  return tables;
}

Table measure_rest(const RestConfig& config, Progress& progress) {
  std::vector<Column> columns{{"scene"},   {"cells"},   {"method"},  {"tolerance"}, {"seconds", "s"},
                              {"q1", "s"}, {"q3", "s"}, {"repeats"}, {"error"}};
  for (Column& column : work_columns()) columns.push_back(std::move(column));
  columns.push_back({"status"});
  Table table(std::move(columns));
  for (const FrameScene& scene : config.scenes) {
    progress.report(0.99, "rest: " + scene.description());
    if (!measure_rest_of(config, scene, table, progress)) break;
  }
  return table;
}

}  // namespace mss::studies::frames

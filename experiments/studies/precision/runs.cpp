// The runs of `mss precision`: references, errors, refinement.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/error.hpp"
#include "core/measures/measures.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/simulation/explicit_steps.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/precision/precision.hpp"

namespace mss::studies::precision {

namespace {

/// One scene with the system and the initial state that all of its runs share.
struct Problem {
  Problem(const PrecisionScene& s, const PrecisionConfig& config)
      : scene(s),
        body(s.body),
        owned(make_system<double>(config.model, body, s.environment, config.threads)),
        system(*owned),
        start(system.rest_state()) {
    if (scene.bench) {
      const BenchCase& of = *scene.bench;
      bench = std::make_unique<BenchBody>(find_bench_scene(of.scene), scene.cells,
                                          BenchMaterial{of.young, damping_of_ratio(of.ratio)});
      start = bench->start;
    }
    if (scene.start)
      for (const std::ptrdiff_t site : body.sites()) start.x.set(site, scene.start(start.x.at(site)));
    system.constrain(0, start.x, start.v);
    scale_errors(options, system);
    if (!small()) options.linear_solver = "matrix_free";
  }
  bool on_planes() const { return !scene.environment.planes.empty(); }
  bool small() const { return body.particle_count() <= precision_small; }
  const PrecisionScene& scene;
  Body body;
  std::unique_ptr<BodySystem<double>> owned;
  BodySystem<double>& system;
  State<double> start;
  std::unique_ptr<BenchBody> bench;  ///< the same of springs, if it is one
  IntegratorOptions options;
};

/// Root mean square over particles of the distance between two sets of positions [m].
double distance(const Body& body, const Field<double>& a, const Field<double>& b) {
  double sum = 0;
  for (const std::ptrdiff_t site : body.sites()) sum += (a.at(site) - b.at(site)).squaredNorm();
  return std::sqrt(sum / double(body.particle_count()));
}

struct Reference {
  Status status = Status::ok;  ///< of both methods; if not ok, the rest is undefined
  std::string complaint = {};  ///< what the body did that its scene is not meant to do
  Field<double> x{};           ///< at the end time
  double displacement = 0;     ///< largest root mean square from the start until then [m]
  Measures measures;
  double uncertainty = 0;  ///< relative to the displacement
  double energy = 0;       ///< largest of the elastic and kinetic energies [J]

  bool is_known() const { return status == Status::ok && complaint.empty(); }
  std::string outcome() const {
    return status != Status::ok ? std::string(to_string(status)) : complaint.empty() ? "ok" : complaint;
  }
  /// Whether it is known well enough to say who agrees with it.
  bool is_sharp() const { return precision_certainty * uncertainty <= precision_agreed; }
};

/// Two methods that find a motion, one to be compared with the other.
struct ReferenceMethods {
  const IntegratorInfo *first, *second;
  IntegratorOptions of_first, of_second;
};

/// Where planes act in fixed steps, at the scene's share of the safe step and at twice that, else at a
/// tolerance.
ReferenceMethods reference_methods(Problem& p, double tolerance) {
  if (!p.on_planes()) {
    IntegratorOptions options = p.options;
    options.dt = 0;
    options.tolerance = tolerance;
    return {&find_integrator("cvode_adams"), &find_integrator("arkode_erk"), options, options};
  }
  const BenchScene& scene = p.bench->scene;
  const IntegratorInfo& info = find_integrator(scene.truth);
  const auto options_at = [&](double share) {
    IntegratorOptions options = p.options;
    options.dt = explicit_steps(info, p.system.spectral_bound(), frame, share).dt;
    return options;
  };
  return {&info, &info, options_at(scene.truth_share), options_at(2 * scene.truth_share)};
}

Reference find_reference(Problem& p, double tolerance) {
  const ReferenceMethods methods = reference_methods(p, tolerance);
  Work work;
  State<double> state = p.start, other = p.start;
  Reference r{.measures = measure(p.system, p.start)};
  r.energy = std::max(r.measures.elastic, r.measures.kinetic);
  const auto first = methods.first->make<double>(methods.of_first);
  const int samples = p.bench ? p.bench->scene.frames : 32;
  FramePositions motion;
  for (int i = 1; i <= samples; ++i) {
    r.status = first->advance(p.system, state, p.scene.duration * i / samples, work);
    if (r.status != Status::ok) return r;
    r.measures = measure(p.system, state);
    r.displacement = std::max(r.displacement, distance(p.body, state.x, p.start.x));
    r.energy = std::max({r.energy, r.measures.elastic, r.measures.kinetic});
    motion.push_back(state.x);
  }
  if (p.bench) r.complaint = bench_complaint(*p.bench, motion);
  r.status =
      methods.second->make<double>(methods.of_second)->advance(p.system, other, p.scene.duration, work);
  r.uncertainty = distance(p.body, state.x, other.x) / r.displacement;
  r.x = std::move(state.x);
  return r;
}

/// One method with one step or tolerance, and what was measured of it.
struct Run {
  const IntegratorInfo* info;
  IntegratorOptions options;
  std::vector<double> seconds = {};
  Status status = Status::ok;  ///< this and the rest are of the first time
  Work work{};
  State<double> end{};
  double error = no_value, energy_drift = no_value, volume_drift = no_value;

  double spent() const { return std::accumulate(seconds.begin(), seconds.end(), 0.0); }
};

/// Once more.
void take(Problem& p, Run& run) {
  const auto method = run.info->make<double>(run.options);
  State<double> state = p.start;
  Work work;
  Status status = Status::ok;
  run.seconds.push_back(
      seconds_of([&] { status = method->advance(p.system, state, p.scene.duration, work); }));
  if (run.seconds.size() > 1) return;
  const bool finite = std::isfinite(measure(p.system, state).total());  // squares overflow before coordinates
  run.status = status == Status::ok && !finite ? Status::non_finite : status;
  run.work = work;
  run.end = std::move(state);
}

double error_of(const Problem& p, const Reference& reference, const Field<double>& x) {
  return distance(p.body, x, reference.x) / reference.displacement;
}

/// Distances of a run from the reference.
void compare(const Problem& p, const Reference& reference, Run& run) {
  if (run.status != Status::ok) return;
  const Measures m = measure(p.system, run.end);
  run.error = error_of(p, reference, run.end.x);
  run.energy_drift = std::abs(m.total() - reference.measures.total()) / reference.energy;
  run.volume_drift = std::abs(m.volume_ratio - reference.measures.volume_ratio);
}

std::string status_text(const Run& run) {
  return run.error > precision_worst ? precision_diverged : std::string(to_string(run.status));
}

void add_row(Table& rows, const Problem& p, double step_seconds, const Run& run) {
  const bool adaptive = run.info->stepping == Stepping::adaptive;
  const Quartiles time = quartiles(run.seconds);
  std::vector<Cell> row{p.scene.name,
                        run.info->name,
                        std::string(adaptive ? "tolerance" : "dt"),
                        adaptive ? run.options.tolerance : run.options.dt,
                        run.error,
                        run.energy_drift,
                        run.volume_drift,
                        time.median,
                        time.q1,
                        time.q3,
                        std::int64_t(run.seconds.size()),
                        time.median / step_seconds};
  for (Cell& cell : work_cells(run.work)) row.push_back(std::move(cell));
  row.emplace_back(status_text(run));
  rows.add(std::move(row));
}

/// Richardson extrapolation to h = 0 of runs of a method of that order with steps h, h/2, h/4 ... (finest
/// last), by Neville's scheme on the last four: each column eliminates one more power of h.
Field<double> extrapolate(std::vector<Field<double>> runs, int order) {
  runs.erase(runs.begin(), runs.end() - std::min<std::ptrdiff_t>(4, std::ssize(runs)));
  for (std::size_t column = 1; column < runs.size(); ++column) {
    const double weight = std::ldexp(1.0, order + int(column) - 1) - 1;
    for (std::size_t i = runs.size() - 1; i >= column; --i)
      runs[i].array() += (runs[i].array() - runs[i - 1].array()) / weight;
  }
  return runs.back();
}

/// How close a method's runs come to the reference: the finest one, and the extrapolation of the last four.
struct Agreement {
  bool is_judged;  ///< whether the reference is that certain
  std::vector<Field<double>> runs = {};
  double tightest = no_value, extrapolated = no_value;

  void add(const Problem& p, const Reference& reference, const IntegratorInfo& info, const Run& run) {
    if (run.status != Status::ok) return;
    const bool damped = p.scene.body.damping.law != Damping::Law::none;
    runs.push_back(run.end.x);
    tightest = extrapolated = error_of(p, reference, run.end.x);
    if (info.stepping == Stepping::fixed)
      extrapolated =
          error_of(p, reference, extrapolate(runs, damped ? info.order_damped : info.order_undamped));
  }
  bool reached() const { return std::min(tightest, extrapolated) < precision_agreed; }
  std::string status() const {
    return runs.empty()                      ? "no run finished"
           : !is_judged                      ? "the reference is not that certain"
           : tightest < precision_agreed     ? "ok"
           : extrapolated < precision_agreed ? "ok when extrapolated"
                                             : "above 1e-6";
  }
};

/// Refines one method until its error is no longer significant or its next run would take too long; false if
/// stopped. Whether it converges to the reference is decided from the extrapolation too, because methods of
/// low order would need days of small steps to agree; until they agree, runs of small bodies may take longer.
bool refine(Problem& p, const Reference& reference, const IntegratorInfo& info, const PrecisionConfig& config,
            std::vector<Run>& runs, Table& agreements, const Progress& progress) {
  const bool adaptive = info.stepping == Stepping::adaptive;
  Agreement agreement{reference.is_sharp()};
  const int most_runs = adaptive ? 11 : config.finest_halving;
  double before = 0;
  for (int i = 0; i < most_runs; ++i) {
    if (progress.stopped()) return false;
    Run run{.info = &info, .options = p.options};
    run.options.dt = adaptive ? 0 : p.scene.duration / std::ldexp(8.0, i);
    run.options.tolerance = std::pow(10.0, -1 - i);
    take(p, run);
    compare(p, reference, run);
    agreement.add(p, reference, info, run);
    const double seconds = run.seconds.front();
    const bool insignificant = run.error < precision_certainty * reference.uncertainty;
    runs.push_back(std::move(run));
    runs.back().end = {};
    const double growth = before > 0 ? std::clamp(seconds / before, 1.0, 4.0) : 2.0;
    const bool enough = agreement.reached() || !agreement.is_judged || !p.small();
    if (insignificant || seconds * growth > (enough ? config.seconds_per_run : config.seconds_to_agree))
      break;
    before = seconds;
  }
  agreements.add({p.scene.name, info.name, agreement.tightest, agreement.extrapolated, agreement.status()});
  return true;
}

Table empty_rows() {
  std::vector<Column> columns{{"scene"},   {"integrator"},   {"parameter"},    {"value"},
                              {"error"},   {"energy_drift"}, {"volume_drift"}, {"seconds", "s"},
                              {"q1", "s"}, {"q3", "s"},      {"repeats"},      {"explicit_steps"}};
  for (Column& column : work_columns()) columns.push_back(std::move(column));
  columns.push_back({"status"});
  return Table(std::move(columns));
}

Table empty_references() {
  return Table({{"scene"},
                {"description"},
                {"model"},
                {"particles"},
                {"springs"},
                {"linear_solver"},
                {"explicit_step_seconds", "s"},
                {"duration", "s"},
                {"displacement", "m"},
                {"uncertainty"},
                {"status"}});
}

Table empty_agreement() {
  return Table({{"scene"}, {"integrator"}, {"tightest_error"}, {"extrapolated_error"}, {"status"}});
}

/// Whether a method can move the body of a scene.
bool serves(Problem& p, const IntegratorInfo& info) {
  IntegratorOptions options = p.options;
  options.dt = frame;
  try {
    info.make<double>(options)->check(p.system);
  } catch (const InputError&) {
    return false;
  }
  return true;
}

/// All methods on one scene, the runs repeated in turn; false if stopped, with what is finished.
bool measure_scene(Problem& p, const Reference& reference, double step_seconds, const PrecisionConfig& config,
                   PrecisionTables& tables, Progress& progress, double done) {
  std::vector<Run> runs;
  bool finished = true;
  for (std::size_t m = 0; m < config.integrators.size() && finished; ++m) {
    progress.report(done + double(m) / double(config.integrators.size() * config.scenes.size()),
                    p.scene.name + ": " + config.integrators[m]);
    const IntegratorInfo& info = find_integrator(config.integrators[m]);
    if (!serves(p, info))
      tables.agreement.add({p.scene.name, info.name, no_value, no_value, std::string("refused")});
    else
      finished = refine(p, reference, info, config, runs, tables.agreement, progress);
  }
  finished = finished && interleave(config.repetitions - 1, runs.size(), progress, [&](std::size_t i) {
               if (runs[i].status == Status::ok && runs[i].spent() < config.seconds_per_row) take(p, runs[i]);
             });
  for (const Run& run : runs) add_row(tables.rows, p, step_seconds, run);
  return finished;
}

}  // namespace

PrecisionTables measure_precision(const PrecisionConfig& config, Progress& progress) {
  PrecisionTables tables{empty_rows(), empty_references(), empty_agreement()};
  for (std::size_t i = 0; i < config.scenes.size(); ++i) {
    Problem problem(config.scenes[i], config);
    const double done = double(i) / double(config.scenes.size());
    progress.report(done, config.scenes[i].name + ": reference");
    const Reference reference = find_reference(problem, config.reference_tolerance);
    const double step_seconds = explicit_step_seconds(problem.system);
    const bool known = reference.is_known();
    tables.references.add({problem.scene.name, problem.scene.description, config.model,
                           std::int64_t(problem.body.particle_count()),
                           std::int64_t(problem.body.spring_count()), problem.options.linear_solver,
                           step_seconds, problem.scene.duration, known ? reference.displacement : no_value,
                           known ? reference.uncertainty : no_value, reference.outcome()});
    if (!known) continue;  // nothing to compare with
    if (!measure_scene(problem, reference, step_seconds, config, tables, progress, done)) {
      tables.status = Status::interrupted;
      break;
    }
  }
  return tables;
}

}  // namespace mss::studies::precision

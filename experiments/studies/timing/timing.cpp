// The thesis's Fig. 5-3: time of one model update against cells per edge.
//
// Compared on the same cube, start and step, all with semi-implicit Euler (2-12):
//   algorithm_1       the thesis's Algorithm 1 as written, with atomic adds, by OpenMP
//   plain_loop        flat arrays, no atomics; double on one thread and on several, single on one
//   *_debug           both in a debug build, double (debug_build.cpp)
//   structured_sweep  this project's core, double and single
// The material is held fixed while n grows, so spring constants shrink as 1/n. Arithmetic does not depend on
// that, only the meaning of the numbers does.
#include "experiments/studies/timing/timing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <thread>
#include <utility>

#include "core/measures/measures.hpp"
#include "core/springs/spring_system.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/other_work.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/timing/devices.hpp"
#include "reference/algorithm1.hpp"
#include "reference/plain_loop.hpp"

namespace mss::studies::timing {

namespace {

using Workload = TimingWorkload;
constexpr const char* integrator_name = "semi_implicit_euler";
/// A sample that lasts this many times as long as planned is followed by shorter ones: threads of the
/// plain loop and of Algorithm 1 wait for each other, a hundred times as long beside other work, and the
/// study would too.
constexpr double disturbed_sample = 8;

/// One of the methods compared, ready to run on one body. Without `take` it is not run, and its row says why.
struct Competitor {
  std::string method;
  std::string precision;
  int threads;
  std::function<void(long)> take;  ///< makes that many updates
  std::function<bool()> finite;
  std::function<double()> threads_working = {};  ///< of those asked for, on average; none: all
  bool busy_waits = false;  ///< its threads keep their cores busy for a while after their work is done
  long steps = 0;           ///< updates per sample
  double estimate = 0;      ///< seconds per update, roughly
  std::int64_t atomic_additions = 0;  ///< per update
  std::vector<double> samples = {};
  std::string status = "skipped: too large";
  double working = 0;  ///< the fewest threads_working() of a pass
};

/// Results of one size: samples of all passes so far.
struct Size {
  int n;
  std::int64_t particles = 0, springs = 0;
  std::vector<Competitor> all = {};
};

double seconds_for(const Competitor& c, long steps) {
  return seconds_of([&] { c.take(steps); });
}

template <class Real>
const char* precision_of() {
  return sizeof(Real) == sizeof(float) ? "single" : "double";
}

template <class Real>
Competitor core_competitor(const Body& body, int threads) {
  struct Run {
    Run(const Body& b, int t)
        : system(b, {.gravity = Vec3(0, 0, Workload::gravity)}, {.threads = t}),
          integrator(find_integrator(integrator_name).make<Real>({.dt = Workload::dt})),
          state(stretched_state(system, Workload::stretch)) {}
    SpringSystem<Real> system;
    std::unique_ptr<Integrator<Real>> integrator;
    State<Real> state;
    Work work;
  };
  const auto run = std::make_shared<Run>(body, threads);
  const auto take = [run](long steps) {
    run->integrator->advance(run->system, run->state, run->state.t + double(steps) * Workload::dt, run->work);
  };
  return {"structured_sweep",
          precision_of<Real>(),
          threads,
          take,
          [run] { return is_finite(run->state); },
          [run] { return run->system.threads_working(); }};
}

Competitor algorithm1_competitor(const std::shared_ptr<reference::Algorithm1>& model, int threads) {
  const auto take = [model, threads](long steps) {
    model->set_threads(threads);
    for (long step = 0; step < steps; ++step) model->step(Workload::dt);
  };
  const auto finite = [model] {
    const auto& particles = model->particles();
    return std::all_of(particles.begin(), particles.end(),
                       [](const auto& p) { return p.x.allFinite() && p.v.allFinite(); });
  };
  return {"algorithm_1", "double", threads, take, finite, {}, threads > 1};
}

template <class Real>
Competitor plain_competitor(const reference::Algorithm1& model, int threads) {
  const auto loop = std::make_shared<reference::PlainLoop<Real>>(model, threads);
  const auto take = [loop](long steps) {
    for (long step = 0; step < steps; ++step) loop->step(Workload::dt);
  };
  const auto finite = [loop] {
    return std::all_of(loop->positions().begin(), loop->positions().end(),
                       [](const auto& x) { return x.allFinite(); });
  };
  return {"plain_loop", precision_of<Real>(), threads, take, finite, {}, threads > 1};
}

/// Algorithm 1 and the plain loop; what a body is too large for has nothing to run.
void add_thesis_competitors(const TimingConfig& config, const Body& body, std::vector<Competitor>& all) {
  if (body.config().voxels.nx() > config.largest_algorithm1) {
    for (const int threads : config.algorithm1_threads)
      all.push_back({"algorithm_1", "double", threads, {}, {}});
    for (const int threads : config.core_threads) all.push_back({"plain_loop", "double", threads, {}, {}});
    all.push_back({"plain_loop", "single", 1, {}, {}});
    return;
  }
  const Vec3 gravity(0, 0, Workload::gravity);
  const auto model = std::make_shared<reference::Algorithm1>(body.config(), gravity, 1);
  for (auto& p : model->particles()) p.x[2] *= Workload::stretch;
  for (const int threads : config.algorithm1_threads) {
    all.push_back(algorithm1_competitor(model, threads));
    all.back().atomic_additions = std::int64_t(model->atomic_additions());
  }
  for (const int threads : config.core_threads) all.push_back(plain_competitor<double>(*model, threads));
  all.push_back(plain_competitor<float>(*model, 1));
}

/// In the order of the table. Debug builds have nothing to run: add_debug_samples() does that.
std::vector<Competitor> competitors(const TimingConfig& config, const Body& body) {
  std::vector<Competitor> all;
  add_thesis_competitors(config, body, all);
  for (const int threads : config.core_threads) all.push_back(core_competitor<double>(body, threads));
  for (const int threads : config.core_threads) all.push_back(core_competitor<float>(body, threads));
  if (config.largest_debug_build == 0) return all;
  const std::int64_t additions = all.front().atomic_additions;  // Algorithm 1's
  for (const int threads : config.algorithm1_threads) {
    all.push_back({"algorithm_1_debug", "double", threads, {}, {}});
    all.back().atomic_additions = additions;
  }
  all.push_back({"plain_loop_debug", "double", 1, {}, {}});
  return all;
}

/// Warms a competitor up and finds how many updates make a sample.
void calibrate_steps(Competitor& c, double sample_seconds) {
  c.take(1);  // first touch of its memory, threads started
  const SampleLength length =
      sample_length(sample_seconds, [&](long steps) { return seconds_for(c, steps); });
  c.steps = length.steps;
  c.estimate = length.seconds_per_step;
}

/// Idle OpenMP threads busy-wait for some 10 ms before they sleep, on cores that the next method needs.
void let_threads_sleep(const Competitor& c) {
  if (c.busy_waits) std::this_thread::sleep_for(std::chrono::milliseconds(20));
}

int repetitions_for(const TimingConfig& config, const std::vector<Competitor>& all) {
  double round = 0;
  for (const Competitor& c : all) round += c.estimate * double(c.steps + 1);
  const double affordable = std::clamp(config.seconds_per_size / round, double(config.fewest_repetitions),
                                       double(config.repetitions));
  return int(std::ceil(affordable / config.passes));
}

Table empty_rows() {
  return Table({{"method"},
                {"integrator"},
                {"precision"},
                {"threads"},
                {"cells"},
                {"particles"},
                {"springs"},
                {"seconds_per_step", "s"},
                {"q1", "s"},
                {"q3", "s"},
                {"repeats"},
                {"status"},
                {"ns_per_spring", "ns"},
                {"steps_per_sample"},
                {"atomic_additions"},
                {"threads_working"}});
}

Table empty_raw() {
  return Table({{"method"},
                {"precision"},
                {"threads"},
                {"cells"},
                {"pass"},
                {"repetition"},
                {"steps"},
                {"seconds_per_step", "s"}});
}

void add_row(Table& rows, const Competitor& c, const Size& size) {
  const Quartiles time = quartiles(c.samples);
  rows.add({c.method, integrator_name, c.precision, std::int64_t(c.threads), std::int64_t(size.n),
            size.particles, size.springs, time.median, time.q1, time.q3, std::int64_t(c.samples.size()),
            c.status, 1e9 * time.median / double(size.springs), std::int64_t(c.steps), c.atomic_additions,
            c.working});
}

/// Adds the samples of one pass to those of the passes before, and frees the bodies.
void pool(Size& size, std::vector<Competitor> all) {
  for (std::size_t i = 0; i < all.size(); ++i) {
    Competitor& c = all[i];
    if (c.take) c.status = to_string(c.finite() ? Status::ok : Status::non_finite);
    c.working = c.threads_working ? c.threads_working() : c.threads;
    if (!size.all.empty()) c.working = std::min(c.working, size.all[i].working);
    c.threads_working = {};
    c.take = {};
    c.finite = {};
    if (!size.all.empty() && size.all[i].status != to_string(Status::ok)) c.status = size.all[i].status;
    if (!size.all.empty())
      c.samples.insert(c.samples.begin(), size.all[i].samples.begin(), size.all[i].samples.end());
  }
  size.all = std::move(all);
}

/// A sample of one method on the body of a size.
void add_sample(Competitor& c, int n, int pass, double seconds, Table& raw) {
  c.samples.push_back(seconds);
  raw.add({c.method, c.precision, std::int64_t(c.threads), n, pass, std::int64_t(c.samples.size() - 1),
           std::int64_t(c.steps), seconds});
}

/// Those of the debug builds, which a program of their own takes.
void add_debug_samples(const TimingConfig& config, int n, int pass, std::vector<Competitor>& all,
                       Table& raw) {
  if (n > config.largest_debug_build) return;
  const int repetitions = std::max(1, config.fewest_repetitions / config.passes + 1);
  const Table samples = debug_build_samples(n, repetitions, config.sample_seconds, config.algorithm1_threads);
  for (Competitor& c : all) {
    if (c.take || !c.method.ends_with("_debug")) continue;
    const Table own = samples.where("method", c.method).where("threads", c.threads);
    c.status = own.size() > 0 ? to_string(Status::ok) : "skipped: mss_debug_build failed";
    for (std::size_t r = 0; r < own.size(); ++r) {
      c.steps = long(own.number(r, "steps"));
      add_sample(c, n, pass, own.number(r, "seconds_per_step"), raw);
    }
  }
}

/// Measures all methods on one body, once per repetition; false if stopped before the end, with nothing
/// added.
bool measure_size(const TimingConfig& config, int pass, Size& size, Table& raw, Progress& progress,
                  const std::function<void(double)>& report) {
  const Body body(timing_cube(size.n));
  size.particles = std::int64_t(body.particle_count());
  size.springs = std::int64_t(body.spring_count());
  std::vector<Competitor> all = competitors(config, body);
  for (Competitor& c : all) {
    if (!c.take) continue;
    if (progress.stopped()) return false;
    calibrate_steps(c, config.sample_seconds);
    let_threads_sleep(c);
  }
  const int repetitions = repetitions_for(config, all);
  Table measured = raw;
  const auto sample = [&](std::size_t i) {
    Competitor& c = all[i];
    if (!c.take) return;
    report(double(c.samples.size()) / repetitions);
    c.take(1);  // its data back into the caches, its threads awake
    const double seconds = seconds_for(c, c.steps);
    add_sample(c, size.n, pass, seconds / double(c.steps), measured);
    if (seconds > disturbed_sample * config.sample_seconds) c.steps = std::max(1L, c.steps / 2);
    let_threads_sleep(c);
  };
  if (!interleave(repetitions, all.size(), progress, sample)) return false;
  add_debug_samples(config, size.n, pass, all, measured);
  if (progress.stopped()) return false;  // Ctrl-C ended that program too
  raw = std::move(measured);
  pool(size, std::move(all));
  return true;
}

Json configuration(const TimingConfig& config, const FeatureTimingConfig& features,
                   const ShapeTimingConfig& shapes, const MethodTimingConfig& methods) {
  return {{"cells", config.cells},
          {"algorithm_1_threads", config.algorithm1_threads},
          {"structured_sweep_threads", config.core_threads},
          {"threads_note", "as requested; the sweep uses at most one thread per plane of particles, n + 1"},
          {"passes", config.passes},
          {"repetitions", config.repetitions},
          {"fewest_repetitions", config.fewest_repetitions},
          {"sample_seconds", config.sample_seconds},
          {"seconds_per_size", config.seconds_per_size},
          {"largest_algorithm_1", config.largest_algorithm1},
          {"largest_debug_build", config.largest_debug_build},
          {"debug_build", debug_build_flags()},
          {"order",
           "methods in turn, the first one changing from repetition to repetition; passes over the sizes up "
           "and down in turn"},
          {"threads_pinned", false},
          {"features",
           {{"cells", features.cells},
            {"threads", 1},
            {"repetitions", features.repetitions},
            {"sample_seconds", features.sample_seconds}}},
          {"shapes",
           {{"cells", shapes.cells},
            {"threads", 1},
            {"repetitions", shapes.repetitions},
            {"sample_seconds", shapes.sample_seconds}}},
          {"methods",
           {{"cells", methods.cells},
            {"threads", methods.threads},
            {"repetitions", methods.repetitions},
            {"sample_seconds", methods.sample_seconds}}},
          {"workload",
           {{"held_fixed", "cube edge and material; cell size and spring constants shrink as 1/n"},
            {"edge", Workload::edge},
            {"density", Workload::density},
            {"young", Workload::material.young},
            {"poisson", Workload::material.poisson},
            {"face_share", Workload::face_share},
            {"damping_ratio", Workload::damping_ratio},
            {"gravity_z", Workload::gravity},
            {"start_stretch_z", Workload::stretch},
            {"dt", Workload::dt},
            {"integrator", integrator_name}}}};
}

constexpr const char* caption =
    "Time of one update (springs, damping, gravity, volume, one semi-implicit Euler step) of a full cube "
    "against its cells per edge n. Edge (1 m) and material (E = 100 kPa, nu = 0.3) are held fixed while n"
    " grows, so spring constants shrink as 1/n. Points are medians, bars quartiles of samples that are "
    "interleaved, in passes over all sizes. Algorithm 1 is the thesis's, as written (12 atomic additions a "
    "spring and, by the volume force, 24 a cell); the plain loop has no atomics and, unless it says "
    "otherwise, one thread; the sweep is this project's core. Debug builds are the same sources without "
    "optimisation and with checked containers, in a program of their own. The "
    "legend gives the exponent of time in n, fitted over n of 20 and more, and the largest n under 40 ms:"
    " interpolated between measured sizes, or by the fit where it lies beyond them; either is withheld where "
    "quartiles of the samples are too far apart to say, or other work took too much of the cores. The star "
    "is the one "
    "published time (Fig. 5-3: n = 7, 40 ms, 8 threads on an i7-4712MQ); the bar is the same time if an "
    "update means 3 to 5 steps, as the text states elsewhere. Algorithm 1 with 8 threads shows the cost of "
    "more threads "
    "than cores, if the machine has fewer. Bullet's soft body (--peers) has the same particles and springs "
    "as "
    "links of full stiffness, one iteration a step of 1/60 s, without collisions. A simulated second "
    "(timing_seconds) is on one thread for all: of the loops and the sweep, whose steps last as long "
    "whatever "
    "their size, at the safe step of semi-implicit Euler, of XPBD at a twentieth of a frame of 1/60 s, of "
    "the others at a frame, with the iterations that "
    "the table names; at these steps their errors differ, and Bullet's links have no modulus. The rates of "
    "Titan and Cronos (timing_rates) are quoted from their authors' abstracts "
    "(reference/published_rates.csv), "
    "for GPUs that these do not name, in primitives and elements; they were not measured here.";

ExperimentResult run_timing(const ExperimentOptions& options, Progress& progress) {
  if (options.devices) return run_devices(options, progress);
  const TimingConfig config = timing_config(options);
  FeatureTimingConfig features;
  ShapeTimingConfig shapes;
  MethodTimingConfig methods{.threads = config.core_threads};
  if (options.quick) {
    features = {.cells = {7, 20}, .repetitions = 5};
    shapes = {.cells = {20}, .repetitions = 5, .sample_seconds = 4e-3};
    methods = {.cells = {7, 20}, .threads = {1}, .repetitions = 5, .sample_seconds = 4e-3};
  }
  const OtherWorkWatch watch;
  TimingTables tables = measure_timing(config, progress);
  const double other_work = watch.so_far().value_or(OtherWork{}).share;
  const Table summary = timing_summary(tables.rows, other_work), passes = timing_passes(tables.raw),
              limits = timing_limits(tables.rows, tables.peaks, other_work);
  ExperimentResult result{.status = tables.status,
                          .caption = caption,
                          .configuration = configuration(config, features, shapes, methods)};
  if (tables.rows.size() > 0)
    result.summary =
        timing_text(tables.rows, summary, other_work) + passes_text(passes) + limits_text(limits);
  FeatureTables shares = measure_features(features, progress);
  Table per_particle = measure_shapes(shapes, progress);
  Table iterations = measure_methods(methods, progress);
  if (options.peers) {
    PeerTimingConfig peers{.threads = config.core_threads};
    if (options.quick) peers = {.cells = {7, 20}, .threads = config.core_threads, .repetitions = 3};
    result.tables.push_back({"timing_peers", measure_peers(peers, progress)});
    result.summary += peers_text(result.tables.back().table);
  }
  if (progress.stopped()) result.status = Status::interrupted;
  const std::vector<NamedTable> others = std::move(result.tables);
  result.tables = {{"timing", std::move(tables.rows)},
                   {"timing_summary", summary},
                   {"timing_passes", passes},
                   {"timing_limits", limits},
                   {"timing_peaks", std::move(tables.peaks)},
                   {"timing_features", std::move(shares.features)},
                   {"timing_lean", std::move(shares.lean)},
                   {"timing_shapes", std::move(per_particle)},
                   {"timing_methods", std::move(iterations)},
                   {"timing_raw", std::move(tables.raw)}};
  result.tables.insert(result.tables.end(), others.begin(), others.end());
  const Table seconds = timing_seconds(result.tables);
  result.tables.insert(result.tables.begin() + 1, {"timing_seconds", seconds});
  result.summary += seconds_text(seconds);
  return result;
}

}  // namespace

TimingConfig timing_config(const ExperimentOptions& options) {
  TimingConfig config;
  config.cells = options.cells;
  if (config.cells.empty()) {
    for (int n = 2; n <= 15; n += options.quick && n > 2 ? 4 : 1) config.cells.push_back(n);
    config.cells.insert(config.cells.end(), {20, 30});
    if (!options.quick) config.cells.insert(config.cells.end(), {50, 100});
  }
  const int most = options.threads > 0 ? options.threads : available_cores();
  if (most > 1) config.core_threads.push_back(most);
  if (options.quick) {
    config.passes = 1;
    config.repetitions = 7;
    config.seconds_per_size = 1;
  }
  return config;
}

TimingTables measure_timing(const TimingConfig& config, Progress& progress) {
  TimingTables tables{empty_rows(), empty_raw(), empty_peaks()};
  std::vector<Size> sizes;
  for (const int n : config.cells) sizes.push_back({.n = n});
  const std::size_t total = std::size_t(config.passes) * sizes.size();
  for (std::size_t i = 0; i < total && tables.status == Status::ok; ++i) {
    const std::size_t pass = i / sizes.size(), place = i % sizes.size();
    Size& size = sizes[pass % 2 == 0 ? place : sizes.size() - 1 - place];
    const auto report = [&](double part) {
      progress.report((double(i) + part) / double(total), fmt::format("{} cells per edge", size.n));
    };
    report(0);
    if (place == 0 && !progress.stopped()) add_peaks(int(pass), config.core_threads, tables.peaks);
    if (progress.stopped() || !measure_size(config, int(pass), size, tables.raw, progress, report))
      tables.status = Status::interrupted;
  }
  for (const Size& size : sizes)
    for (const Competitor& c : size.all) add_row(tables.rows, c, size);
  return tables;
}

namespace {

void check_devices() { timed_devices(); }

/// Times depend on the machine; the timed bodies and their final states do not.
Table baseline_table(const BaselineOptions& options, Progress& progress) {
  Table table(
      {{"cells"}, {"particles"}, {"springs"}, {"total", "J"}, {"volume_ratio"}, {"max_speed", "m/s"}});
  for (const int n : options.quick ? std::vector<int>{2, 7} : std::vector<int>{2, 7, 15, 30}) {
    if (progress.stopped()) break;
    const Body body(timing_cube(n));
    SpringSystem<double> system(body, {.gravity = Vec3(0, 0, Workload::gravity)},
                                {.threads = options.threads});
    State<double> state = stretched_state(system, Workload::stretch);
    Work work;
    find_integrator(integrator_name)
        .make<double>({.dt = Workload::dt})
        ->advance(system, state, 200 * Workload::dt, work);
    const Measures m = measure(system, state);
    table.add({n, std::int64_t(body.particle_count()), std::int64_t(body.spring_count()), m.total(),
               m.volume_ratio, m.max_speed});
  }
  return table;
}

}  // namespace

ExperimentInfo experiment() {
  return {
      .name = "timing",
      .summary =
          "time of one update against cells per edge: Algorithm 1, plain loop, structured sweep (Fig. 5-3)",
      .accepts =
          {.cells = true, .largest_cells = 200, .threads = true, .peers = true, .devices = check_devices},
      .run = run_timing,
      .draw = draw_timing,
      .baseline = {.keys = {"cells"},
                   .rules = {{"total", 1e-9}, {"volume_ratio", 1e-10}, {"max_speed", 1e-9}},
                   .table = baseline_table}};
}

}  // namespace mss::studies::timing

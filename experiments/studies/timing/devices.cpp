// `mss timing --devices`: the time of a step on every device, beside the processor's. A time is written only
// of what computes the same motion as the processor does in double precision.
#include "experiments/studies/timing/devices.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "core/base/error.hpp"
#include "core/springs/spring_system.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/other_work.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/studies/timing/timing.hpp"
#include "integrators/integrator.hpp"

namespace mss::studies::timing {

namespace {

const Environment falling{.gravity = Vec3(0, 0, TimingWorkload::gravity)};
constexpr const char* processor = "processor";
constexpr const char* main_method = "semi_implicit_euler";
constexpr long most_steps_in_sample =
    1024;                             // the cube falls: after more, single precision has few digits left
constexpr int small_cube = 7;         ///< cells per edge, that tells what larger ones would take
constexpr int largest_lattice = 890;  // cells per edge whose sites shaders can number

/// A method at the step that it is timed at.
struct DeviceMethod {
  std::string name;
  double dt;  ///< [s]
  int iterations;
};

DeviceMethod device_method(const std::string& name, int n) {
  const double own = step_of_method(name);
  const bool is_explicit = name == main_method || std::isnan(own);
  return {name, is_explicit ? safe_step(n) : own, name == "vbd" ? 10 : 1};
}

/// Others than semi-implicit Euler that devices step.
std::vector<std::string> other_methods() {
  std::vector<std::string> names;
  for (const char* name : {"velocity_verlet", "xpbd", "vbd"})
    if (find_integrator(name).make_double_on_device) names.emplace_back(name);
  return names;
}

/// From -1 to 1, the same on every machine (splitmix64).
double rough_number(std::uint64_t place) {
  std::uint64_t s = place + 0x9e3779b97f4a7c15U;
  s = (s ^ (s >> 30U)) * 0xbf58476d1ce4e5b9U;
  s = (s ^ (s >> 27U)) * 0x94d049bb133111ebU;
  s ^= s >> 31U;
  return 2 * double(s >> 11U) / double(std::uint64_t{1} << 53U) - 1;
}

/// A start in which every spring is loaded and every particle moves: places and speeds differ from those of a
/// drifting cube by up to a tenth of a cell, and of a cell a step. All numbers are exact in single precision,
/// so that both precisions start alike.
template <class Real>
State<Real> rough_start(const SpringSystem<Real>& system, double dt) {
  constexpr double rough = 0.1, drift = 0.2;  // cells, and cells a step
  State<Real> state = system.rest_state();
  const double cell = system.body().config().cell_size;
  for (const std::ptrdiff_t site : system.body().sites()) {
    const Vec3 rest = state.x.at(site);
    Vec3 x, v;
    for (int axis = 0; axis < 3; ++axis) {
      const std::uint64_t place = 6 * std::uint64_t(site) + std::uint64_t(axis);
      x[axis] = float(rest[axis] + rough * cell * rough_number(place));
      v[axis] = float((drift + rough * rough_number(place + 3)) * cell / dt);
    }
    state.x.set(site, x);
    state.v.set(site, v);
  }
  return state;
}

/// Where the processor takes the cube in double precision.
struct ExpectedMotion {
  ExpectedMotion(const Body& body, const DeviceMethod& method, int check_steps, int threads)
      : steps(check_steps) {
    SpringSystem<double> system(body, falling, {.threads = threads});
    start = end = rough_start(system, method.dt);
    Work work;
    find_integrator(method.name)
        .make<double>({.dt = method.dt, .iterations = method.iterations})
        ->advance(system, end, steps * method.dt, work);
  }
  int steps;
  State<double> start, end;
};

/// What takes steps: a device, or so many threads of the processor.
struct TimedPlace {
  std::string choice, name;
  int threads;       ///< 0: of a device
  double bandwidth;  ///< [B/s]
};

/// A cube that steps somewhere in one precision.
class SteppedCube {
 public:
  SteppedCube(TimedPlace where, bool is_single) : place(std::move(where)), single(is_single) {}
  SteppedCube(const SteppedCube&) = delete;
  SteppedCube& operator=(const SteppedCube&) = delete;
  virtual ~SteppedCube() = default;

  /// Takes steps from the start. Returns seconds for them; `carrying` are not among these.
  virtual double take(long count) = 0;
  /// Of the motion that was taken last.
  virtual double error(const ExpectedMotion& expected) const = 0;

  TimedPlace place;
  bool single;
  Status status = Status::ok;  ///< of what was taken last
  double carrying = 0;         ///< the state there and back [s], then
  double error_found = no_value;
  SampleLength length{.steps = 1, .seconds_per_step = 0};
  std::vector<double> samples{}, carries{};
};

template <class Real>
class SteppedCubeOf final : public SteppedCube {
 public:
  SteppedCubeOf(const Body& body, const TimedPlace& where, const DeviceMethod& method)
      : SteppedCube(where, sizeof(Real) == sizeof(float)),
        dt_(method.dt),
        system_(body, falling, {.threads = std::max(1, where.threads)}),
        integrator_(find_integrator(method.name)
                        .make<Real>({.dt = dt_, .iterations = method.iterations, .device = where.choice})),
        start_(rough_start(system_, dt_)) {}

  double take(long count) override {
    state_ = start_;
    integrator_->reset();
    Work work;
    const double before = integrator_->transfer_seconds();
    const double seconds =
        seconds_of([&] { status = integrator_->advance(system_, state_, double(count) * dt_, work); });
    carrying = integrator_->transfer_seconds() - before;
    return seconds - carrying;
  }

  double error(const ExpectedMotion& expected) const override {
    return error_over_motion(system_.body(), expected.start, expected.end, state_);
  }

 private:
  double dt_;
  SpringSystem<Real> system_;
  std::unique_ptr<Integrator<Real>> integrator_;
  State<Real> start_, state_{};
};

std::string name_of_place(const TimedPlace& place, bool single) {
  const std::string threads =
      place.threads == 0 ? "" : fmt::format(", {} thread{}", place.threads, place.threads == 1 ? "" : "s");
  return fmt::format("{}{} in {} precision", place.name, threads, single ? "single" : "double");
}

/// 3 n (n + 1)^2 edges, 6 n^2 (n + 1) face diagonals, 4 n^3 body diagonals.
double springs_of_cube(double n) { return 3 * n * (n + 1) * (n + 1) + 6 * n * n * (n + 1) + 4 * n * n * n; }

/// More than the 32 that a device takes at once where that is quick.
int steps_of_check(const std::string& method, int n) { return method == main_method && n <= 30 ? 40 : 8; }

Table empty_device_rows() {
  return Table({{"device"},
                {"solve_device"},
                {"precision"},
                {"threads"},
                {"method"},
                {"iterations"},
                {"cells"},
                {"particles"},
                {"springs"},
                {"seconds_per_step", "s"},
                {"q1", "s"},
                {"q3", "s"},
                {"repeats"},
                {"status"},
                {"springs_per_second", "1/s"},
                {"bytes_per_step", "B"},
                {"bandwidth", "B/s"},
                {"share_of_bandwidth"},
                {"carry_seconds", "s"},
                {"steps_per_sample"},
                {"check_steps"},
                {"error"}});
}

/// Times steps on cubes, from small to large.
class DeviceStudy {
 public:
  DeviceStudy(const DeviceTimingConfig& config, const std::vector<TimedDevice>& devices, Progress& progress)
      : config_(config), progress_(progress) {
    Table peaks = empty_peaks();
    add_peaks(0, config.threads, peaks);
    for (const int threads : config.threads)
      places_.push_back({"cpu", processor, threads,
                         peaks.where("quantity", "triad").where("threads", threads).number(0, "rate")});
    for (const TimedDevice& device : devices)
      places_.push_back({device.choice, device.name, 0, copy_bandwidth(device)});
  }

  /// False if stopped before the end, with nothing added.
  bool measure(const std::string& name, int n, double done) {
    std::vector<Wanted> wanted;
    for (const TimedPlace& place : places_)
      for (const bool single : {false, true})
        if (is_affordable(place, single, name, n)) wanted.push_back({&place, single});
    progress_.report(
        done, fmt::format("{}, {} cells per edge{}", name, n, notes.empty() ? "" : "; " + notes.back()));
    return wanted.empty() || measure_together(wanted, device_method(name, n), n);
  }

  /// The largest cube that fits on a card, in single precision, without the processor beside it.
  bool measure_largest(const TimedDevice& device, double done) {
    const auto place = std::find_if(places_.begin(), places_.end(),
                                    [&](const TimedPlace& p) { return p.choice == device.choice; });
    const int known = config_.cells.back();
    const Bound bound = largest_affordable();
    const int n = bound.cells > known ? largest_cube_on(device, known, bound.cells) : known;
    notes.push_back(fmt::format("{}: the largest cube has {} cells per edge, because of {}", device.name, n,
                                n < bound.cells ? "the device's memory" : bound.reason));
    progress_.report(done, notes.back());
    return n == known || measure_together({{&*place, true}}, device_method(main_method, n), n);
  }

  Table rows = empty_device_rows();
  std::vector<std::string> notes{};

 private:
  struct Wanted {
    const TimedPlace* place;
    bool single;
  };
  /// What a step took at the last size.
  struct LastTime {
    std::string name, method;
    double springs, seconds;
    bool ended;  ///< larger sizes are left out
  };
  struct Bound {
    int cells;
    const char* reason;
  };
  using Cubes = std::vector<std::unique_ptr<SteppedCube>>;

  LastTime& last_time(const TimedPlace& place, bool single, const std::string& method) {
    const std::string name = name_of_place(place, single);
    const auto found = std::find_if(last_.begin(), last_.end(),
                                    [&](const LastTime& t) { return t.name == name && t.method == method; });
    return found != last_.end() ? *found : *last_.insert(last_.end(), {name, method, 1, 0, false});
  }

  /// Whether a row would not take too long, by the size before, or a small one that has no row.
  bool is_affordable(const TimedPlace& place, bool single, const std::string& method, int n) {
    LastTime& last = last_time(place, single, method);
    if (!last.ended && last.seconds == 0 && n > small_cube) estimate(place, single, method, last);
    const int steps = steps_of_check(method, n) + config_.repetitions + 2;
    if (last.ended || last.seconds * springs_of_cube(n) / last.springs * steps <= config_.seconds_per_row)
      return !last.ended;
    end_at(n, fmt::format("it would take longer than {} s", config_.seconds_per_row), last);
    return false;
  }

  void estimate(const TimedPlace& place, bool single, const std::string& name, LastTime& last) {
    const Body body(timing_cube(small_cube));
    const DeviceMethod method = device_method(name, small_cube);
    constexpr long steps = 8;
    double seconds = 0;
    const auto time_steps = [&](SteppedCube& cube) {
      cube.take(steps);  // compiles shaders
      seconds = cube.take(steps);
    };
    if (single) {
      SteppedCubeOf<float> cube(body, place, method);
      time_steps(cube);
    } else {
      SteppedCubeOf<double> cube(body, place, method);
      time_steps(cube);
    }
    last.springs = double(body.spring_count());
    last.seconds = seconds / double(steps);
  }

  void end_at(int n, const std::string& why, LastTime& last) {
    last.ended = true;
    notes.push_back(
        fmt::format("{}, {}: left out from {} cells per edge on: {}", last.name, last.method, n, why));
  }

  /// The most cells per edge that the time for the largest cube, the host's memory and the numbers of sites
  /// allow.
  Bound largest_affordable() const {
    constexpr double bytes_of_particle = 300;  // on the host: a body, two systems, four states
    const double memory = double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGE_SIZE)) / 2;
    const auto edge = [](double particles) { return int(std::cbrt(particles)) - 1; };
    return std::min(
        {Bound{largest_lattice, "the number of sites"},
         Bound{edge(memory / bytes_of_particle), "the host's memory"},
         Bound{edge(config_.seconds_for_largest / setup_seconds_), "the time that it takes to prepare"}},
        [](const Bound& a, const Bound& b) { return a.cells < b.cells; });
  }

  bool measure_together(const std::vector<Wanted>& wanted, const DeviceMethod& method, int n) {
    const Stopwatch watch;
    const Body body(timing_cube(n));
    const ExpectedMotion expected(body, method, steps_of_check(method.name, n), config_.threads.back());
    const double shared = watch.seconds();
    Cubes cubes;
    for (const Wanted& w : wanted) {
      if (progress_.stopped()) return false;
      const Stopwatch own;
      if (auto cube = make_checked(w, body, method, expected)) cubes.push_back(std::move(cube));
      setup_seconds_ = (shared + own.seconds()) / double(body.particle_count());
    }
    if (!take_samples(cubes)) return false;
    for (const auto& cube : cubes) {
      add_device_row(*cube, method, body, expected.steps);
      LastTime& last = last_time(cube->place, cube->single, method.name);
      last.springs = double(body.spring_count());
      last.seconds = cube->length.seconds_per_step;
      if (cube->samples.empty())
        end_at(n + 1, fmt::format("its motion is {} at {}", rows.text(rows.size() - 1, "status"), n), last);
    }
    return true;
  }

  /// Nothing if the device has no room for it.
  std::unique_ptr<SteppedCube> make_checked(const Wanted& w, const Body& body, const DeviceMethod& method,
                                            const ExpectedMotion& expected) {
    try {
      std::unique_ptr<SteppedCube> cube;
      if (w.single)
        cube = std::make_unique<SteppedCubeOf<float>>(body, *w.place, method);
      else
        cube = std::make_unique<SteppedCubeOf<double>>(body, *w.place, method);
      cube->take(expected.steps);
      cube->error_found = cube->status == Status::ok ? cube->error(expected) : no_value;
      return cube;
    } catch (const InputError& problem) {
      end_at(body.config().voxels.nx(), problem.what(), last_time(*w.place, w.single, method.name));
      return nullptr;
    }
  }

  /// Of those that compute the right motion. False if stopped.
  bool take_samples(const Cubes& cubes) {
    std::vector<SteppedCube*> right;
    for (const auto& cube : cubes) {
      if (!is_right(cube->error_found, cube->single)) continue;
      right.push_back(cube.get());
      cube->length = sample_length(config_.sample_seconds, [&](long count) { return cube->take(count); });
      cube->length.steps = std::min(cube->length.steps, most_steps_in_sample);
    }
    return interleave(config_.repetitions, right.size(), progress_, [&](std::size_t i) {
      SteppedCube& cube = *right[i];
      cube.samples.push_back(cube.take(cube.length.steps) / double(cube.length.steps));
      cube.carries.push_back(cube.carrying);
    });
  }

  void add_device_row(const SteppedCube& cube, const DeviceMethod& method, const Body& body,
                      int check_steps) {
    const auto particles = double(body.particle_count()), springs = double(body.spring_count());
    const bool is_timed = cube.status == Status::ok && !cube.samples.empty();
    const Quartiles time = quartiles(is_timed ? cube.samples : std::vector<double>{});
    const double bytes = least_bytes_per_step(particles, cube.single);
    const std::string status{is_timed || cube.status != Status::ok ? to_string(cube.status) : wrong_motion};
    rows.add({cube.place.name,
              cube.place.choice,
              std::string(cube.single ? "single" : "double"),
              cube.place.threads,
              method.name,
              method.iterations,
              body.config().voxels.nx(),
              std::int64_t(body.particle_count()),
              std::int64_t(body.spring_count()),
              time.median,
              time.q1,
              time.q3,
              std::int64_t(cube.samples.size()),
              status,
              springs / time.median,
              bytes,
              cube.place.bandwidth,
              bytes / time.median / cube.place.bandwidth,
              quartiles(is_timed ? cube.carries : std::vector<double>{}).median,
              std::int64_t(cube.length.steps),
              check_steps,
              cube.error_found});
  }

  const DeviceTimingConfig& config_;
  Progress& progress_;
  std::vector<TimedPlace> places_;
  std::vector<LastTime> last_;
  double setup_seconds_ = 0;  ///< for a particle, of the cube last made
};

constexpr const char* devices_caption =
    "Springs updated in a second (springs, damping, gravity, volume, one step of semi-implicit Euler) of a "
    "full cube against its cells per edge n, on devices and on threads of the processor. Edge and material "
    "are "
    "those of `timing`; steps are the safe ones of semi-implicit Euler, XPBD's a twentieth of a frame of "
    "1/60 "
    "s, of vertex block descent a frame with ten iterations. Points are medians, bars quartiles of samples "
    "that are interleaved. Samples are several steps of one advance; carrying the state to the device and "
    "back "
    "is timed apart. Before anything is timed, every device and precision takes a few steps from a rough, "
    "drifting start, and no time is written if a particle is further from where the processor takes it in "
    "double precision than 1e-10 (double) or 1e-4 (single) of the longest way. The share of the bandwidth is "
    "that of the least that a step must move: places and velocities read and written once, kinds read once; "
    "it is above 1 where caches hold the cube. The bandwidth of a device is that of copies of a large "
    "buffer, "
    "of the processor that of the triad of `timing`, both measured in the same run.";

Json devices_configuration(const DeviceTimingConfig& config, const std::vector<TimedDevice>& devices,
                           const DeviceTables& tables, const Table& summary) {
  Json named = Json::array(), faster = Json::array();
  for (const TimedDevice& d : devices)
    named.push_back({{"solve_device", d.choice}, {"name", d.name}, {"in_software", d.is_software}});
  for (std::size_t r = 0; r < summary.size(); ++r) {
    const double cells = summary.number(r, "faster_from_cells");
    faster.push_back({{"solve_device", summary.text(r, "solve_device")},
                      {"precision", summary.text(r, "precision")},
                      {"cells", std::isnan(cells) ? Json() : Json(cells)},
                      {"how", summary.text(r, "how")}});
  }
  return {{"devices", named},
          {"cells", config.cells},
          {"threads", config.threads},
          {"other_methods", other_methods()},
          {"cells_of_other_methods", config.method_cells},
          {"repetitions", config.repetitions},
          {"sample_seconds", config.sample_seconds},
          {"seconds_per_row", config.seconds_per_row},
          {"seconds_for_largest", config.seconds_for_largest},
          {"allowed_error", {{"double", allowed_error(false)}, {"single", allowed_error(true)}}},
          {"left_out", tables.notes},
          {"faster_than_two_threads_from", faster}};
}

}  // namespace

template <class Real>
double error_over_motion(const Body& body, const State<double>& start, const State<double>& expected,
                         const State<Real>& found) {
  double way = 0, error = 0;
  for (const std::ptrdiff_t site : body.sites()) {
    const double distance = (found.x.at(site) - expected.x.at(site)).norm();
    if (!std::isfinite(distance) || !found.v.at(site).allFinite()) return no_value;
    error = std::max(error, distance);
    way = std::max(way, (expected.x.at(site) - start.x.at(site)).norm());
  }
  return error / way;
}
template double error_over_motion(const Body&, const State<double>&, const State<double>&,
                                  const State<float>&);
template double error_over_motion(const Body&, const State<double>&, const State<double>&,
                                  const State<double>&);

DeviceTimingConfig device_timing_config(const ExperimentOptions& options) {
  DeviceTimingConfig config{.cells = {7, 10, 15, 20, 30, 50, 70, 100, 150, 200}, .method_cells = {20, 100}};
  if (options.quick)
    config = {.cells = {7, 10}, .method_cells = {7}, .repetitions = 3, .seconds_for_largest = 0};
  if (!options.cells.empty()) {
    config.cells = config.method_cells = options.cells;
    config.seconds_for_largest = 0;
  }
  const int most = options.threads > 0 ? options.threads : available_cores();
  if (most > 1) config.threads.push_back(2);
  if (most > 2) config.threads.push_back(most);
  return config;
}

DeviceTables measure_devices(const DeviceTimingConfig& config, const std::vector<TimedDevice>& devices,
                             Progress& progress) {
  progress.report(0, "bandwidths");
  DeviceStudy study(config, devices, progress);
  const std::vector<std::string> others = other_methods();
  const double total = double(config.cells.size() + others.size() * config.method_cells.size());
  double done = 0;
  bool goes_on = true;
  for (const int n : config.cells)
    goes_on = goes_on && !progress.stopped() && study.measure(main_method, n, done++ / total);
  for (const TimedDevice& device : devices)
    if (goes_on && !device.is_software && config.seconds_for_largest > 0)
      goes_on = !progress.stopped() && study.measure_largest(device, done / total);
  for (const std::string& method : others)
    for (const int n : config.method_cells)
      goes_on = goes_on && !progress.stopped() && study.measure(method, n, done++ / total);
  return {std::move(study.rows), std::move(study.notes), goes_on ? Status::ok : Status::interrupted};
}

ExperimentResult run_devices(const ExperimentOptions& options, Progress& progress) {
  const DeviceTimingConfig config = device_timing_config(options);
  const std::vector<TimedDevice> devices = timed_devices();
  const OtherWorkWatch watch;
  DeviceTables tables = measure_devices(config, devices, progress);
  const double other_work = watch.so_far().value_or(OtherWork{}).share;
  const Table summary = devices_summary(tables.rows, other_work),
              time = devices_time(tables.rows, other_work);
  ExperimentResult result{.status = tables.status,
                          .caption = devices_caption,
                          .summary = devices_text(tables.rows, summary),
                          .configuration = devices_configuration(config, devices, tables, summary)};
  if (devices.front().is_software)
    result.summary += "no card is on this machine: its steps are the software's\n";
  for (const std::string& note : tables.notes) result.summary += note + "\n";
  result.tables = {{"devices", std::move(tables.rows)}, {"devices_summary", summary}, {"devices_time", time}};
  return result;
}

}  // namespace mss::studies::timing

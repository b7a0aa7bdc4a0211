#include "experiments/simulation/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <optional>
#include <ostream>

#include "core/error.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/vtk_series.hpp"
#include "experiments/simulation/wakeful_twin.hpp"
#include "integrators/linear/linear_solver.hpp"
#include "integrators/stable_step.hpp"

namespace mss {

namespace {

void check_safe(const IntegratorInfo& method) {
  if (method.stepping != Stepping::fixed) return;
  if (!method.limit)
    throw InputError(fmt::format(
        "dt = \"safe\" says nothing for {}, which is stable at any step; give dt in seconds", method.name));
  stable_step(method, {.omega = 1});  // throws if no step is safe
}

std::vector<ParticleRecord> record_particles(const Body& body, const auto& state) {
  std::vector<ParticleRecord> particles;
  particles.reserve(body.particle_count());
  for (const std::ptrdiff_t site : body.sites())
    particles.push_back({body.rest_position(site), state.x.at(site), state.v.at(site), body.mass(site)});
  return particles;
}

/// One simulation under way: advances from row to row, and stops at frames on the way.
template <class Real>
class Simulation {
 public:
  Simulation(const Scene& scene, const Body& body, const VtkChoice& vtk, SimulationResult& result)
      : scene_(scene), run_(scene, body), result_(result), frame_every_(vtk.every) {
    result.dt = run_.dt();
    result.threads = run_.system().threads();
    result.kernel = run_.system().kernel_name();
    if (scene.solve.sleep.bound > 0) twin_.emplace(scene, body);
    if (frame_every_ > 0) frames_.emplace(vtk.directory, body);
  }

  /// The state of the last finite row is what a failed run leaves.
  void rows(Progress& progress);

 private:
  void advance(double t_end);
  void advance_with_frames(double t_end);
  void add_frame() { frames_->add(run_.state().t, run_.state().x, run_.state().v); }
  bool frames_by_step() const {
    return frames_ && find_integrator(scene_.solve.integrator).stepping == Stepping::fixed;
  }

  const Scene& scene_;
  SceneRun<Real> run_;
  SimulationResult& result_;
  long frame_every_;  ///< n-th step, or row
  std::optional<VtkSeries> frames_;
  std::optional<WakefulTwin<Real>> twin_;
};

template <class Real>
void Simulation<Real>::advance(double t_end) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  result_.status = run_.advance(t_end, result_.work);
  result_.wall_seconds += std::chrono::duration<double>(Clock::now() - begin).count();
  result_.simulated_seconds = run_.state().t;
}

template <class Real>
void Simulation<Real>::advance_with_frames(double t_end) {
  if (!frames_by_step()) return advance(t_end);
  const double& t = run_.state().t;
  long left = std::lround((t_end - t) / result_.dt);
  while (left > 0 && result_.status == Status::ok) {
    const long due = frame_every_ - result_.work.steps % frame_every_;
    constexpr double beside = 0.25;  // so that t stays the sum of the steps, as it were without frames
    advance(due < left ? t + (double(due) + beside) * result_.dt : t_end);
    left -= due;
    if (left >= 0 && result_.status == Status::ok) add_frame();
  }
}

template <class Real>
void Simulation<Real>::rows(Progress& progress) {
  const State<Real>& state = run_.state();
  State<Real> last = state;
  result_.series.push_back(measure(run_.system(), state));
  if (frames_) add_frame();
  const auto rows = std::max(1L, std::lround(std::ceil(scene_.solve.duration / scene_.solve.every - 1e-9)));
  for (long i = 1; i <= rows && result_.status == Status::ok; ++i) {
    const double t_end = std::min(double(i) * scene_.solve.every, scene_.solve.duration);
    const Lap before{run_.system().all_asleep(), result_.work.steps, result_.wall_seconds};
    advance_with_frames(t_end);
    if (result_.status != Status::ok || state.t == last.t) continue;  // a row every step if `every` is less
    const Measures measures = measure(run_.system(), state);
    if (!is_finite(measures)) {  // energies overflow before coordinates do
      result_.status = Status::non_finite;
      continue;
    }
    result_.series.push_back(measures);
    if (twin_)
      twin_->follow(run_, t_end,
                    {before.asleep && run_.system().all_asleep(), result_.work.steps - before.steps,
                     result_.wall_seconds - before.seconds});
    if (frames_ && !frames_by_step() && i % frame_every_ == 0) add_frame();
    last = state;
    progress.report(double(i) / double(rows), fmt::format("t = {:.4g} s", state.t));
    if (i < rows && progress.stopped()) result_.status = Status::interrupted;
  }
  if (frames_) frames_->finish();
  if (twin_) result_.sleep = twin_->report();
  result_.particles = record_particles(run_.system().body(), last);
}

template <class Real>
void simulate_in(const Scene& scene, const VtkChoice& vtk, Progress& progress, SimulationResult& result) {
  const Body body(scene.body);
  Simulation<Real>(scene, body, vtk, result).rows(progress);
}

}  // namespace

bool is_finite(const Measures& measures) {
  return std::all_of(measure_columns.begin(), measure_columns.end(),
                     [&](const MeasureColumn& column) { return std::isfinite(column.value(measures)); });
}

template <class Real>
State<Real> stretched_state(const BodySystem<Real>& system, double factor) {
  State<Real> state = system.rest_state();
  for (const std::ptrdiff_t site : system.body().sites()) {
    const Vec3 x = state.x.at(site);
    state.x.set(site, {x[0], x[1], factor * x[2]});
  }
  return state;
}

namespace {

/// Says which table of which file an error is about.
void check_table(const Scene& scene, const char* table, const std::function<void()>& check) {
  try {
    check();
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}: {}", scene.file.string(), table, error.what()));
  }
}

}  // namespace

void check_model(const Scene& scene) {
  check_table(scene, "material",
              [&] { check_model(scene.model, scene.body, scene.solve.precision == Precision::single); });
}

/// Collisions at the end of steps need a method whose steps are its user's.
void check_contact(const Scene& scene, const IntegratorInfo& method) {
  const std::vector<Plane>& planes = scene.environment.planes;
  const auto discrete = std::find_if(planes.begin(), planes.end(),
                                     [](const Plane& plane) { return plane.contact != ContactLaw::penalty; });
  if (discrete == planes.end() || method.stepping == Stepping::fixed) return;
  throw InputError(
      fmt::format("contact = \"{}\" acts at the end of fixed steps, and {} does not take any; give contact = "
                  "\"penalty\", or another solve.integrator",
                  to_string(discrete->contact), method.name));
}

/// What sleeps has no acceleration, and other methods ask for forces.
void check_sleep(const Scene& scene, const IntegratorInfo& method) {
  if (scene.solve.sleep.bound == 0) return;
  if (scene.model != spring_model)
    throw InputError(fmt::format("sleep is for model \"{}\", and material.model is \"{}\"; leave it out",
                                 spring_model, scene.model));
  if (method.implicit || method.stepping != Stepping::fixed)
    throw InputError(fmt::format(
        "sleep is for explicit methods of fixed step, and {} is none; leave it out, or give another "
        "integrator",
        method.name));
}

void check_solve(const Scene& scene) {
  const bool single = scene.solve.precision == Precision::single;
  check_model(scene);
  check_table(scene, "solve", [&] {
    const IntegratorInfo& method = find_integrator(scene.solve.integrator);
    if (!scene.solve.dt) check_safe(method);
    if (single && !method.make_single)
      throw InputError(fmt::format(
          "integrator '{}' computes in double precision only; give precision = \"double\"", method.name));
    find_linear_solver(scene.solve.linear_solver);
    check_sleep(scene, method);
  });
  check_table(scene, "plane", [&] { check_contact(scene, find_integrator(scene.solve.integrator)); });
  if (scene.solve.dt && *scene.solve.dt > scene.solve.duration)
    throw InputError(
        fmt::format("{}: solve.dt = {} s is longer than solve.duration = {} s; give a shorter step",
                    scene.file.string(), *scene.solve.dt, scene.solve.duration));
}

SimulationResult simulate(const Scene& scene, Progress& progress, const VtkChoice& vtk) {
  check_solve(scene);
  SimulationResult result;
  if (scene.solve.precision == Precision::single)
    simulate_in<float>(scene, vtk, progress, result);
  else
    simulate_in<double>(scene, vtk, progress, result);
  return result;
}

Table series_table(const std::vector<Measures>& series) {
  std::vector<Column> columns;
  for (const MeasureColumn& column : measure_columns)
    columns.push_back({std::string(column.name), std::string(column.unit)});
  Table table(std::move(columns));
  for (const Measures& m : series) {
    std::vector<Cell> row;
    for (const MeasureColumn& column : measure_columns) row.emplace_back(column.value(m));
    table.add(std::move(row));
  }
  return table;
}

void write_particles(std::ostream& stream, const std::vector<ParticleRecord>& particles) {
  stream << "id,rest_x,rest_y,rest_z,x,y,z,vx,vy,vz,mass\n";
  for (std::size_t id = 0; id < particles.size(); ++id) {
    const auto& [rest, x, v, mass] = particles[id];
    stream << fmt::format("{},{},{},{},{},{},{},{},{},{},{}\n", id, rest[0], rest[1], rest[2], x[0], x[1],
                          x[2], v[0], v[1], v[2], mass);
  }
}

template State<float> stretched_state(const BodySystem<float>&, double);
template State<double> stretched_state(const BodySystem<double>&, double);

}  // namespace mss

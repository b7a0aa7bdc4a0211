#include "experiments/simulation.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <optional>
#include <ostream>

#include "core/error.hpp"
#include "experiments/model.hpp"
#include "experiments/vtk_series.hpp"
#include "integrators/linear/linear_solver.hpp"
#include "integrators/stable_step.hpp"

namespace mss {

namespace {

double step_of(const Scene& scene, const IntegratorInfo& method, const SpectralBound& bound) {
  if (method.stepping == Stepping::equilibrium) return 0;
  if (scene.solve.dt) return *scene.solve.dt;
  if (method.stepping == Stepping::adaptive) return 0;  // the method's own choice
  const double safe = safe_share * stable_step(method, bound);
  return scene.solve.duration > 0 ? std::min(safe, scene.solve.duration) : safe;
}

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
class Run {
 public:
  Run(const Scene& scene, BodySystem<Real>& system, const VtkChoice& vtk, SimulationResult& result)
      : scene_(scene),
        system_(system),
        method_info_(find_integrator(scene.solve.integrator)),
        state_(start_state(system, scene)),
        result_(result),
        frame_every_(vtk.every) {
    const IntegratorOptions options = method_options(scene, system);
    result.dt = options.dt;
    method_ = method_info_.make<Real>(options);
    if (frame_every_ > 0) frames_.emplace(vtk.directory, system.body());
  }

  /// The state of the last finite row is what a failed run leaves.
  void rows(Progress& progress);

 private:
  void advance(double t_end);
  void advance_with_frames(double t_end);
  void add_frame() { frames_->add(state_.t, state_.x, state_.v); }
  bool frames_by_step() const { return frames_ && method_info_.stepping == Stepping::fixed; }

  const Scene& scene_;
  BodySystem<Real>& system_;
  const IntegratorInfo& method_info_;
  std::unique_ptr<Integrator<Real>> method_;
  State<Real> state_;
  SimulationResult& result_;
  long frame_every_;  ///< n-th step, or row
  std::optional<VtkSeries> frames_;
};

template <class Real>
void Run<Real>::advance(double t_end) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  result_.status = method_->advance(system_, state_, t_end, result_.work);
  result_.wall_seconds += std::chrono::duration<double>(Clock::now() - begin).count();
  result_.simulated_seconds = state_.t;
}

template <class Real>
void Run<Real>::advance_with_frames(double t_end) {
  if (!frames_by_step()) return advance(t_end);
  long left = std::lround((t_end - state_.t) / result_.dt);
  while (left > 0 && result_.status == Status::ok) {
    const long due = frame_every_ - result_.work.steps % frame_every_;
    constexpr double beside = 0.25;  // so that t stays the sum of the steps, as it were without frames
    advance(due < left ? state_.t + (double(due) + beside) * result_.dt : t_end);
    left -= due;
    if (left >= 0 && result_.status == Status::ok) add_frame();
  }
}

template <class Real>
void Run<Real>::rows(Progress& progress) {
  State<Real> last = state_;
  result_.series.push_back(measure(system_, state_));
  if (frames_) add_frame();
  const auto rows = std::max(1L, std::lround(std::ceil(scene_.solve.duration / scene_.solve.every - 1e-9)));
  for (long i = 1; i <= rows && result_.status == Status::ok; ++i) {
    advance_with_frames(std::min(double(i) * scene_.solve.every, scene_.solve.duration));
    if (result_.status != Status::ok || state_.t == last.t) continue;  // a row every step if `every` is less
    const Measures measures = measure(system_, state_);
    if (!is_finite(measures)) {  // energies overflow before coordinates do
      result_.status = Status::non_finite;
      continue;
    }
    result_.series.push_back(measures);
    if (frames_ && !frames_by_step() && i % frame_every_ == 0) add_frame();
    last = state_;
    progress.report(double(i) / double(rows), fmt::format("t = {:.4g} s", state_.t));
    if (i < rows && progress.stopped()) result_.status = Status::interrupted;
  }
  if (frames_) frames_->finish();
  result_.particles = record_particles(system_.body(), last);
}

template <class Real>
void simulate_in(const Scene& scene, const VtkChoice& vtk, Progress& progress, SimulationResult& result) {
  const Body body(scene.body);
  const auto system = make_system<Real>(scene.model, body, scene.environment, scene.solve.threads);
  result.threads = system->threads();
  result.kernel = system->kernel_name();
  Run<Real>(scene, *system, vtk, result).rows(progress);
}

}  // namespace

bool is_finite(const Measures& measures) {
  return std::all_of(measure_columns.begin(), measure_columns.end(),
                     [&](const MeasureColumn& column) { return std::isfinite(column.value(measures)); });
}

template <class Real>
void scale_errors(IntegratorOptions& options, const BodySystem<Real>& system) {
  options.length_scale = system.body().config().cell_size;
  options.speed_scale = options.length_scale * system.spectral_bound().omega / 10;
}

template <class Real>
IntegratorOptions method_options(const Scene& scene, const BodySystem<Real>& system) {
  IntegratorOptions options{
      .dt = step_of(scene, find_integrator(scene.solve.integrator), system.spectral_bound()),
      .linear_solver = scene.solve.linear_solver,
      .tangent = scene.solve.tangent,
      .tolerance = scene.solve.tolerance};
  scale_errors(options, system);
  return options;
}

template <class Real>
State<Real> start_state(const BodySystem<Real>& system, const Scene& scene) {
  State<Real> state = system.rest_state();
  const Body& body = system.body();
  Vec3 centre = Vec3::Zero();
  for (const std::ptrdiff_t site : body.sites())
    centre += body.mass(site) / body.total_mass() * state.x.at(site);
  for (const std::ptrdiff_t site : body.sites())
    state.v.set(site, scene.start_velocity + scene.start_spin.cross(state.x.at(site) - centre));
  system.constrain(0, state.x, state.v);
  return state;
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

template void scale_errors(IntegratorOptions&, const BodySystem<float>&);
template void scale_errors(IntegratorOptions&, const BodySystem<double>&);
template IntegratorOptions method_options(const Scene&, const BodySystem<float>&);
template IntegratorOptions method_options(const Scene&, const BodySystem<double>&);
template State<float> start_state(const BodySystem<float>&, const Scene&);
template State<double> start_state(const BodySystem<double>&, const Scene&);
template State<float> stretched_state(const BodySystem<float>&, double);
template State<double> stretched_state(const BodySystem<double>&, double);

}  // namespace mss

// The single runs of `mss stability failures`: stress cases, and random scenes within the range of the safe
// step.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "core/springs/spring_system.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/studies/failures/failures.hpp"
#include "integrators/analysis/stable_step.hpp"

namespace mss::studies::failures {

namespace {

constexpr double young = 1e6, density = 1000;  // [Pa], [kg/m^3]
constexpr double n = failure_cells;

void fill(StressCase& c, double poisson, double face_share) {
  c.body.fill({.young = young, .poisson = poisson}, face_share);
}

void drop(StressCase& c, double height) {
  constexpr double gravity = 9.81, above = 1e-3;  // [m/s^2], [m]
  c.body.origin = above * Vec3::UnitZ();
  c.environment.planes = {
      {.point = Vec3::Zero(), .normal = Vec3::UnitZ(), .restitution = 0.3, .friction = 0.4}};
  c.velocity = -std::sqrt(2 * gravity * height) * Vec3::UnitZ();
}

/// Places the first particles along an edge where it begins: springs of no length.
void merge(StressCase& c, double particles) {
  c.place = [particles](const Vec3& rest) -> Vec3 {
    const bool on_edge = rest[1] < 0.5 && rest[2] < 0.5 && rest[0] < particles + 0.5;
    return on_edge ? Vec3(0, rest[1], rest[2]) : rest;
  };
}

void push_corner(StressCase& c, double cells) {
  c.place = [cells](const Vec3& rest) -> Vec3 {
    return (rest.array() > n - 0.5).all() ? Vec3(rest - cells * Vec3::Ones()) : rest;
  };
}

void stretch(StressCase& c, double factor) {
  c.place = [factor](const Vec3& rest) { return Vec3(n / 2 + factor * (rest[0] - n / 2), rest[1], rest[2]); };
}

/// Makes each particle of the half beyond the middle heavier than an inner particle by a factor.
void weight_half(StressCase& c, double times) {
  const Vec3 upper = Vec3::Ones(), lower(0.5, 0, 0);
  constexpr double particles = (n + 1) * (n + 1) * (n + 1) / 2, each = density / (n * n * n);
  c.body.weights = {{{lower, upper}, (times - 1) * particles * each}};
}

double speed_of_sound(const BodyConfig& body) { return std::sqrt(young / body.density); }

/// The step or interval that a method is given: see try_scene().
double step_for(const IntegratorInfo& method, BodySystem<double>& system) {
  constexpr double longer = 10;
  const SpectralBound bound = guarded_spectral_bound(system.body());
  const double usual = safe_share * guaranteed_step(find_integrator("semi_implicit_euler"), bound);
  if (!method.limit) return longer * usual;
  if (const double guaranteed = guaranteed_step(method, bound); guaranteed > 0)
    return safe_share * guaranteed;
  Work work;
  const double predicted = predicted_step(method, system, system.rest_state(), work).dt;
  return predicted > 0 ? safe_share * predicted : usual;
}

State<double> start(BodySystem<double>& system, const StressCase& c) {
  const BodyConfig& config = system.body().config();
  State<double> state = system.rest_state();
  const Vec3 middle = config.origin + config.cell_size * n / 2 * Vec3::Ones();
  for (const std::ptrdiff_t site : system.particles()) {
    const Vec3 rest = (state.x.at(site) - config.origin) / config.cell_size;
    if (c.place) state.x.set(site, config.origin + config.cell_size * c.place(rest));
    state.v.set(site, c.velocity + c.spin.cross(state.x.at(site) - middle));
  }
  return state;
}

/// Of planes that act by impulses, see FailureRun.
double touched(const BodySystem<double>& system) {
  const PlaneImpulses* impulses = system.plane_impulses();
  if (!impulses) return no_value;
  for (std::size_t plane = 0; plane < impulses->planes(); ++plane)
    for (const std::ptrdiff_t site : system.particles())
      if (!impulses->at(plane, site).isZero(0)) return 1;
  return 0;
}

/// Where a body is beside its planes; holds may put particles behind them.
void look_behind_planes(const BodySystem<double>& system, const State<double>& state, FailureRun& run) {
  for (const Plane& plane : system.environment().planes) {
    double height = 0;
    for (const std::ptrdiff_t site : system.particles()) {
      const double gap = plane.gap(state.x.at(site));
      const bool is_held =
          system.held().holds(site, 0) || system.held().holds(site, 1) || system.held().holds(site, 2);
      if (!is_held) run.depth = std::max(run.depth, -gap);
      height += system.mass(site) * gap / system.body().total_mass();
    }
    run.height = std::min(run.height, height);
  }
}

/// Runs for a time, every other step shorter by `step_ratio`.
FailureRun run(BodySystem<double>& system, const IntegratorInfo& method, State<double> state, double dt,
               double step_ratio, double seconds) {
  constexpr long most_samples = 200, most_steps = 500;
  const bool adaptive = method.stepping == Stepping::adaptive;
  IntegratorOptions whole{.dt = adaptive ? 0 : dt, .most_steps = most_steps};
  scale_errors(whole, system);
  IntegratorOptions part = whole;
  part.dt = whole.dt / step_ratio;
  const auto long_steps = method.make<double>(whole), short_steps = method.make<double>(part);
  const double pair = step_ratio == 1 ? dt : dt + dt / step_ratio;
  const long steps = std::max(32L, long(std::ceil(seconds / pair))),
             stride = std::max(1L, steps / most_samples);
  Work work;
  const auto one_pair = [&] {
    Status status = long_steps->advance(system, state, state.t + dt, work);
    if (status != Status::ok) return status;
    short_steps->reset();
    status = short_steps->advance(system, state, state.t + dt / step_ratio, work);
    long_steps->reset();
    return status;
  };
  FailureRun result{.dt = dt};
  SampledRun sampled(system, state, velocity_lag(method, dt / step_ratio));
  result.outcome = sampled.run(
      steps / stride,
      [&](long sample) {
        if (step_ratio == 1) return long_steps->advance(system, state, double(sample * stride) * dt, work);
        Status status = Status::ok;
        for (long i = 0; i < stride && status == Status::ok; ++i) status = one_pair();
        return status;
      },
      [&](const Measures&) { look_behind_planes(system, state, result); });
  result.extremes = sampled.extremes();
  result.seconds = state.t;
  result.steps = work.steps;
  result.touched = touched(system);
  if (result.outcome == Outcome::stable && result.extremes.final_jacobian <= 0)
    result.outcome = Outcome::folds;
  result.behind_plane =
      result.outcome == Outcome::stable &&
      (result.depth > behind_a_plane * system.body().config().cell_size || result.height < 0);
  return result;
}

}  // namespace

StressCase unloaded_cube() {
  StressCase c{.body = {.voxels = VoxelGrid::box(failure_cells, failure_cells, failure_cells),
                        .cell_size = 1.0 / failure_cells,
                        .density = density,
                        .damping = {.law = Damping::Law::ratio, .zeta = 0.1}}};
  fill(c, 0.3, 0.5);
  return c;
}

const std::vector<FailureScene>& failure_scenes() {
  static const std::vector<FailureScene> all{
      {"drop", "drop height [m]", {0.1, 1, 10, 100, 1000}, drop},
      {"spin",
       "spin [2 c / L]",
       {0.1, 0.3, 1, 3, 10},
       [](StressCase& c, double times) {
         c.spin = times * 2 * speed_of_sound(c.body) * Vec3(0.36, 0.48, 0.8);
       }},
      {"stretch", "stretched to [m]", {1.2, 1.5, 2, 3, 4}, stretch},
      {"compression", "compressed to [m]", {0.8, 0.5, 0.3, 0.1, 0.05}, stretch},
      {"merged", "merged particles", {1, 2, 3}, merge},
      {"inside_out", "corner pushed [cells]", {0.5, 1, 1.5, 2, 2.5}, push_corner},
      {"poisson",
       "nu, stretch 1.3",
       {0.45, 0.49, 0.499, 0.4999},
       [](StressCase& c, double poisson) {
         fill(c, poisson, 0.5);
         stretch(c, 1.3);
       }},
      {"negative_volume",
       "nu with k_vol < 0",
       {0.2, 0.1, 0, -0.2},
       [](StressCase& c, double poisson) {
         fill(c, poisson, 0.5);
         stretch(c, 0.7);
       }},
      {"weights",
       "mass ratio of halves",
       {1e2, 1e4, 1e6},
       [](StressCase& c, double times) {
         weight_half(c, times);
         stretch(c, 1.3);
       }},
      {"damping",
       "damping ratio",
       {0.05, 0.01, 0},
       [](StressCase& c, double ratio) {
         c.body.damping.zeta = ratio;
         stretch(c, 1.3);
       }},
      {"jump", "step ratio", {2, 10, 100}, [](StressCase& c, double factor) {
         c.step_ratio = factor;
         stretch(c, 1.3);
       }}};
  return all;
}

const std::vector<FailureStatus>& failure_statuses() {
  static const std::vector<FailureStatus> all = [] {
    const std::vector<std::string> labels = outcome_labels();
    std::vector<FailureStatus> statuses;
    for (int kind = 0; kind < int(labels.size()); ++kind)
      if (const auto outcome = Outcome(kind); outcome == Outcome::loses_energy)  // which is not looked for
        statuses.push_back({"behind_plane", "behind the plane"});
      else
        statuses.push_back({std::string(to_string(outcome)), labels[std::size_t(kind)]});
    return statuses;
  }();
  return all;
}

FailureRun try_scene(const StressCase& stress_case, const IntegratorInfo& method, Variant variant) {
  constexpr double periods = 20;
  const auto config = [&](bool guarded) {
    BodyConfig c = stress_case.body;
    c.fold_guard = guarded ? default_fold_guard : 0;
    return c;
  };
  const Body body(config(variant.guarded)), of_step(config(variant.guarded_step));
  SpringSystem<double> system(body, stress_case.environment, {.threads = 1}),
      system_of_step(of_step, stress_case.environment, {.threads = 1});
  const double slow = 2.0 / speed_of_sound(stress_case.body);  // there and back through 1 m [s]
  const double dt = step_for(method, system_of_step);
  const FailureRun result =
      run(system, method, start(system, stress_case), dt, stress_case.step_ratio, periods * slow);
  if (result.outcome == Outcome::stable && result.touched == 0)
    throw std::logic_error(fmt::format("{}: a body that was meant to touch a plane did not", method.name));
  return result;
}

RandomScene random_scene(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto share = [&] { return std::uniform_real_distribution<>(0, 1)(random); };
  const auto between = [&](double low, double high) { return low + (high - low) * share(); };
  const auto power = [&](double low, double high) { return low * std::pow(high / low, share()); };
  const auto whole = [&](int low, int high) { return std::min(high, low + int(share() * (high - low + 1))); };
  const int nx = whole(1, 5), ny = whole(1, 5), nz = whole(1, 5);
  RandomScene scene{.body = {.voxels = VoxelGrid::box(nx, ny, nz),
                             .cell_size = power(0.01, 1),
                             .density = power(1, 1e4),
                             .damping = {.law = Damping::Law::ratio, .zeta = power(0.01, 1)}},
                    .seed = seed};
  for (int i = 0; i < nx; ++i)
    for (int j = 0; j < ny; ++j)
      for (int k = 0; k < nz; ++k)
        if (i + j + k > 0 && share() < 0.2) scene.body.voxels.set(i, j, k, false);
  const double stiffness = power(1e3, 1e9), poisson = between(0, 0.45), face_share = between(0.25, 1);
  scene.body.fill({.young = stiffness, .poisson = poisson}, face_share);
  std::vector<std::string> limited;
  for (const IntegratorInfo& method : integrators())
    if (method.stepping == Stepping::fixed && method.limit && method.limit(1, 0) > 0)
      limited.push_back(method.name);  // not explicit Euler: no step of it is guaranteed
  scene.integrator = limited[std::size_t(whole(0, int(limited.size()) - 1))];
  const double h = scene.body.cell_size;
  if (share() < 0.3) scene.environment.holds = {{.box = {Vec3::Zero(), Vec3(0, 1e3 * h, 1e3 * h)}}};
  scene.stretch = {between(1 - safe_strain, 1 + safe_strain), between(1 - safe_strain, 1 + safe_strain),
                   between(1 - safe_strain, 1 + safe_strain)};
  if (share() < 0.5) {
    // Below the lowest particle, wherever the plane's slope has it.
    const double lean_x = between(-0.5, 0.5), lean_y = between(-0.5, 0.5);
    Plane plane{.normal = Vec3(lean_x, lean_y, 1).normalized(), .restitution = share(), .friction = share()};
    const Vec3 far = h * Vec3(nx, ny, nz).cwiseProduct(scene.stretch);
    plane.point = (plane.normal.cwiseMin(0).dot(far) - 0.01 * h) * plane.normal;
    scene.environment.planes = {plane};
  }
  scene.random_speed = share();
  return scene;
}

FailureRun try_scene(const RandomScene& scene) {
  constexpr long steps = 2000;
  const Body body(scene.body);
  SpringSystem<double> system(body, scene.environment, {.threads = 1});
  const IntegratorInfo& method = find_integrator(scene.integrator);
  const double dt = step_for(method, system);
  std::mt19937_64 random(scene.seed);
  std::uniform_real_distribution<> share(-1, 1);
  const double speed = scene.random_speed * safe_strain * scene.body.cell_size * system.body_bound().omega /
                       (2 * std::numbers::pi);
  State<double> state = system.rest_state();
  for (const std::ptrdiff_t site : system.particles()) {
    state.x.set(site, state.x.at(site).cwiseProduct(scene.stretch));
    const double a = share(random), b = share(random), c = share(random);
    state.v.set(site, speed * Vec3(a, b, c));
  }
  system.constrain(0, state.x, state.v);
  return run(system, method, std::move(state), dt, 1, double(steps) * dt);
}

}  // namespace mss::studies::failures

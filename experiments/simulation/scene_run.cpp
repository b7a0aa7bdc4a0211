#include "experiments/simulation/scene_run.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>

#include "core/base/error.hpp"
#include "integrators/analysis/error_scale.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "integrators/fixed_step.hpp"

namespace mss {

namespace {

/// No computer takes so many, and a long counts them.
constexpr double most_steps_of_a_run = 1e15;

double checked_step(const Scene& scene, double dt) {
  if (dt > 0 && scene.solve.duration / dt <= most_steps_of_a_run) return dt;
  throw InputError(fmt::format(
      "{}: solve.duration = {} s takes more than {:.0e} steps of {} s; give a longer step, or a softer or "
      "heavier material",
      scene.file.string(), scene.solve.duration, most_steps_of_a_run, dt));
}

double step_of(const Scene& scene, const IntegratorInfo& method, const SpectralBound& bound) {
  if (method.stepping == Stepping::equilibrium && !method.limit) return 0;
  if (scene.solve.dt) return checked_step(scene, *scene.solve.dt);
  if (method.stepping == Stepping::adaptive || method.stepping == Stepping::reduced)
    return 0;  // the method's own choice
  const double safe = checked_step(scene, safe_share * stable_step(method, bound));
  return scene.solve.duration > 0 ? std::min(safe, scene.solve.duration) : safe;
}

/// Adaptive methods compute with their tolerances.
void check_scales(const Scene& scene, const IntegratorOptions& options) {
  if (find_integrator(scene.solve.integrator).stepping != Stepping::adaptive) return;
  const double length = options.tolerance * options.length_scale,
               speed = options.tolerance * options.speed_scale;
  if (std::isnormal(length) && std::isnormal(speed)) return;
  throw InputError(
      fmt::format("{}: solve.tolerance = {} allows errors of {} m and {} m/s, which cannot be computed with; "
                  "give another one, or another material",
                  scene.file.string(), options.tolerance, length, speed));
}

template <class Real>
double kinetic_energy(const SolidSystem<Real>& system, const Field<Real>& v) {
  double sum = 0;
  system.ranks().add_in_order(sum, [&] {
    for (const std::ptrdiff_t site : system.particles())
      sum += system.mass(site) * v.at(site).squaredNorm() / 2;
  });
  return sum;
}

/// Throws InputError, with the scene's file, where the method cannot serve the system, or the device cannot
/// hold it.
template <class Real>
void check_method(const Scene& scene, Integrator<Real>& method, System<Real>& driven, State<Real> state) {
  try {
    Work none;
    if (method.device().empty())
      method.check(driven);
    else if (method.advance(driven, state, state.t, none) != Status::ok)
      throw InputError(fmt::format("{} has stopped working", method.device()));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", scene.file.string(), error.what()));
  }
}

}  // namespace

bool is_finite(const Measures& measures) {
  return std::all_of(measure_columns.begin(), measure_columns.end(),
                     [&](const MeasureColumn& column) { return std::isfinite(column.value(measures)); });
}

template <class Real>
IntegratorOptions method_options(const Scene& scene, const SolidSystem<Real>& system) {
  IntegratorOptions options{
      .dt = step_of(scene, find_integrator(scene.solve.integrator),
                    scene.solve.local_steps ? system.local_bound() : system.spectral_bound()),
      .linear_solver = scene.solve.linear_solver,
      .tangent = scene.solve.tangent,
      .spectral_radius = scene.solve.spectral_radius,
      .tolerance = scene.solve.tolerance,
      .nonlinear_solver = scene.solve.nonlinear_solver,
      .iterations = scene.solve.iterations,
      .chebyshev_radius = scene.solve.chebyshev_radius,
      .region_width = scene.solve.region_width,
      .alpha = scene.solve.alpha,
      .device = scene.solve.device};
  scale_errors(options, system);
  check_scales(scene, options);
  return options;
}

namespace {

/// Of one of several bodies.
template <class Real>
std::span<const std::ptrdiff_t> particles_of(const SolidSystem<Real>& system, std::size_t body) {
  const auto& [of_body, first] = system.levels()[body];
  const std::vector<std::ptrdiff_t>& sites = system.particles();
  const auto begin = std::lower_bound(sites.begin(), sites.end(), first);
  const auto end = std::lower_bound(begin, sites.end(), first + of_body.lattice().size);
  return {begin, end};
}

template <class Real>
void set_velocities(const SolidSystem<Real>& system, const SceneBody& body,
                    std::span<const std::ptrdiff_t> sites, State<Real>& state) {
  double mass = 0;
  system.ranks().add_in_order(mass, [&] {
    for (const std::ptrdiff_t site : sites) mass += system.mass(site);
  });
  Vec3 centre = Vec3::Zero();
  system.ranks().add_in_order(centre, [&] {
    for (const std::ptrdiff_t site : sites) centre += system.mass(site) / mass * state.x.at(site);
  });
  for (const std::ptrdiff_t site : sites)
    state.v.set(site, body.start_velocity + body.start_angular_velocity.cross(state.x.at(site) - centre));
}

}  // namespace

template <class Real>
State<Real> start_state(const SolidSystem<Real>& system, const Scene& scene) {
  State<Real> state = system.rest_state();
  const std::vector<const SceneBody*> bodies = bodies_of(scene);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const std::span<const std::ptrdiff_t> sites =
        bodies.size() == 1 ? std::span(system.particles()) : particles_of(system, b);
    set_velocities(system, *bodies[b], sites, state);
  }
  system.constrain(0, state.x, state.v);
  return state;
}

template <class Real>
SceneRun<Real>::SceneRun(const Scene& scene, const Body& body, long most_steps)
    : strikes_(scene.environment.strikes),
      refined_(refined_body_of(scene)),
      others_(other_bodies(scene)),
      system_(make_solid<Real>(scene, body, refined_.get(), others_)),
      options_(method_options(scene, *system_)),
      info_(&find_integrator(scene.solve.integrator)),
      gauge_(*system_, scene.environment) {
  options_.most_steps = most_steps;
  if (scene.solve.local_steps) in_local_steps_ = system_->with_local_steps(options_.dt);
  method_ = info_->template make<Real>(options_);
  check_method(scene, *method_, *system_, start_state(*system_, scene));
  transfers_before_ = method_->transfer_seconds();
  std::stable_sort(strikes_.begin(), strikes_.end(),
                   [](const Strike& a, const Strike& b) { return a.at < b.at; });
  go_on_from(start_state(*system_, scene));
}

/// What the guard makes of local steps is not known.
template <class Real>
SureSteps SceneRun<Real>::sure_steps() const {
  if (info_->stepping != Stepping::fixed) return {};
  SureSteps sure{.free = guaranteed_step(*info_, bound())};
  const std::vector<Level>& levels = system_->levels();
  if (!in_local_steps_) sure.guarded = guaranteed_step(*info_, with_guard(bound(), levels));
  return sure;
}

template <class Real>
void SceneRun<Real>::go_on_from(const State<Real>& state) {
  for (next_ = 0; next_ < strikes_.size() && strikes_[next_].at < state.t;) ++next_;
  way_.reset();
  state_ = state;
  begin_means();
  disturb();
}

template <class Real>
void SceneRun<Real>::use(std::unique_ptr<Integrator<Real>> method) {
  fetch();
  left_ = nullptr;
  method_ = std::move(method);
  disturb();
}

template <class Real>
void SceneRun<Real>::leave_on_device() {
  if (strikes_.empty()) left_ = dynamic_cast<StateOnDevice<Real>*>(method_.get());
  if (left_) left_->leave_there();
}

template <class Real>
Status SceneRun<Real>::fetch() {
  if (left_ && of_device_ == Status::ok) of_device_ = left_->fetch(state_);
  return of_device_;
}

template <class Real>
void SceneRun<Real>::disturb() {
  method_->reset();
  system_->wake_all();
}

/// A time that so many steps reach, and that rounding keeps from being reached by one more or less. The last
/// of an advance end at its end, where t is rid of what rounding added up, or half a step beside it.
template <class Real>
double SceneRun<Real>::end_of_steps(long steps, bool last, double t_end) const {
  constexpr double beside = 0.25, near = 0.4;  // of a step
  const double sum = state_.t + double(steps) * options_.dt;
  return last && std::abs(t_end - sum) < near * options_.dt ? t_end : sum + beside * options_.dt;
}

template <class Real>
long SceneRun<Real>::steps_to(double t_end) const {
  return std::lround((t_end - state_.t) / options_.dt);
}

template <class Real>
Status SceneRun<Real>::advance_between_strikes(System<Real>& driven, double t_end, Work& work, Stops* stops) {
  const bool stopping = stops != nullptr && info_->stepping == Stepping::fixed;
  if (!stopping) {
    way_.reset();
    return method_->advance(driven, state_, t_end, work);
  }
  double goal = journey_ ? std::max(t_end, journey_->goal) : t_end;
  if (goal > t_end && next_ < strikes_.size()) goal = std::clamp(strikes_[next_].at, t_end, goal);
  const Way way = way_ && way_->goal == goal ? *way_ : Way{goal, steps_to(goal)};
  way_.reset();
  return take_steps(driven, goal > t_end ? std::min(way.left, steps_to(t_end)) : way.left, way, t_end, work,
                    *stops);
}

/// Of the way all if it ends at t_end; else its first ones.
template <class Real>
Status SceneRun<Real>::take_steps(System<Real>& driven, long steps, Way way, double t_end, Work& work,
                                  Stops& stops) {
  const bool whole = way.goal == t_end;
  long to_last_group = whole ? -1 : std::max(0L, steps - steps % journey_->group);
  while (steps > 0 || to_last_group == 0) {
    if (to_last_group == 0) {
      way_ = way;
      journey_->at_last_group();
      to_last_group = -1;
      continue;
    }
    long now = std::min(steps, stops.steps());
    if (to_last_group > 0) to_last_group -= now = std::min(now, to_last_group);
    steps -= now;
    way.left -= now;
    way_.reset();
    const Status status =
        method_->advance(driven, state_, end_of_steps(now, whole && steps == 0, t_end), work);
    if (status != Status::ok) return status;
    const bool goes_on = stops.reached(steps == 0);
    if (of_device_ != Status::ok) return of_device_;
    if (goes_on || steps == 0) continue;
    way_ = way;
    return Status::interrupted;
  }
  way_.reset();
  snap_to_end_time(state_.t, options_.dt, t_end);
  return Status::ok;
}

template <class Real>
Status SceneRun<Real>::advance(System<Real>& driven, double t_end, Work& work, Stops* stops) {
  for (; next_ < strikes_.size() && strikes_[next_].at <= t_end; ++next_) {
    const Strike& strike = strikes_[next_];
    const bool is_ahead = strike.at > state_.t || (way_ && way_->goal == strike.at);
    const Status status = is_ahead ? advance_between_strikes(driven, strike.at, work, stops) : Status::ok;
    if (status != Status::ok) return status;
    const double before = kinetic_energy(*system_, state_.v);
    system_->give(strike, state_.v);
    system_->constrain(state_.t, state_.x, state_.v);
    struck_ += kinetic_energy(*system_, state_.v) - before;
    method_->reset();
    system_->wake_moving(state_);
  }
  return advance_between_strikes(driven, t_end, work, stops);
}

template <class Real>
Status SceneRun<Real>::advance_towards(const Journey& journey, double t_end, Work& work, Stops& stops) {
  journey_ = &journey;
  const Status status = advance(t_end, work, &stops);
  journey_ = nullptr;
  return status;
}

template <class Real>
void SceneRun<Real>::remember(Record& record) {
  if (!record.reads()) fetch();
  std::uint64_t next = next_;
  record.keep(next, struck_, way_, state_.t);
  next_ = std::size_t(next);
  for (Field<Real>* field : {&state_.x, &state_.v}) record.keep_field(*field, system_->size());
  record.keep(*system_, gauge_);
  method_->remember(driven(), record);
}

template <class Real>
std::optional<Measures> SceneRun<Real>::measure() const {
  const Measures measures = mss::measure(*system_, state_);
  return is_finite(measures) ? std::optional(measures) : std::nullopt;
}

template IntegratorOptions method_options(const Scene&, const SolidSystem<float>&);
template IntegratorOptions method_options(const Scene&, const SolidSystem<double>&);
template State<float> start_state(const SolidSystem<float>&, const Scene&);
template State<double> start_state(const SolidSystem<double>&, const Scene&);
template class SceneRun<float>;
template class SceneRun<double>;

}  // namespace mss

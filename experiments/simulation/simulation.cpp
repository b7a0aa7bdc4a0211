#include "experiments/simulation/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/error.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/simulation/non_sleeping_reference.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/vtk_series.hpp"
#include "integrators/fixed_step.hpp"

namespace mss {

namespace {

template <class Real>
std::vector<ParticleRecord> record_particles(const SolidSystem<Real>& system, const State<Real>& state) {
  std::vector<ParticleRecord> particles;
  particles.reserve(system.particles().size());
  for (const std::ptrdiff_t site : system.particles())
    particles.push_back({system.rest_position(site), state.x.at(site), state.v.at(site), system.mass(site)});
  return particles;
}

template <class Real>
std::vector<LevelCount> count_levels(const SolidSystem<Real>& system) {
  std::vector<LevelCount> counts;
  for (const auto& [body, first] : system.levels()) {
    const std::vector<std::ptrdiff_t>& sites = system.particles();
    const auto begin = std::lower_bound(sites.begin(), sites.end(), first);
    const auto end = std::lower_bound(begin, sites.end(), first + body.lattice().size);
    counts.push_back({body.config().cell_size, body.cell_count(), std::size_t(end - begin)});
  }
  return counts;
}

/// Of methods that keep contact inside their steps, in steps that do not resolve the body's fastest motion.
template <class Real>
std::optional<double> rebounding_step(const Scene& scene, const SolidSystem<Real>& system, double dt) {
  const IntegratorInfo& method = find_integrator(scene.solve.integrator);
  const bool inside = method.stepping == Stepping::fixed && method.collisions == Collisions::inside_steps;
  if (!inside || !system.bounds() || system.bounds()->bounces(dt)) return std::nullopt;
  return 1 / system.spectral_bound().omega;
}

/// One simulation: advances from row to row, and stops at frames, or when it is told to, on the way.
template <class Real>
class Simulation final : public Stops {
 public:
  Simulation(const Scene& scene, const Body& body, const VtkChoice& vtk, const SharedRun& shared,
             Progress& progress, SimulationResult& result)
      : scene_(scene),
        run_(scene, body),
        shared_(shared),
        progress_(progress),
        result_(result),
        frame_every_(vtk.every),
        energy_(scene),
        planes_(scene, run_.system()) {
    if (run_.dt() > 0) result.dt = run_.dt();
    result.sure_steps = run_.sure_steps();
    result.rebounding_step = rebounding_step(scene, run_.system(), run_.dt());
    result.in_local_steps = run_.in_local_steps();
    const IntegratorInfo& method = find_integrator(scene.solve.integrator);
    if (!method.implicit || method.springs_only) stretch_ = steps_between_checks;
    result.threads = run_.system().threads();
    result.kernel = run_.system().kernel_name();
    result.levels = count_levels(run_.system());
    if (scene.solve.sleep.bound > 0) reference_.emplace(scene, body);
    if constexpr (std::is_same_v<Real, double>)
      if (StepBalance::applies_to(scene) && !shared.ranks.are_several())
        balance_.emplace(scene, run_.system(), run_.dt());
    if (frame_every_ == 0) return;
    frames_.emplace(vtk.directory, run_.system().levels(),
                    scene.mesh ? std::optional(scene.mesh->surface()) : std::nullopt);
    of_frames_.emplace(run_.system(), scene.environment);
  }

  /// The state of the last finite row is what a failed run leaves.
  void rows();

 private:
  long steps() override;
  bool reached(bool at_end) override;
  /// False if a force is not finite.
  bool add_row(const Measures& measures) {
    const SeriesRow row{measures, run_.reactions(run_.driven())};
    if (!row.reactions.is_finite()) return false;
    run_.begin_means();
    result_.series.push_back(row);
    shared_.on_row(row);
    planes_.add(run_.state());
    energy_.add(run_, measures, planes_.lifts());
    return true;
  }
  void advance(double t_end);
  long steps_before_last();
  void balance_last_step();
  void report() const {
    const double t = run_.state().t;
    progress_.report(std::min(1.0, t / scene_.solve.duration), fmt::format("t = {:.4g} s", t));
  }
  void add_frame() {
    run_.system().update_ghosts(run_.state());
    const State<Real>& state = run_.state();
    frames_->add(state.t, state.x, state.v, cell_stress(run_.system(), state),
                 of_frames_->read(run_.driven(), state));
    of_frames_->begin(state.t);
  }
  bool in_fixed_steps() const { return find_integrator(scene_.solve.integrator).stepping == Stepping::fixed; }

  const Scene& scene_;
  SceneRun<Real> run_;
  const SharedRun& shared_;
  Progress& progress_;
  SimulationResult& result_;
  long frame_every_;  ///< n-th step, or row
  long stretch_ = 1;  ///< steps between two questions whether to stop
  Stopwatch stretch_begun_;
  long steps_begun_ = 0;
  double seconds_stopped_ = 0;  ///< in this advance
  double row_end_ = 0;          ///< of the row that is computed [s]
  EnergyWatch<Real> energy_;
  PlaneWatch<Real> planes_;
  std::optional<StepBalance> balance_;  ///< where it applies
  bool balances_ = false;               ///< the last step of the row that is computed
  State<Real> before_last_;             ///< where it begins
  double struck_before_ = 0;            ///< [J]
  std::optional<VtkSeries> frames_;
  std::optional<ReactionGauge<Real>> of_frames_;
  std::optional<NonSleepingReference<Real>> reference_;
};

/// Writing frames and asking whether to stop is no stepping.
template <class Real>
void Simulation<Real>::advance(double t_end) {
  seconds_stopped_ = 0;
  row_end_ = t_end;
  const double seconds = seconds_of(
      [&] { result_.status = run_.advance(t_end, result_.work, in_fixed_steps() ? this : nullptr); });
  result_.wall_seconds += seconds - seconds_stopped_;
  result_.simulated_seconds = run_.state().t;
}

/// Whether to stop is asked after stretches of steps, twice as many each time until they take a tenth of a
/// second. All ranks take the same, in multiples of what methods take at once.
template <class Real>
long Simulation<Real>::steps() {
  stretch_begun_ = Stopwatch();
  steps_begun_ = result_.work.steps;
  long steps = frames_ ? std::min(stretch_, frame_every_ - steps_begun_ % frame_every_) : stretch_;
  if (balances_) steps = std::min(steps, steps_before_last());
  return steps;
}

/// Steps after which the last one of a row begins. Where that is now, remembers it.
template <class Real>
long Simulation<Real>::steps_before_last() {
  const long left = std::lround((row_end_ - run_.state().t) / run_.dt());
  if (left > 1) return left - 1;
  before_last_ = run_.state();
  struck_before_ = run_.struck();
  return 1;
}

/// Not of a step that a strike ended.
template <class Real>
void Simulation<Real>::balance_last_step() {
  const State<Real>& state = run_.state();
  const bool is_there = std::abs(state.t - before_last_.t - run_.dt()) < run_.dt() / 2;
  if (!balances_ || !is_there || run_.struck() != struck_before_) return;
  if constexpr (std::is_same_v<Real, double>) balance_->add(before_last_, state);
}

template <class Real>
bool Simulation<Real>::reached(bool at_end) {
  constexpr double quick = 0.1;  // [s]
  const bool took_little = stretch_begun_.seconds() < quick;
  bool go_on = true;
  seconds_stopped_ += seconds_of([&] {
    if (frames_ && result_.work.steps % frame_every_ == 0) add_frame();
    if (at_end) return;
    if (result_.work.steps - steps_begun_ == stretch_ && shared_.ranks.all(took_little)) stretch_ *= 2;
    report();
    go_on = shared_.ranks.all(!progress_.stopped());
  });
  return go_on;
}

template <class Real>
void Simulation<Real>::rows() {
  const State<Real>& state = run_.state();
  State<Real> last = state;
  if (!add_row(measure(run_.system(), state)))
    throw InputError(
        fmt::format("{}: a hold or a plane exerts a force that is not finite at the start; give a slower "
                    "motion, or a lighter or softer material",
                    scene_.file.string()));
  if (frames_) add_frame();
  const auto rows = std::max(1L, std::lround(std::ceil(scene_.solve.duration / scene_.solve.every - 1e-9)));
  constexpr long most_balanced = 16;
  const long between_balanced = std::max(1L, rows / most_balanced);
  for (long i = 1; i <= rows && result_.status == Status::ok; ++i) {
    const double t_end = std::min(double(i) * scene_.solve.every, scene_.solve.duration);
    balances_ = balance_ && (rows - i) % between_balanced == 0;
    const Interval before{run_.system().all_asleep(), result_.work.steps, result_.wall_seconds};
    advance(t_end);
    const bool stopped = result_.status == Status::interrupted;
    if (result_.status != Status::ok && !stopped) continue;
    if (state.t == last.t) continue;  // a row every step if `every` is less
    const std::optional<Measures> measures = run_.measure();
    if (!measures || !add_row(*measures)) {
      result_.status = Status::non_finite;
      continue;
    }
    last = state;
    if (stopped) continue;
    balance_last_step();
    if (reference_)
      reference_->advance_and_compare(
          run_, t_end,
          {before.asleep && run_.system().all_asleep(), result_.work.steps - before.steps,
           result_.wall_seconds - before.seconds});
    if (frames_ && !in_fixed_steps() && i % frame_every_ == 0) add_frame();
    report();
    if (i < rows && !shared_.ranks.all(!progress_.stopped())) result_.status = Status::interrupted;
  }
  if (frames_) frames_->finish();
  if (reference_ && result_.series.size() > 1) result_.sleep = reference_->report();
  result_.gain = energy_.gain();
  result_.penetrations = planes_.found();
  if (balance_) result_.imbalance = balance_->imbalance();
  result_.threads_working = run_.driven().threads_working();
  result_.particles = record_particles(run_.system(), last);
}

template <class Real>
void simulate_in(const Scene& scene, const VtkChoice& vtk, const SharedRun& shared, Progress& progress,
                 SimulationResult& result) {
  const Body body(scene.body, shared.ranks);
  Simulation<Real>(scene, body, vtk, shared, progress, result).rows();
}

}  // namespace

template <class Real>
State<Real> stretched_state(const BodySystem<Real>& system, double factor) {
  State<Real> state = system.rest_state();
  for (const std::ptrdiff_t site : system.body().sites()) {
    const Vec3 x = state.x.at(site);
    state.x.set(site, {x[0], x[1], factor * x[2]});
  }
  return state;
}

SimulationResult simulate(const Scene& scene, Progress& progress, const VtkChoice& vtk,
                          const SharedRun& shared) {
  check_solve(scene);
  SimulationResult result;
  if (scene.solve.precision == Precision::single)
    simulate_in<float>(scene, vtk, shared, progress, result);
  else
    simulate_in<double>(scene, vtk, shared, progress, result);
  return result;
}

template State<float> stretched_state(const BodySystem<float>&, double);
template State<double> stretched_state(const BodySystem<double>&, double);

}  // namespace mss

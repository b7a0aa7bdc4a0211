#include "experiments/simulation/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/error.hpp"
#include "core/scene/scene_writer.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/provenance.hpp"
#include "experiments/simulation/digest.hpp"
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

/// Meshes that bodies were given as.
std::vector<VtkSurface> surfaces_of(const Scene& scene) {
  std::vector<VtkSurface> surfaces;
  const std::vector<const SceneBody*> bodies = bodies_of(scene);
  for (std::size_t b = 0; b < bodies.size(); ++b)
    if (bodies[b]->mesh) surfaces.push_back({bodies[b]->mesh->surface(), b});
  return surfaces;
}

/// One simulation: advances from row to row, and stops at frames, or when it is told to, on the way.
template <class Real>
class Simulation final : public Stops {
 public:
  Simulation(const Scene& scene, const Body& body, const VtkChoice& vtk, const SharedRun& shared,
             const RestartChoice& restart, Progress& progress, SimulationResult& result)
      : scene_(scene),
        run_(scene, body),
        shared_(shared),
        restart_(restart),
        progress_(progress),
        result_(result),
        frame_every_(vtk.every),
        energy_(scene),
        planes_(scene, run_.system()),
        reduced_(run_) {
    if (run_.dt() > 0) result.dt = run_.dt();
    result.sure_steps = run_.sure_steps();
    result.rebounding_step = rebounding_step(scene, run_.system(), run_.dt());
    result.in_local_steps = run_.in_local_steps();
    const IntegratorInfo& method = find_integrator(scene.solve.integrator);
    if (!method.implicit || method.springs_only) stretch_ = group_ = steps_between_checks;
    result.threads = run_.system().threads();
    result.kernel = run_.system().kernel_name();
    result.device = run_.device();
    run_.leave_on_device();
    result.levels = count_levels(run_.system());
    if (scene.solve.sleep.bound > 0) reference_.emplace(scene, body);
    if constexpr (std::is_same_v<Real, double>)
      if (StepBalance::applies_to(scene) && !shared.ranks.are_several())
        balance_.emplace(scene, run_.system(), run_.dt());
    if (frame_every_ == 0) return;
    frames_.emplace(vtk.directory, run_.system().levels(), surfaces_of(scene), !scene.others.empty());
    of_frames_.emplace(run_.system(), scene.environment);
  }

  /// The state of the last finite row is what a failed run leaves.
  void rows();

 private:
  long steps() override;
  bool reached(bool at_end) override;
  /// False if a force is not finite.
  bool add_row(const Measures& measures) {
    const SeriesRow row{measures, run_.reactions(run_.driven()), measure_bodies(run_.system(), run_.state())};
    if (!row.reactions.is_finite() || !row.bodies.is_finite()) return false;
    run_.begin_means();
    result_.series.push_back(row);
    shared_.on_row(row);
    planes_.add(run_.state());
    energy_.add(run_, measures, planes_.lifts());
    reduced_.add(measures, row.reactions);
    return true;
  }
  void begin();
  void go_on();
  void compute_row(long rows);
  void end_row(double t_end, long rows);
  void remember(Record& record);
  void keep(Status status);
  void keep_here();
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
  /// What the bits of results depend on, beside the build.
  const std::string& computed_by() const { return result_.device.empty() ? result_.kernel : result_.device; }
  bool in_fixed_steps() const { return find_integrator(scene_.solve.integrator).stepping == Stepping::fixed; }

  const Scene& scene_;
  SceneRun<Real> run_;
  const SharedRun& shared_;
  const RestartChoice& restart_;
  Stopwatch since_kept_;
  bool is_kept_ = false;  ///< where the run has ended
  Progress& progress_;
  SimulationResult& result_;
  long frame_every_;  ///< n-th step, or row
  long stretch_ = 1;  ///< steps between two questions whether to stop
  long group_ = 1;    ///< steps that the method takes at once
  Stopwatch stretch_begun_;
  long steps_begun_ = 0;
  double seconds_stopped_ = 0;  ///< in this advance
  long row_ = 1;                ///< that is computed, or the next; that at the start is 0
  bool is_in_row_ = false;      ///< the advance to it has begun
  Interval row_begun_;          ///< what there was then
  State<Real> last_;            ///< of the last row
  double row_end_ = 0;          ///< of the row that is computed [s]
  EnergyWatch<Real> energy_;
  PlaneWatch<Real> planes_;
  ReducedWatch<Real> reduced_;
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
  const double scheduled = double(row_) * scene_.solve.every, seconds_before = result_.wall_seconds;
  const double transfers_before = run_.transfer_seconds();
  const Stopwatch begun;
  const auto count_seconds = [&] {
    result_.transfer_seconds = run_.transfer_seconds();
    result_.wall_seconds =
        seconds_before + begun.seconds() - seconds_stopped_ - (result_.transfer_seconds - transfers_before);
  };
  const typename SceneRun<Real>::Journey journey{.goal = scheduled, .group = group_, .at_last_group = [&] {
                                                   count_seconds();
                                                   seconds_stopped_ += seconds_of([&] { keep_here(); });
                                                 }};
  result_.status = in_fixed_steps() && t_end < scheduled
                       ? run_.advance_towards(journey, t_end, result_.work, *this)
                       : run_.advance(t_end, result_.work, in_fixed_steps() ? this : nullptr);
  if (const Status fetched = run_.fetch(); fetched != Status::ok) result_.status = fetched;
  count_seconds();
  result_.simulated_seconds = run_.state().t;
}

template <class Real>
void Simulation<Real>::keep_here() {
  keep(Status::interrupted);
  is_kept_ = true;
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
  run_.fetch();
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
  const bool at_frame = frames_ && result_.work.steps % frame_every_ == 0;
  bool go_on = true;
  if (at_frame && run_.fetch() != Status::ok) return false;
  seconds_stopped_ += seconds_of([&] {
    if (at_frame) add_frame();
    if (at_end) return;
    if (result_.work.steps - steps_begun_ == stretch_ && shared_.ranks.all(took_little)) stretch_ *= 2;
    report();
    go_on = shared_.ranks.all(!progress_.stopped());
  });
  return go_on;
}

template <class Real>
void Simulation<Real>::begin() {
  const State<Real>& state = run_.state();
  last_ = state;
  if (!add_row(measure(run_.system(), state)))
    throw InputError(
        fmt::format("{}: a hold or a plane exerts a force that is not finite at the start; give a slower "
                    "motion, or a lighter or softer material",
                    scene_.file.string()));
  if (frames_) add_frame();
}

template <class Real>
void Simulation<Real>::remember(Record& record) {
  record.begin("rows");
  record.keep(result_.continued, result_.series, result_.work, result_.simulated_seconds,
              result_.wall_seconds, row_, is_in_row_, row_begun_);
  if (is_in_row_) {
    record.keep(last_.t);
    for (Field<Real>* field : {&last_.x, &last_.v}) record.keep_field(*field, run_.system().size());
  }
  record.begin("run");
  record.keep(run_);
  record.begin("watches");
  record.keep(energy_, planes_, reduced_);
  if (balance_) record.keep(*balance_);
  if (reference_) record.keep(*reference_);
}

/// Throws InputError where it would not be the same simulation.
template <class Real>
void Simulation<Real>::go_on() {
  Restart& from = *restart_.from;
  const auto refuse = [&](const std::string& why) {
    throw InputError(fmt::format("{}: {}", scene_.file.string(), why));
  };
  if (from.body != digest_of(run_.system().levels(), scene_))
    refuse(
        "its cells are not those of the run to go on from; give it the files that it had, or run it from "
        "its beginning");
  if (from.spring_law != spring_law_name())
    refuse(fmt::format(
        "this program's springs obey the law '{}', and those of the run to go on from '{}'; go on "
        "with a program built for that",
        spring_law_name(), from.spring_law));
  if (from.dt != run_.dt())
    refuse(
        fmt::format("its step is {} s, and that of the run to go on from was {} s; give solve.dt, and run "
                    "it from its beginning",
                    run_.dt(), from.dt));
  Record record(std::move(from.record));
  try {
    remember(record);
    if (!record.at_end()) throw InputError("more");
  } catch (const std::exception&) {
    refuse(
        fmt::format("the run to go on from is of mss {}, which kept other things; go on with that one, or "
                    "run it from its beginning",
                    from.version));
  }
  if (!is_in_row_) last_ = run_.state();
  const bool is_same_program = from.kernel == computed_by() && from.build == build_description();
  result_.continued.push_back(
      {run_.state().t, is_same_program && find_integrator(scene_.solve.integrator).exact_restart});
}

/// What goes on from there does what this run would have done; from a failed one nothing does.
template <class Real>
void Simulation<Real>::keep(Status status) {
  if (!restart_.keep) return;
  Record record;
  if (const Status fetched = run_.fetch(); fetched != Status::ok) status = fetched;
  const bool goes_on = status == Status::ok || status == Status::interrupted;
  if (goes_on) remember(record);
  restart_.keep({.status = status,
                 .t = run_.state().t,
                 .dt = run_.dt(),
                 .kernel = computed_by(),
                 .version = program_version(),
                 .build = build_description(),
                 .spring_law = spring_law_name(),
                 .body = digest_of(run_.system().levels(), scene_),
                 .configuration = to_json(scene_),
                 .record = record.take_bytes()});
  since_kept_ = Stopwatch();
}

/// Advances to the end of a row. Where the run ends before that, what goes on begins a few steps earlier;
/// methods that choose their steps, or look for an equilibrium, begin the row again.
template <class Real>
void Simulation<Real>::compute_row(long rows) {
  const double scheduled = double(row_) * scene_.solve.every,
               t_end = std::min(scheduled, scene_.solve.duration);
  constexpr long most_balanced = 16;
  balances_ = balance_ && (rows - row_) % std::max(1L, rows / most_balanced) == 0;
  if (!is_in_row_) row_begun_ = {run_.system().all_asleep(), result_.work.steps, result_.wall_seconds};
  if (t_end < scheduled && !in_fixed_steps()) keep_here();
  is_in_row_ = true;
  advance(t_end);
  const bool stopped = result_.status == Status::interrupted;
  if (result_.status != Status::ok && !stopped) return;
  if (stopped) keep_here();
  end_row(t_end, rows);
}

template <class Real>
void Simulation<Real>::end_row(double t_end, long rows) {
  const State<Real>& state = run_.state();
  is_in_row_ = false;
  if (state.t == last_.t) return;  // a row every step if `every` is less
  const std::optional<Measures> measures = run_.measure();
  if (!measures || !add_row(*measures)) {
    result_.status = Status::non_finite;
    return;
  }
  last_ = state;
  if (result_.status == Status::interrupted) return;
  balance_last_step();
  if (reference_)
    reference_->advance_and_compare(
        run_, t_end,
        {row_begun_.asleep && run_.system().all_asleep(), result_.work.steps - row_begun_.steps,
         result_.wall_seconds - row_begun_.seconds});
  if (frames_ && !in_fixed_steps() && row_ % frame_every_ == 0) add_frame();
  report();
  if (row_ < rows && !shared_.ranks.all(!progress_.stopped())) result_.status = Status::interrupted;
}

template <class Real>
void Simulation<Real>::rows() {
  if (restart_.from)
    go_on();
  else
    begin();
  const auto rows = std::max(1L, std::lround(std::ceil(scene_.solve.duration / scene_.solve.every - 1e-9)));
  while (row_ <= rows && result_.status == Status::ok) {
    compute_row(rows);
    ++row_;
    if (row_ <= rows && result_.status == Status::ok && since_kept_.seconds() > restart_.seconds_between)
      keep(Status::interrupted);
  }
  const bool failed = result_.status != Status::ok && result_.status != Status::interrupted;
  if (!is_kept_ || failed) keep(result_.status);
  if (frames_) frames_->finish();
  if (reference_ && result_.series.size() > 1) result_.sleep = reference_->report();
  result_.gain = energy_.gain();
  result_.penetrations = planes_.found();
  result_.reduced = reduced_.found();
  result_.contact = result_.series.back().bodies.contact;
  if (balance_) result_.imbalance = balance_->imbalance();
  result_.threads_working = run_.driven().threads_working();
  result_.particles = record_particles(run_.system(), last_);
}

template <class Real>
void simulate_in(const Scene& scene, const VtkChoice& vtk, const SharedRun& shared,
                 const RestartChoice& restart, Progress& progress, SimulationResult& result) {
  const Body body(scene.body, shared.ranks);
  Simulation<Real>(scene, body, vtk, shared, restart, progress, result).rows();
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
                          const SharedRun& shared, const RestartChoice& restart) {
  check_solve(scene);
  SimulationResult result;
  if (scene.solve.precision == Precision::single)
    simulate_in<float>(scene, vtk, shared, restart, progress, result);
  else
    simulate_in<double>(scene, vtk, shared, restart, progress, result);
  return result;
}

template State<float> stretched_state(const BodySystem<float>&, double);
template State<double> stretched_state(const BodySystem<double>&, double);

}  // namespace mss

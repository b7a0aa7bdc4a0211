// The runs of `mss regimes`: one scene, every method that might be cheapest, as motion and at rest.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/system/system_wrapper.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/simulation/bench_scenes.hpp"
#include "experiments/simulation/explicit_steps.hpp"
#include "experiments/simulation/outcome.hpp"
#include "experiments/studies/regimes/regimes.hpp"

namespace mss::studies::regimes {

namespace {

/// Ways to find the equilibrium, and their tolerances.
struct RestFamily {
  const char* method;
  std::vector<double> tolerances;
};
const std::vector<RestFamily>& rest_families() {
  static const std::vector<RestFamily> all{{"static/lbfgs", {1e-2, 1e-3, 1e-4}},
                                           {"static/projective", {1e-2, 1e-3, 1e-4}},
                                           {"dynamic_relaxation", {1e-2, 1e-3, 1e-4}},
                                           {"static", {1e-6}}};
  return all;
}

/// One way to answer, and what was measured of it.
struct Run {
  std::string method;
  IntegratorOptions options;
  double steps;  ///< a frame; of equilibria the tolerance
  std::string setting = {};
  bool untuned = false;
  std::size_t effort = 0;  ///< its place among those of the family
  std::vector<double> seconds = {};
  double error = no_value;
  double energy = no_value, displacement = no_value;  ///< largest, over what the scene supplies
  std::string bounds = {};
  Status status = Status::ok;
  bool in_time = true;  ///< false: it was stopped

  bool ok() const { return status == Status::ok && in_time; }
  std::string outcome() const { return in_time ? std::string(to_string(status)) : too_slow; }
};

/// What is thrown to end a computation that takes too long and cannot be told to stop.
struct OutOfTime {};

/// Another system, whose forces are refused once `most_seconds` have passed.
class TimeLimited final : public SystemWrapper<double> {
 public:
  TimeLimited(System<double>& system, double most_seconds)
      : SystemWrapper(system), most_seconds_(most_seconds) {}

  void force(double t, const Field<double>& x, const Field<double>& v, Field<double>& f) override {
    check();
    other().force(t, x, v, f);
  }
  void acceleration(double t, const Field<double>& x, const Field<double>& v, Field<double>& a) override {
    check();
    other().acceleration(t, x, v, a);
  }

 private:
  void check() const {
    if (watch_.seconds() > most_seconds_) throw OutOfTime{};
  }

  double most_seconds_;
  Stopwatch watch_;
};

/// A point's scene, and the answers that runs are compared with.
class Problem {
 public:
  Problem(const RegimePoint& point, const RegimesConfig& config)
      : config_(config),
        body_(scene_of(point, config), point.cells, {point.young, damping_of_ratio(point.damping_ratio)}),
        bound_(body_.system.spectral_bound()) {}

  /// "ok", or why there is no true motion.
  std::string find_motion() {
    truth_ = find_true_motion(body_, config_.most_reference_seconds, config_.reference_threads);
    return truth_.complaint.empty() ? "ok" : truth_.complaint;
  }
  double uncertainty() const { return truth_.uncertainty; }
  int frames() const { return body_.scene.frames; }

  /// Explicit methods, those of fourth order first: they meet every demand at once.
  std::vector<std::vector<Run>> explicit_motions() {
    std::vector<const IntegratorInfo*> methods;
    for (const char* of_fourth_order : {"rk4", "pefrl"}) methods.push_back(&find_integrator(of_fourth_order));
    for (const ExplicitSteps& choice : cheapest_explicit_steps(body_.system, body_.start, frame))
      if (std::find(methods.begin(), methods.end(), choice.info) == methods.end())
        methods.push_back(choice.info);
    std::vector<std::vector<Run>> all;
    for (const IntegratorInfo* info : methods) {
      all.emplace_back();
      for (const double share : {1.0, 0.5, 0.25, 0.125, 0.0625}) {
        const ExplicitSteps choice = explicit_steps(*info, bound_, frame, share);
        all.back().push_back(
            {.method = info->name, .options = {.dt = choice.dt}, .steps = double(choice.steps)});
      }
    }
    return all;
  }

  /// One run more; what it answers from the first.
  void take_motion(Run& run, double most_seconds) const {
    const bool first = run.seconds.empty();
    const IntegratorInfo& info = find_integrator(run.method);
    MotionWatch watch(body_, velocity_lag(info, run.options.dt));
    const MeasuredMotion measured =
        measure_motion(body_, info, run.options, frames(), most_seconds, [&](const State<double>& state) {
          if (first) watch.add(state);
        });
    run.seconds.push_back(measured.seconds);
    run.status = measured.status;
    run.in_time = measured.in_time;
    if (!first || !measured.ok()) return;
    const MotionExtremes& extremes = watch.extremes();
    run.error = truth_.error_of(body_, measured.motion);
    run.energy = extremes.energy / supplied_energy(truth_.extremes);
    run.displacement = extremes.displacement / truth_.extremes.displacement;
    run.bounds = out_of_bounds(extremes, truth_.extremes, body_.body.config().cell_size);
    // What overflows when it is squared is no number to show.
    if (!std::isfinite(run.error + run.energy + run.displacement)) run.status = Status::non_finite;
  }

  /// The same of the rest.
  std::string find_rest() {
    if (!body_.scene.is_held()) return "nothing holds it";
    Run run{.method = "static", .options = {.tolerance = 1e-8}, .steps = 0};
    rest_ = settle(run, config_.most_reference_seconds);
    if (!run.in_time) return "the reference of the rest takes too long";
    rest_scale_ = body_.squared_distance(rest_, body_.start.x);
    return run.ok() && rest_scale_ > 0 ? "ok" : "the reference of the rest failed";
  }

  /// The same, from the largest tolerance on.
  std::vector<std::vector<Run>> rests() const {
    std::vector<std::vector<Run>> all;
    for (const RestFamily& family : rest_families()) {
      const IntegratorInfo& info = find_integrator(family.method);
      const double dt = info.limit ? safe_share * stable_step(info, bound_) : frame;
      all.emplace_back();
      for (const double tolerance : family.tolerances)
        all.back().push_back(
            {.method = family.method, .options = {.dt = dt, .tolerance = tolerance}, .steps = tolerance});
    }
    return all;
  }

  void take_rest(Run& run, double most_seconds) const {
    const Field<double> x = settle(run, most_seconds);
    if (!run.ok()) return;
    run.error = std::sqrt(body_.squared_distance(x, rest_) / rest_scale_);
    run.displacement = std::sqrt(body_.squared_distance(x, body_.start.x) / rest_scale_);
    run.energy = stored(x) / stored(rest_);
    if (!(run.energy <= bounded_factor)) run.bounds = "energy";
    if (!(run.displacement <= bounded_factor)) run.bounds = "displacement";
  }

  double seconds_per_step() const { return explicit_step_seconds(body_.system); }
  /// The safe explicit step that divides a frame [s].
  double bound_dt() const { return explicit_steps(find_integrator("semi_implicit_euler"), bound_, frame).dt; }

 private:
  static BenchScene scene_of(const RegimePoint& point, const RegimesConfig& config) {
    BenchScene scene = find_bench_scene(point.scene);
    if (config.frames > 0) scene.frames = config.frames;
    return scene;
  }

  double stored(const Field<double>& x) const {
    const auto energy = body_.system.stored_energy(x);
    return energy.elastic + energy.volume;
  }

  Field<double> settle(Run& run, double most_seconds) const {
    State<double> state = body_.start;
    Work work;
    TimeLimited system(body_.system, most_seconds);
    run.in_time = true;
    run.seconds.push_back(seconds_of([&] {
      try {
        run.status = find_integrator(run.method).make<double>(run.options)->advance(system, state, 0, work);
      } catch (const OutOfTime&) {
        run.in_time = false;
      }
    }));
    return std::move(state.x);
  }

  const RegimesConfig& config_;
  BenchBody body_;
  SpectralBound bound_;
  TrueMotion truth_;
  Field<double> rest_;
  double rest_scale_ = 0;  ///< sum of squares of displacements at rest [m^2]
};

bool meets(const Run& run, const Demand& demand) {
  return run.ok() && run.bounds.empty() && (std::isinf(demand.error) || run.error <= demand.error);
}

/// What is asked of runs that answer the same, and how quickly it has been met.
class Race {
 public:
  /// Demands beyond what is certain of the answer are not made.
  Race(const RegimesConfig& config, bool at_rest, double uncertainty) : config_(config) {
    for (const Demand& demand : demands())
      if (demand.at_rest == at_rest && certainty * uncertainty <= demand.error)
        best_.emplace_back(demand, std::numeric_limits<double>::infinity());
  }

  void add(const Run& run) {
    for (auto& [demand, seconds] : best_)
      if (meets(run, demand)) seconds = std::min(seconds, run.seconds.front());
  }
  bool meets_all(const Run& run) const {
    return std::all_of(best_.begin(), best_.end(), [&](const auto& b) { return meets(run, b.first); });
  }
  /// The most that a further run of a family may take, which has met what `done` meets: so many times as long
  /// as the quickest that meets what is left [s].
  double most_seconds(const std::vector<Run>& done) const {
    double most = 0;
    for (const auto& [demand, seconds] : best_)
      if (std::none_of(done.begin(), done.end(), [&](const Run& run) { return meets(run, demand); }))
        most = std::max(most, std::min(config_.most_seconds, config_.most_over_best * seconds));
    return most;
  }
  /// The most that any run may take [s].
  double longest() const { return config_.most_seconds; }
  /// Whether a run meets a demand, and takes at most twice the least time that does.
  bool is_contender(const Run& run) const {
    constexpr double near = 2;
    return std::any_of(best_.begin(), best_.end(), [&](const auto& b) {
      return meets(run, b.first) && run.seconds.front() <= near * b.second;
    });
  }

 private:
  const RegimesConfig& config_;
  std::vector<std::pair<Demand, double>> best_;
};

/// A chain until it meets all, or its next run would take too long. `take` makes a run that is stopped after
/// some time.
template <class Take>
void run_chain(std::vector<Run> chain, Race& race, std::vector<Run>& runs, Take&& take) {
  std::vector<Run> done;
  for (Run& run : chain) {
    const double most_seconds = race.most_seconds(done);
    take(run, most_seconds);
    race.add(run);
    done.push_back(run);
    if (race.meets_all(run) || run.seconds.front() > most_seconds / 2) break;
  }
  runs.insert(runs.end(), done.begin(), done.end());
}

Run run_of(const RegimeFamily& family, int steps, std::size_t e) {
  const Effort& effort = family.efforts[e];
  Run run{.method =
              effort.iterations > 0 ? fmt::format("{}:{}", family.method, effort.iterations) : family.method,
          .options = family.own,
          .steps = double(steps),
          .setting = family.setting,
          .untuned = int(e) == family.untuned,
          .effort = e};
  run.options.dt = frame / steps;
  if (effort.tolerance > 0) {
    run.options.linear_tolerance = effort.tolerance;
    run.setting += fmt::format(", {:g}", effort.tolerance);
  }
  return run;
}

/// How long a run will take at least, from those of its family with fewer steps or less effort, stopped or
/// not [s].
double least_seconds(const std::vector<Run>& done, const Run& next) {
  double least = 0;
  for (const Run& run : done)
    if (run.steps <= next.steps && run.effort <= next.effort)
      least = std::max(least, run.seconds.front() * (run.steps < next.steps ? 1.5 : 1));
  return least;
}

/// Of a family, ascending, all steps, and for each all efforts, but for runs that would take too long, and
/// efforts beyond those that still change the error. What it was given before it was tuned is always tried.
template <class Take>
void run_family(const RegimeFamily& family, Race& race, std::vector<Run>& runs, Take&& take) {
  constexpr double unchanged = 0.02;
  std::vector<Run> done;
  for (const int steps : tried_steps) {
    double before = no_value;
    bool settled = false;
    for (std::size_t e = 0; e < family.efforts.size(); ++e) {
      Run run = run_of(family, steps, e);
      const bool is_first = steps == tried_steps.front() && run.untuned;
      const double most_seconds = race.most_seconds(done);
      if (!is_first && (settled || least_seconds(done, run) > most_seconds)) continue;
      take(run, is_first ? race.longest() : most_seconds);
      race.add(run);
      done.push_back(run);
      settled = settled || std::abs(run.error - before) < unchanged * before;
      before = run.error;
    }
    if (std::any_of(done.begin(), done.end(), [&](const Run& run) { return race.meets_all(run); })) break;
  }
  runs.insert(runs.end(), done.begin(), done.end());
}

/// Those that might be the cheapest again, interleaved.
template <class Take>
Json repeated(const RegimesConfig& config, const Race& race, std::vector<Run> runs, Take&& take) {
  std::vector<Run*> again;
  for (Run& run : runs)
    if (race.is_contender(run) && run.seconds.front() < config.most_seconds) again.push_back(&run);
  interleave(config.repetitions - 1, again.size(), Progress{},
             [&](std::size_t i) { take(*again[i], std::numeric_limits<double>::infinity()); });
  Json all = Json::array();
  for (const Run& run : runs) {
    const Quartiles time = quartiles(run.seconds);
    const bool shown = run.ok();
    all.push_back({{"method", run.method},
                   {"setting", run.setting},
                   {"untuned", run.untuned ? 1 : 0},
                   {"steps", run.steps},
                   {"seconds", time.median},
                   {"q1", time.q1},
                   {"q3", time.q3},
                   {"error", shown ? run.error : no_value},
                   {"energy", shown ? run.energy : no_value},
                   {"displacement", shown ? run.displacement : no_value},
                   {"bounds", !shown               ? ""
                              : run.bounds.empty() ? within_bounds
                                                   : run.bounds.c_str()},
                   {"status", run.outcome()}});
  }
  return all;
}

Json measured_motions(const RegimesConfig& config, Problem& problem) {
  Race race(config, false, problem.uncertainty());
  const auto take = [&](Run& run, double most_seconds) { problem.take_motion(run, most_seconds); };
  std::vector<Run> runs;
  for (std::vector<Run>& chain : problem.explicit_motions()) run_chain(std::move(chain), race, runs, take);
  for (const RegimeFamily& family : regime_families()) run_family(family, race, runs, take);
  return repeated(config, race, std::move(runs), take);
}

Json measured_rests(const RegimesConfig& config, const Problem& problem) {
  Race race(config, true, 0);
  const auto take = [&](Run& run, double most_seconds) { problem.take_rest(run, most_seconds); };
  std::vector<Run> runs;
  for (std::vector<Run>& chain : problem.rests()) run_chain(std::move(chain), race, runs, take);
  return repeated(config, race, std::move(runs), take);
}

RegimeFamily linear_family(const char* solver, std::vector<Effort> efforts, int untuned = -1) {
  return {.method = "backward_euler_linear",
          .own = {.linear_solver = solver},
          .setting = solver,
          .efforts = std::move(efforts),
          .untuned = untuned};
}

/// `untuned`: a number of iterations, or -1.
RegimeFamily iterating_family(const char* method, int untuned, double chebyshev_radius = 0) {
  RegimeFamily family{.method = method,
                      .own = {.chebyshev_radius = chebyshev_radius},
                      .setting = chebyshev_radius > 0 ? fmt::format("rho = {:g}", chebyshev_radius) : ""};
  for (const int iterations : tried_iterations) {
    if (iterations == untuned) family.untuned = int(family.efforts.size());
    family.efforts.push_back({.iterations = iterations});
  }
  return family;
}

}  // namespace

const std::vector<RegimeFamily>& regime_families() {
  static const std::vector<RegimeFamily> all = [] {
    std::vector<RegimeFamily> families{linear_family("automatic", {{.tolerance = 1e-10}}, 0),
                                       linear_family("cholmod", {{}})};
    std::vector<Effort> tolerances;
    for (const double tolerance : tried_tolerances) tolerances.push_back({.tolerance = tolerance});
    for (const char* solver : {"matrix_free", "multigrid"})
      families.push_back(linear_family(solver, tolerances));
    for (const char* method : {"backward_euler/lbfgs", "tr_bdf2/lbfgs", "generalized_alpha/lbfgs"})
      families.push_back(iterating_family(method, 5));
    families.push_back(iterating_family("xpbd", 1));
    families.push_back(iterating_family("vbd", 20));
    for (const double radius : {0.9, 0.95}) families.push_back(iterating_family("vbd", -1, radius));
    return families;
  }();
  return all;
}

std::string RegimePoint::name() const {
  return fmt::format("{}, {} cells, ratio {}, E {:.6g}", scene, cells, damping_ratio, young);
}

Json compute_point(const RegimePoint& point, const RegimesConfig& config) {
  Problem problem(point, config);
  Json result{{"motion", Json::array()}, {"rest", Json::array()}};
  result["explicit_step"] = problem.seconds_per_step();
  result["explicit_dt"] = problem.bound_dt();
  result["frames"] = problem.frames();
  result["motion_status"] = problem.find_motion();
  result["uncertainty"] = problem.uncertainty();
  if (result["motion_status"] == "ok") result["motion"] = measured_motions(config, problem);
  result["rest_status"] = problem.find_rest();
  if (result["rest_status"] == "ok") result["rest"] = measured_rests(config, problem);
  return result;
}

}  // namespace mss::studies::regimes

// The runs of `mss regimes`: one cube, every method that might be cheapest, as motion and at rest.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/system/system_wrapper.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/simulation/explicit_steps.hpp"
#include "experiments/simulation/held_cube.hpp"
#include "experiments/studies/regimes/regimes.hpp"

namespace mss::studies::regimes {

namespace {

/// Methods for any step, with the steps a frame that are tried.
struct Family {
  const char* method;
  std::vector<int> steps;
};
const std::vector<Family>& families() {
  static const std::vector<Family> all{{"backward_euler_linear", {1, 2, 4, 8, 16}},
                                       {"backward_euler/lbfgs:2", {1, 2, 4, 8}},
                                       {"backward_euler/lbfgs:5", {1, 2, 4, 8, 16}},
                                       {"backward_euler/lbfgs:10", {1}},
                                       {"generalized_alpha/lbfgs:5", {1, 2, 4, 8, 16}},
                                       {"tr_bdf2/lbfgs:2", {1, 2, 4, 8, 16}},
                                       {"tr_bdf2/lbfgs:4", {1, 2, 4, 8, 16}},
                                       {"xpbd", {1, 2, 5, 10, 20, 50}},
                                       {"xpbd:10", {1, 4}},
                                       {"vbd:5", {1, 4}},
                                       {"vbd:20", {1, 4}}};
  return all;
}

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
  std::vector<double> seconds = {};
  double error = no_value;
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

class Problem {
 public:
  Problem(const RegimePoint& point, const RegimesConfig& config)
      : config_(config),
        cube_({.young = point.young, .poisson = 0.3}, point.cells, point.damping_ratio, 1),
        bound_(cube_.system.spectral_bound()) {}

  /// "ok", or why there is no true motion.
  std::string find_motion() {
    constexpr double share = 0.5, forces_per_step = 4;
    const ExplicitSteps truth = explicit_steps(find_integrator("rk4"), bound_, frame, share);
    if (forces_per_step * seconds_per_step() * double(truth.steps) * config_.frames >
        config_.most_reference_seconds)
      return "the reference of the motion would take too long";
    MeasuredMotion measured = measure_motion(cube_, *truth.info, {.dt = truth.dt}, config_.frames);
    true_ = std::move(measured.motion);
    scale_ = squared_displacement(cube_, true_);
    return true_.empty() ? "the reference of the motion failed" : "ok";
  }

  /// Chains of runs of one method each, from the longest step on.
  std::vector<std::vector<Run>> motions() {
    std::vector<std::vector<Run>> all;
    std::vector<const IntegratorInfo*> methods;
    for (const char* of_fourth_order : {"rk4", "pefrl"})  // first: they meet every demand at once
      methods.push_back(&find_integrator(of_fourth_order));
    for (const ExplicitSteps& choice : cheapest_explicit_steps(cube_.system, cube_.start, frame))
      if (std::find(methods.begin(), methods.end(), choice.info) == methods.end())
        methods.push_back(choice.info);
    for (const IntegratorInfo* info : methods) {
      all.emplace_back();
      for (const double share : {1.0, 0.5, 0.25, 0.125, 0.0625})
        add_explicit(explicit_steps(*info, bound_, frame, share), all.back());
    }
    for (const Family& family : families()) {
      all.emplace_back();
      for (const int steps : family.steps)
        all.back().push_back(
            {.method = family.method, .options = {.dt = frame / steps}, .steps = double(steps)});
    }
    return all;
  }

  /// One run more; its error from the first.
  void take_motion(Run& run, double most_seconds) const {
    const MeasuredMotion measured =
        measure_motion(cube_, find_integrator(run.method), run.options, config_.frames, most_seconds);
    run.seconds.push_back(measured.seconds);
    run.status = measured.status;
    run.in_time = measured.in_time;
    if (measured.ok() && std::isnan(run.error))
      run.error = std::sqrt(squared_distance(cube_, measured.motion, true_) / scale_);
  }

  /// The same of the rest.
  std::string find_rest() {
    Run run{.method = "static", .options = {.tolerance = 1e-8}, .steps = 0};
    rest_ = settle(run, config_.most_reference_seconds);
    if (!run.in_time) return "the reference of the rest takes too long";
    scale_ = cube_.squared_distance(rest_, cube_.start.x);
    return run.ok() && scale_ > 0 ? "ok" : "the reference of the rest failed";
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
    if (run.ok()) run.error = std::sqrt(cube_.squared_distance(x, rest_) / scale_);
  }

  double seconds_per_step() const { return explicit_step_seconds(cube_.system); }
  /// The safe explicit step that divides a frame [s].
  double bound_dt() const { return explicit_steps(find_integrator("semi_implicit_euler"), bound_, frame).dt; }

 private:
  void add_explicit(const ExplicitSteps& choice, std::vector<Run>& all) const {
    all.push_back({.method = choice.info->name, .options = {.dt = choice.dt}, .steps = double(choice.steps)});
  }

  Field<double> settle(Run& run, double most_seconds) const {
    State<double> state = cube_.start;
    Work work;
    TimeLimited system(cube_.system, most_seconds);
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
  HeldCube cube_;
  SpectralBound bound_;
  FramePositions true_;
  Field<double> rest_;
  double scale_ = 0;  ///< sum of squares of the true displacements [m^2]
};

/// The least error that anything asks for.
double tightest(bool at_rest) {
  double error = 1;
  for (const Demand& demand : demands())
    if (demand.at_rest == at_rest) error = std::min(error, demand.error);
  return error;
}

bool meets(const Run& run, double error) { return run.ok() && run.error <= error; }

/// Whether a run meets a demand, and takes at most twice the least time that does.
bool is_contender(const std::vector<Run>& runs, const Run& run, bool at_rest) {
  constexpr double near = 2;
  for (const Demand& demand : demands()) {
    if (demand.at_rest != at_rest || !meets(run, demand.error)) continue;
    double least = std::numeric_limits<double>::infinity();
    for (const Run& other : runs)
      if (meets(other, demand.error)) least = std::min(least, other.seconds.front());
    if (run.seconds.front() <= near * least) return true;
  }
  return false;
}

/// Every chain until it meets the tightest demand, or its next run would take too long: longer than any may,
/// or so many times as long as one that meets every demand. `take` makes a run that is stopped after some
/// time.
template <class Take>
std::vector<Run> first_runs(const RegimesConfig& config, std::vector<std::vector<Run>> chains, bool at_rest,
                            Take&& take) {
  std::vector<Run> runs;
  double most_seconds = config.most_seconds;
  for (std::vector<Run>& chain : chains)
    for (Run& run : chain) {
      take(run, most_seconds);
      runs.push_back(run);
      const bool enough = meets(run, tightest(at_rest));
      if (enough) most_seconds = std::min(most_seconds, config.most_over_best * run.seconds.front());
      if (enough || run.seconds.front() > most_seconds / 2) break;
    }
  return runs;
}

/// The first runs; then, interleaved, those that might be the cheapest again.
template <class Take>
Json measured(const RegimesConfig& config, std::vector<std::vector<Run>> chains, bool at_rest, Take&& take) {
  std::vector<Run> runs = first_runs(config, std::move(chains), at_rest, take);
  std::vector<Run*> again;
  for (Run& run : runs)
    if (is_contender(runs, run, at_rest) && run.seconds.front() < config.most_seconds / 4)
      again.push_back(&run);
  interleave(config.repetitions - 1, again.size(), Progress{},
             [&](std::size_t i) { take(*again[i], config.most_seconds); });
  Json all = Json::array();
  for (const Run& run : runs) {
    const Quartiles time = quartiles(run.seconds);
    all.push_back({{"method", run.method},
                   {"steps", run.steps},
                   {"seconds", time.median},
                   {"q1", time.q1},
                   {"q3", time.q3},
                   {"error", run.error},
                   {"status", run.outcome()}});
  }
  return all;
}

}  // namespace

std::string RegimePoint::name() const {
  return fmt::format("{} cells, ratio {}, E {:.6g}", cells, damping_ratio, young);
}

Json compute_point(const RegimePoint& point, const RegimesConfig& config) {
  Problem problem(point, config);
  Json result{{"motion", Json::array()}, {"rest", Json::array()}};
  result["explicit_step"] = problem.seconds_per_step();
  result["explicit_dt"] = problem.bound_dt();
  result["motion_status"] = problem.find_motion();
  if (result["motion_status"] == "ok")
    result["motion"] = measured(config, problem.motions(), false, [&](Run& run, double most_seconds) {
      problem.take_motion(run, most_seconds);
    });
  result["rest_status"] = problem.find_rest();
  if (result["rest_status"] == "ok")
    result["rest"] = measured(config, problem.rests(), true,
                              [&](Run& run, double most_seconds) { problem.take_rest(run, most_seconds); });
  return result;
}

}  // namespace mss::studies::regimes

// The runs of `mss regimes`: one cube, every method that might be cheapest, as motion and at rest.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/harness/measure.hpp"
#include "experiments/simulation/explicit_steps.hpp"
#include "experiments/simulation/held_cube.hpp"
#include "experiments/studies/regimes/regimes.hpp"

namespace mss::studies::regimes {

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

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
  static const std::vector<RestFamily> all{{"static", {1e-6}},
                                           {"static/projective", {1e-2, 1e-3, 1e-4}},
                                           {"static/lbfgs", {1e-2, 1e-3, 1e-4}},
                                           {"dynamic_relaxation", {1e-2, 1e-3, 1e-4}}};
  return all;
}

/// One way to answer, and what was measured of it.
struct Run {
  std::string method;
  IntegratorOptions options;
  double steps;  ///< a frame; of equilibria the tolerance
  std::vector<double> seconds = {};
  double error = none;
  Status status = Status::ok;
};

/// Positions at the end of every frame; empty if a frame failed.
using Motion = std::vector<Field<double>>;

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
    if (forces_per_step * seconds_of_frame(truth) * config_.frames > config_.most_seconds)
      return "the reference of the motion would take too long";
    Run run{.method = truth.info->name, .options = {.dt = truth.dt}, .steps = double(truth.steps)};
    true_ = move(run);
    scale_ = 0;
    for (const Field<double>& x : true_) scale_ += cube_.squared_distance(x, cube_.start.x);
    return true_.empty() ? "the reference of the motion failed" : "ok";
  }

  /// Chains of runs of one method each, from the longest step on.
  std::vector<std::vector<Run>> motions() {
    std::vector<std::vector<Run>> all;
    std::vector<const IntegratorInfo*> methods;
    for (const ExplicitSteps& choice : cheapest_explicit_steps(cube_.system, cube_.start, frame))
      methods.push_back(choice.info);
    for (const char* of_fourth_order : {"pefrl", "rk4"})
      if (const IntegratorInfo* info = &find_integrator(of_fourth_order);
          std::find(methods.begin(), methods.end(), info) == methods.end())
        methods.push_back(info);
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

  void take_motion(Run& run) const {
    const Motion motion = move(run);
    if (motion.empty() || !std::isnan(run.error)) return;
    double sum = 0;
    for (std::size_t i = 0; i < motion.size(); ++i) sum += cube_.squared_distance(motion[i], true_[i]);
    run.error = std::sqrt(sum / scale_);
  }

  /// The same of the rest.
  std::string find_rest() {
    Run run{.method = "static", .options = {.tolerance = 1e-8}, .steps = 0};
    rest_ = settle(run);
    scale_ = cube_.squared_distance(rest_, cube_.start.x);
    return run.status == Status::ok && scale_ > 0 ? "ok" : "the reference of the rest failed";
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

  void take_rest(Run& run) const {
    const Field<double> x = settle(run);
    if (run.status == Status::ok) run.error = std::sqrt(cube_.squared_distance(x, rest_) / scale_);
  }

  /// Of one explicit step [s].
  double seconds_per_step() const {
    const auto method = find_integrator("semi_implicit_euler").make<double>({.dt = bound_dt()});
    State<double> state = cube_.start;
    Work work;
    const auto seconds_for = [&](long steps) {
      return seconds_of(
          [&] { method->advance(cube_.system, state, state.t + double(steps) * bound_dt(), work); });
    };
    return sample_length(5e-3, seconds_for).seconds_per_step;
  }
  double bound_dt() const { return explicit_steps(find_integrator("semi_implicit_euler"), bound_, frame).dt; }

 private:
  double seconds_of_frame(const ExplicitSteps& choice) const {
    return seconds_per_step() * double(choice.steps);
  }

  void add_explicit(const ExplicitSteps& choice, std::vector<Run>& all) const {
    all.push_back({.method = choice.info->name, .options = {.dt = choice.dt}, .steps = double(choice.steps)});
  }

  Motion move(Run& run) const {
    Motion motion;
    State<double> state = cube_.start;
    Work work;
    double seconds = 0;
    std::unique_ptr<Integrator<double>> integrator;
    for (int i = 1; i <= config_.frames && run.status == Status::ok && seconds < config_.most_seconds; ++i) {
      seconds += seconds_of([&] {
        if (!integrator) integrator = find_integrator(run.method).make<double>(run.options);
        run.status = integrator->advance(cube_.system, state, i * frame, work);
      });
      motion.push_back(state.x);
    }
    run.seconds.push_back(seconds);
    if (std::ssize(motion) < config_.frames && run.status == Status::ok) run.status = Status::step_limit;
    if (run.status == Status::ok && !motion.back().array().isFinite().all()) run.status = Status::non_finite;
    if (run.status != Status::ok) motion.clear();
    return motion;
  }

  Field<double> settle(Run& run) const {
    State<double> state = cube_.start;
    Work work;
    run.seconds.push_back(seconds_of([&] {
      run.status =
          find_integrator(run.method).make<double>(run.options)->advance(cube_.system, state, 0, work);
    }));
    return std::move(state.x);
  }

  const RegimesConfig& config_;
  HeldCube cube_;
  SpectralBound bound_;
  Motion true_;
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

/// Whether a run meets a demand, and takes at most twice the least time that does.
bool is_contender(const std::vector<Run>& runs, const Run& run, bool at_rest) {
  constexpr double near = 2;
  const auto meets = [](const Run& r, double error) { return r.status == Status::ok && r.error <= error; };
  for (const Demand& demand : demands()) {
    if (demand.at_rest != at_rest || !meets(run, demand.error)) continue;
    double least = std::numeric_limits<double>::infinity();
    for (const Run& other : runs)
      if (meets(other, demand.error)) least = std::min(least, other.seconds.front());
    if (run.seconds.front() <= near * least) return true;
  }
  return false;
}

/// Every chain until it meets the tightest demand, or takes too long; then, interleaved, those that might be
/// the cheapest again.
template <class Take>
Json measured(const RegimesConfig& config, std::vector<std::vector<Run>> chains, bool at_rest, Take&& take) {
  std::vector<Run> runs;
  for (std::vector<Run>& chain : chains)
    for (Run& run : chain) {
      take(run);
      runs.push_back(run);
      if (run.error <= tightest(at_rest) || run.seconds.front() > config.most_seconds / 2) break;
    }
  std::vector<Run*> again;
  for (Run& run : runs)
    if (is_contender(runs, run, at_rest) && run.seconds.front() < config.most_seconds / 4)
      again.push_back(&run);
  interleave(config.repetitions - 1, again.size(), Progress{}, [&](std::size_t i) { take(*again[i]); });
  Json all = Json::array();
  for (const Run& run : runs) {
    const Quartiles time = quartiles(run.seconds);
    all.push_back({{"method", run.method},
                   {"steps", run.steps},
                   {"seconds", time.median},
                   {"q1", time.q1},
                   {"q3", time.q3},
                   {"error", run.error},
                   {"status", to_string(run.status)}});
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
    result["motion"] =
        measured(config, problem.motions(), false, [&](Run& run) { problem.take_motion(run); });
  result["rest_status"] = problem.find_rest();
  if (result["rest_status"] == "ok")
    result["rest"] = measured(config, problem.rests(), true, [&](Run& run) { problem.take_rest(run); });
  return result;
}

}  // namespace mss::studies::regimes

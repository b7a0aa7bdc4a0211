#include "experiments/fit/fit.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <thread>
#include <tuple>

#include "core/base/error.hpp"
#include "core/base/thread_team.hpp"
#include "experiments/fit/coarse_model.hpp"
#include "experiments/fit/observed_run.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/ring_down.hpp"
#include "experiments/harness/statistics.hpp"
#include "experiments/harness/table.hpp"

namespace mss::fit {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Single values that are not zero are taken as power laws of the parameters.
bool is_logarithmic(const Observation& o) { return o.kind != Kind::series && o.measured.front() != 0; }

/// Whether a parameter can change a run: what damps or starts a motion changes neither where a body rests nor
/// its vibrations.
bool changes(const Parameter& p, const RunSpec& run) {
  const bool damps = p.key.starts_with("damping.") || p.key.find(".damping.") != std::string::npos;
  const bool starts = p.key.starts_with("start.") || p.key.starts_with("strike.");
  const bool relaxes = p.key.starts_with("material.relaxation.");
  if (run.modes) return !damps && !starts;
  return !(run.at_rest && (damps || starts || relaxes));
}

/// A run of one scene at one trial.
struct Task {
  std::size_t trial, run;
  ObservedValues found{};
};

/// Does tasks in as many threads as there are cores; `between` is called meanwhile, now and then.
void do_all(std::vector<Task>& tasks, const std::function<void(Task&)>& perform,
            const std::function<void()>& between) {
  std::atomic<std::size_t> next{0}, done{0};
  std::exception_ptr failure;
  std::atomic_flag failed;
  const auto work = [&] {
    for (std::size_t k = next++; k < tasks.size(); k = next++) {
      try {
        perform(tasks[k]);
      } catch (...) {
        if (!failed.test_and_set()) failure = std::current_exception();
      }
      ++done;
    }
  };
  std::vector<std::jthread> threads;
  for (int n = 0; n < std::min(available_cores(), int(tasks.size())); ++n) threads.emplace_back(work);
  while (done < tasks.size()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    between();
  }
  threads.clear();
  if (failure) std::rethrow_exception(failure);
}

/// Evaluates the model of a problem for the least-squares solver.
class Model {
 public:
  Model(const FitProblem& problem, Progress& progress, FitResult& result)
      : problem_(problem), progress_(progress), result_(result), of_run_(problem.data.runs.size()) {
    for (const Observation& o : problem.data.observations) of_run_[o.run].push_back(&o);
  }

  std::vector<Evaluation> evaluate(const std::vector<Trial>& trials) {
    std::vector<Task> tasks;
    for (std::size_t t = 0; t < trials.size(); ++t)
      for (std::size_t r = 0; r < of_run_.size(); ++r)
        if (trials[t].only < 0 || changes(problem_.parameters[std::size_t(trials[t].only)], runs()[r]))
          tasks.push_back({t, r});
    const bool alone = tasks.size() == 1;
    do_all(
        tasks, [&](Task& task) { task.found = run(trials[task.trial], task.run, alone); },
        [&] {
          if (progress_.stopped()) stop_ = true;
          progress_.report(evaluations_ / problem_.most_evaluations,
                           fmt::format("evaluation {:.3g}", evaluations_ + 1));
        });
    result_.runs += int(tasks.size());
    evaluations_ += double(tasks.size()) / double(of_run_.size());
    has_started_ = true;
    return gathered(trials, tasks);
  }
  bool stopped() const { return stop_; }

 private:
  const std::vector<RunSpec>& runs() const { return problem_.data.runs; }

  /// Settings that are not allowed end a trial, but at the start the program.
  ObservedValues run(const Trial& trial, std::size_t r, bool alone) const {
    if (stop_) return {.problem = "interrupted"};
    try {
      Scene scene = runs()[r].load(settings_of(problem_, values_of(problem_, trial.u)));
      if (!alone) scene.solve.threads = 1;
      ObservedValues found = observe(scene, runs()[r], of_run_[r], stop_);
      if (!found.problem.empty()) found.problem = runs()[r].name + ": " + found.problem;
      return found;
    } catch (const InputError& error) {
      if (!has_started_) throw;
      return {.problem = error.what()};
    }
  }

  std::vector<Evaluation> gathered(const std::vector<Trial>& trials, const std::vector<Task>& tasks) const {
    std::vector<Evaluation> found(trials.size());
    for (std::size_t t = 0; t < trials.size(); ++t) {
      found[t].share = 0;
      found[t].values = VectorXd::Constant(target_count(), no_value);
    }
    for (const Task& task : tasks) {
      Evaluation& of_trial = found[task.trial];
      of_trial.share += 1 / double(of_run_.size());
      std::string trouble = task.found.problem;
      for (std::size_t k = 0; k < task.found.values.size() && trouble.empty(); ++k) {
        const Observation& o = *of_run_[task.run][k];
        trouble = trouble_of_sign(o, task.found.values[k].front());
        std::copy(task.found.values[k].begin(), task.found.values[k].end(),
                  of_trial.values.data() + first_of(o));
      }
      if (of_trial.problem.empty()) of_trial.problem = trouble;
    }
    return found;
  }
  std::string trouble_of_sign(const Observation& o, double value) const {
    if (!is_logarithmic(o) || value / o.measured.front() > 0) return {};
    return fmt::format("{}: {} is {:.4g}, and {:.4g} was measured, of the other sign", runs()[o.run].name,
                       o.name, value, o.measured.front());
  }
  /// Where an observation's numbers begin among all.
  std::ptrdiff_t first_of(const Observation& sought) const {
    std::ptrdiff_t first = 0;
    for (const Observation& o : problem_.data.observations) {
      if (&o == &sought) break;
      first += std::ptrdiff_t(o.measured.size());
    }
    return first;
  }
  Eigen::Index target_count() const {
    Eigen::Index count = 0;
    for (const Observation& o : problem_.data.observations) count += Eigen::Index(o.measured.size());
    return count;
  }

  const FitProblem& problem_;
  Progress& progress_;
  FitResult& result_;
  std::vector<std::vector<const Observation*>> of_run_;
  std::atomic<bool> stop_ = false;
  double evaluations_ = 0;
  bool has_started_ = false;
};

/// The problem whose runs are the cheap twins.
FitProblem twin_of(const FitProblem& problem) {
  FitProblem twin = problem;
  for (RunSpec& run : twin.data.runs)
    run.load = [load = run.load, coarse = problem.coarse](const std::vector<std::string>& more) {
      std::vector<std::string> all = coarse;
      all.insert(all.end(), more.begin(), more.end());
      return load(all);
    };
  return twin;
}

std::vector<Target> targets_of(const FitProblem& problem) {
  std::vector<Target> targets;
  for (const Observation& o : problem.data.observations)
    for (const double measured : o.measured) targets.push_back({measured, o.uncertainty, is_logarithmic(o)});
  return targets;
}

LeastSquaresProblem least_squares_of(const FitProblem& problem, Model& model) {
  LeastSquaresProblem squares{.targets = targets_of(problem), .most_evaluations = problem.most_evaluations};
  const auto count = Eigen::Index(problem.parameters.size());
  squares.start.resize(count);
  squares.low.resize(count);
  squares.high.resize(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Parameter& p = problem.parameters[std::size_t(k)];
    constexpr double none = std::numeric_limits<double>::infinity();
    squares.start[k] = p.coordinate(p.start);
    squares.low[k] =
        std::isfinite(p.low) && !(p.is_logarithmic() && p.low <= 0) ? p.coordinate(p.low) : -none;
    squares.high[k] = std::isfinite(p.high) ? p.coordinate(p.high) : none;
  }
  squares.evaluate = [&](const std::vector<Trial>& trials) { return model.evaluate(trials); };
  squares.stopped = [&] { return model.stopped(); };
  return squares;
}

std::string names_of(const FitProblem& problem, const std::vector<int>& coordinates) {
  std::vector<std::string> names;
  for (const int k : coordinates) names.push_back(problem.parameters[std::size_t(k)].key);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// Throws InputError where the fit could not begin.
void check_start(const FitProblem& problem, const LeastSquaresResult& found) {
  if (found.ended == Ended::failed_at_start) {
    const bool by_twin = !problem.coarse.empty();
    throw InputError(fmt::format(
        "the fit cannot start: {} ({}) {}; give {}",
        !by_twin                 ? "with the values that it starts from"
        : found.evaluations == 0 ? "the coarse scene, with the values that it starts from"
                                 : "where the coarse scene fits best",
        fmt::join(settings_of(problem, values_of(problem, found.u)), ", "), found.problem,
        by_twin && found.evaluations > 0 ? "another coarse scene, or none" : "others with --set"));
  }
  if (found.ended != Ended::undetermined) return;
  const std::string names = names_of(problem, found.undetermined);
  const bool is_one = found.undetermined.size() == 1;
  throw InputError(fmt::format(
      "the data do not determine {}: {}; fit fewer parameters, or give data that tell", names,
      is_one ? "nothing that was measured depends on it"
             : "changes of these together leave all that was measured as it is, or nothing depends on them"));
}

/// A series that rings, as its frequency and damping ratio.
std::vector<Observation> ring_down_of_series(const Observation& series) {
  const RingDown ring = ring_down(series.times, series.measured);
  if (!(ring.swing_damping_ratio > 0)) return {};  // nor where it does not ring
  Observation frequency{.name = series.name,
                        .kind = Kind::frequency,
                        .run = series.run,
                        .point = series.point,
                        .column = series.column,
                        .measured = {ring.frequency},
                        .uncertainty = 0.01 * ring.frequency,
                        .from = series.times.front(),
                        .until = series.times.back()};
  Observation damping = frequency;
  damping.kind = Kind::damping;
  damping.measured = {ring.swing_damping_ratio};
  damping.uncertainty = 0.05 * ring.swing_damping_ratio;
  return {std::move(frequency), std::move(damping)};
}

/// The problem with every series that rings replaced; nothing where none does, or too little is left. Out of
/// phase, computed and measured waves fit best where the computed one is damped away.
std::optional<FitProblem> with_ring_downs(const FitProblem& problem) {
  FitProblem simpler = problem;
  simpler.data.observations.clear();
  bool any = false;
  for (const Observation& o : problem.data.observations) {
    const std::vector<Observation> ring =
        o.kind == Kind::series ? ring_down_of_series(o) : std::vector<Observation>{};
    any = any || !ring.empty();
    for (const Observation& part : ring) simpler.data.observations.push_back(part);
    if (ring.empty()) simpler.data.observations.push_back(o);
  }
  if (!any || targets_of(simpler).size() < problem.parameters.size()) return std::nullopt;
  return simpler;
}

/// Evaluations that derivatives by differences take, and where they are taken.
double to_begin(const FitProblem& problem) { return 1 + double(problem.parameters.size()); }

/// Solves a simpler problem for where to start with another, if it has a solution.
void begin_with(const FitProblem& simpler, Progress& progress, LeastSquaresProblem& squares,
                FitResult& result) {
  Model model(simpler, progress, result);
  LeastSquaresProblem of_rings = least_squares_of(simpler, model);
  of_rings.least_step = 0.01;  // it is a start only
  of_rings.most_evaluations -= to_begin(simpler);
  const LeastSquaresResult found = solve_least_squares(of_rings);
  if (found.ended == Ended::converged) squares.start = found.u;
  squares.most_evaluations -= found.evaluations;
  result.evaluations += found.evaluations;
  for (TriedStep step : found.steps) {
    step.kind = "of ring-downs: " + step.kind;
    result.steps.push_back(std::move(step));
  }
}

/// Solves a problem as it is.
LeastSquaresResult solve_directly(const FitProblem& problem, LeastSquaresProblem& squares, Progress& progress,
                                  FitResult& result) {
  const auto simpler = with_ring_downs(problem);
  if (simpler && problem.most_evaluations >= 2 * to_begin(problem))
    begin_with(*simpler, progress, squares, result);
  return solve_least_squares(squares);
}

constexpr double most_of_twin = 30;  ///< evaluations, each time that it is fitted

/// The same by the twins of its runs.
LeastSquaresResult solve_by_twin(const FitProblem& problem, const LeastSquaresProblem& squares,
                                 Progress& progress, FitResult& result) {
  FitProblem twin = twin_of(problem);
  twin.most_evaluations = most_of_twin;
  FitResult of_twin;
  Model model(twin, progress, of_twin);
  LeastSquaresProblem coarse = least_squares_of(twin, model);
  if (const auto simpler = with_ring_downs(twin)) begin_with(*simpler, progress, coarse, of_twin);
  coarse.most_evaluations = most_of_twin;
  LeastSquaresResult found = solve_by_coarse_model(squares, coarse);
  result.coarse_runs = of_twin.runs;
  for (TriedStep& step : of_twin.steps) {
    step.kind = "coarse: " + step.kind;
    step.evaluations = 0;
    result.steps.push_back(std::move(step));
  }
  return found;
}

/// Intervals of parameters within their bounds, from the residuals; correlations between them.
void add_intervals(const FitProblem& problem, const LeastSquaresResult& found, FitResult& result) {
  const auto count = Eigen::Index(problem.parameters.size());
  std::vector<Eigen::Index> free;
  for (Eigen::Index k = 0; k < count; ++k)
    if (!result.parameters[std::size_t(k)].at_bound) free.push_back(k);
  result.degrees_of_freedom = int(found.jacobian.rows()) - int(free.size());
  result.correlation = MatrixXd::Constant(count, count, no_value);
  const MatrixXd jacobian = found.jacobian(Eigen::all, free);
  const std::vector<int> undetermined = undetermined_coordinates(jacobian, targets_of(problem));
  for (const Eigen::Index k : free) {
    FittedParameter& p = result.parameters[std::size_t(k)];
    if (result.degrees_of_freedom == 0) p.status = "no degrees of freedom";
    if (!undetermined.empty()) p.status = "not determined by the data";
  }
  if (result.degrees_of_freedom == 0 || free.empty() || !undetermined.empty()) return;
  const MatrixXd covariance = covariance_of(jacobian, found.chi2);
  const double t = student_t(0.95, result.degrees_of_freedom);
  for (std::size_t a = 0; a < free.size(); ++a) {
    const auto i = Eigen::Index(a);
    const double u = found.u[free[a]], error = std::sqrt(covariance(i, i));
    const Parameter& parameter = problem.parameters[std::size_t(free[a])];
    FittedParameter& p = result.parameters[std::size_t(free[a])];
    const double low = parameter.unbounded(u - t * error), high = parameter.unbounded(u + t * error);
    constexpr double wide = 100;  // high over low
    if (!std::isfinite(low) || !std::isfinite(high))
      p.status = "not determined by the data";
    else if (parameter.is_logarithmic() && high / low > wide)
      p.status = "hardly determined by the data";
    if (std::isfinite(low) && std::isfinite(high))
      std::tie(p.low, p.high) = std::pair(std::max(low, parameter.low), std::min(high, parameter.high));
    for (std::size_t b = 0; b < free.size(); ++b) {
      const auto j = Eigen::Index(b);
      result.correlation(free[a], free[b]) =
          covariance(i, j) / std::sqrt(covariance(i, i) * covariance(j, j));
    }
  }
}

}  // namespace

std::vector<double> values_of(const FitProblem& problem, const VectorXd& u) {
  std::vector<double> values;
  for (std::size_t k = 0; k < problem.parameters.size(); ++k)
    values.push_back(problem.parameters[k].value(u[Eigen::Index(k)]));
  return values;
}

std::vector<std::string> settings_of(const FitProblem& problem, const std::vector<double>& values) {
  std::vector<std::string> settings;
  for (std::size_t k = 0; k < values.size(); ++k)
    settings.push_back(problem.parameters[k].setting(values[k]));
  return settings;
}

FitProblem read_problem(const SceneSource& source, const std::vector<std::string>& settings,
                        const std::vector<std::string>& parameters) {
  FitProblem problem{.scene = source.load(settings)};
  problem.parameters = read_parameters(parameters, problem.scene);
  problem.source = {source.identity, [source, settings](const std::vector<std::string>& more) {
                      std::vector<std::string> all = settings;
                      all.insert(all.end(), more.begin(), more.end());
                      return source.load(all);
                    }};
  return problem;
}

namespace {

/// Throws InputError for settings of the twins that are wrong, or are of fitted numbers.
void check_twin(const FitProblem& problem, const std::vector<double>& starts) {
  for (const std::string& setting : problem.coarse)
    for (const Parameter& p : problem.parameters)
      if (setting.substr(0, setting.find('=')) == p.key)
        throw InputError(fmt::format("the coarse scene: {} is fitted; its settings leave it alone", p.key));
  try {
    Observations of_twin = twin_of(problem).data;
    check_observations(of_twin, settings_of(problem, starts));
  } catch (const InputError& error) {
    throw InputError(fmt::format("the coarse scene: {}", error.what()));
  }
}

}  // namespace

void check_problem(FitProblem& problem) {
  std::vector<double> starts;
  for (const Parameter& p : problem.parameters) starts.push_back(p.start);
  check_observations(problem.data, settings_of(problem, starts));
  if (problem.coarse.empty() && problem.most_evaluations < to_begin(problem))
    throw InputError(fmt::format("evaluations = {:g} are too few: a fit of {} numbers begins with {:g}",
                                 problem.most_evaluations, problem.parameters.size(), to_begin(problem)));
  if (!problem.coarse.empty()) check_twin(problem, starts);
  const std::size_t points = targets_of(problem).size();
  if (points < problem.parameters.size())
    throw InputError(
        fmt::format("{} measured number{} cannot determine {} parameters; give more data, or fit "
                    "fewer parameters",
                    points, points == 1 ? "" : "s", problem.parameters.size()));
}

FitResult fit(const FitProblem& problem, Progress& progress) {
  const Stopwatch begun;
  FitResult result;
  Model model(problem, progress, result);
  LeastSquaresProblem squares = least_squares_of(problem, model);
  LeastSquaresResult found = problem.coarse.empty() ? solve_directly(problem, squares, progress, result)
                                                    : solve_by_twin(problem, squares, progress, result);
  check_start(problem, found);
  result.ended = found.ended;
  for (TriedStep& step : found.steps) {
    step.evaluations += result.evaluations;
    result.steps.push_back(std::move(step));
  }
  const bool is_known = found.values.size() > 0;
  result.evaluations += found.evaluations;
  result.seconds = begun.seconds();
  result.chi2 = found.chi2;
  if (!is_known) return result;  // interrupted before anything was known
  const std::vector<double> values = values_of(problem, found.u);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const auto i = Eigen::Index(k);
    const bool at_bound = found.u[i] <= squares.low[i] + 1e-9 || found.u[i] >= squares.high[i] - 1e-9;
    result.parameters.push_back({.value = values[k],
                                 .low = no_value,
                                 .high = no_value,
                                 .at_bound = at_bound,
                                 .status = at_bound ? "at its bound" : "ok"});
  }
  if (found.jacobian.size() > 0) add_intervals(problem, found, result);
  Eigen::Index first = 0;
  for (const Observation& o : problem.data.observations) {
    const auto size = Eigen::Index(o.measured.size());
    result.fitted.emplace_back(found.values.data() + first, found.values.data() + first + size);
    first += size;
  }
  return result;
}

}  // namespace mss::fit

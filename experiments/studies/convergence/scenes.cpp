// Bodies of many shapes and scenes that people have, frame by frame: iterations to the converged step of
// backward Euler, and what they cost. The bodies are those for which one needs a preconditioner that knows no
// box: a corner that is missing, half a face that is held, an L, balls, cells left out at random.
#include "experiments/studies/convergence/scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <random>
#include <stdexcept>

#include "core/base/error.hpp"
#include "core/mesh/mesh_fill.hpp"
#include "core/mesh/shapes.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/harness/processor_time.hpp"
#include "experiments/simulation/bench_scenes.hpp"
#include "experiments/simulation/explicit_steps.hpp"
#include "integrators/linear/rest_cycle.hpp"
#include "integrators/nonlinear/implicit_stage.hpp"

namespace mss::studies::convergence {

namespace {

constexpr double percent_error = 1e-2, permille_error = 1e-3;
constexpr double enough_error = 1e-4;  ///< in every frame: further iterations show nothing
constexpr double body_young = 1e7, body_ratio = 0.5;

/// Cells, and what is held.
struct Shape {
  const char* name;
  const char* description;
  BodyConfig (*cells)(int n);
  Box (*held)(int n);
};

BodyConfig of_voxels(VoxelGrid voxels, int n) { return {.voxels = std::move(voxels), .cell_size = 1.0 / n}; }

/// Cells of a grid of n^3 for which `inside(i, j, k)`.
template <class Inside>
BodyConfig cells_where(int n, Inside&& inside) {
  VoxelGrid voxels(n, n, n);
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) voxels.set(i, j, k, inside(i, j, k));
  return of_voxels(std::move(voxels), n);
}

BodyConfig box_cells(int n) { return of_voxels(VoxelGrid::box(n, n, n), n); }

BodyConfig cornerless_cells(int n) {
  VoxelGrid voxels = VoxelGrid::box(n, n, n);
  voxels.set(n - 1, n - 1, n - 1, false);
  return of_voxels(std::move(voxels), n);
}

int l_length(int n) { return int(std::lround(1.3 * n)); }

BodyConfig l_cells(int n) {
  const int length = l_length(n), thickness = int(std::lround(0.45 * n));
  VoxelGrid voxels(length, n, length);
  for (int k = 0; k < length; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < length; ++i) voxels.set(i, j, k, k < thickness || i < thickness);
  return of_voxels(std::move(voxels), n);
}

BodyConfig ball_cells(int n) {
  const double middle = (n - 1) / 2.0, radius = n / 2.0;
  return cells_where(n, [&](int i, int j, int k) {
    return Vec3(i - middle, j - middle, k - middle).squaredNorm() < radius * radius;
  });
}

BodyConfig filled_ball_cells(int n) {
  constexpr double radius = 0.49;
  constexpr int divisions = 16;
  MeshFill fill = fill_mesh(icosphere(radius, divisions), {.cell_size = 1.0 / n});
  return {.voxels = std::move(fill.voxels),
          .contents = std::move(fill.contents),
          .content_of = std::move(fill.content_of),
          .cell_size = fill.cell_size};
}

BodyConfig random_cells(int n) {
  std::mt19937 random(1);
  return cells_where(n, [&](int, int, int) { return random() % 10 < 7; });
}

Box face_held(int) { return {{0, 0, 0}, {0, 1, 1}}; }
Box half_face_held(int) { return {{0, 0, 0}, {0, 0.5, 1}}; }
Box foot_held(int) { return {{0, 0, 0}, {1, 1, 0}}; }
Box end_of_l_held(int n) {
  const double length = double(l_length(n)) / n;
  return {{0, 0, length}, {length, 1, length}};
}

const std::vector<Shape>& all_shapes() {
  static const std::vector<Shape> all{
      {"box", "box", box_cells, face_held},
      {"missing_corner", "box without a corner cell", cornerless_cells, face_held},
      {"half_held", "box, half a face held", box_cells, half_face_held},
      {"l_shape", "L", l_cells, end_of_l_held},
      {"ball", "ball", ball_cells, foot_held},
      {"filled_ball", "ball, partly filled cells", filled_ball_cells, foot_held},
      {"random_cells", "box without a random 30 % of its cells", random_cells, face_held}};
  return all;
}

const Shape& shape_of(const std::string& name) {
  const auto& all = all_shapes();
  return *std::find_if(all.begin(), all.end(), [&](const Shape& shape) { return shape.name == name; });
}

std::unique_ptr<MovingBody> moving_body_of(const StepBody& of, int threads) {
  const Shape& shape = shape_of(of.shape);
  BodyConfig config = shape.cells(of.cells);
  config.fill({.young = body_young, .poisson = of.poisson}, 0.5);
  config.damping = damping_of_ratio(body_ratio);
  auto body = std::make_unique<MovingBody>(
      config, Environment{.gravity = {0, 0, -9.81}, .holds = {{.box = shape.held(of.cells)}}}, threads);
  for (const std::ptrdiff_t site : body->body.sites()) {
    const Vec3 x = body->body.rest_position(site);
    body->start.v.set(site, Vec3(0, 0.5 * (x[2] - 0.5), -x[0]));
  }
  body->system.constrain(0, body->start.x, body->start.v);
  return body;
}

/// Those whose table is committed, and small ones.
std::vector<StepBody> known_bodies(bool quick) {
  if (quick) return {{"box", 8}, {"ball", 8}};
  std::vector<StepBody> all;
  for (const double poisson : {0.3, 0.45})
    for (const Shape& shape : all_shapes()) all.push_back({shape.name, 20, poisson});
  all.insert(all.begin() + std::ptrdiff_t(all_shapes().size()), {"missing_corner", 40});
  return all;
}

constexpr std::array taken_scenes{"held_box_stiff_damped", "bracket_medium", "ball_medium",
                                  "slope_stiff_damped"};

StepScene scene_of_case(const BenchCase& which, int cells) {
  constexpr double poisson = 0.3;
  return {which.name(), which.description(cells), poisson, [which, cells](int threads) {
            return std::make_unique<BenchBody>(find_bench_scene(which.scene), cells,
                                               BenchMaterial{which.young, damping_of_ratio(which.ratio)},
                                               threads);
          }};
}

/// A frame that is to be solved, and its solution.
struct SolvedFrame {
  State<double> start;
  Field<double> x;   ///< where the converged step ends
  double scale = 0;  ///< the largest displacement in a frame until then [m]
};

/// The step of a solver, stopped after so many iterations; 0: converged.
std::unique_ptr<Integrator<double>> step_of(const SolverPair& solver, int iterations) {
  IntegratorOptions options{.dt = frame, .iterations = iterations};
  if (!solver.nonlinear.empty()) options.nonlinear_solver = solver.nonlinear;
  if (!solver.linear.empty()) options.linear_solver = solver.linear;
  return find_integrator(solver.method).make<double>(options);
}

/// A scene with the converged steps of its frames.
class StepProblem {
 public:
  StepProblem(const StepScene& scene, int frames, int threads) : scene_(scene), body_(scene.make(threads)) {
    const auto converged = step_of({.nonlinear = "lbfgs"}, 0);
    State<double> state = body_->start;
    double largest = 0;
    for (int f = 0; f < frames; ++f) {
      SolvedFrame next{.start = state, .x = {}};
      Work work;
      status_ = converged->advance(body_->system, state, state.t + frame, work);
      if (status_ != Status::ok) break;
      largest = std::max(largest, distance(state.x, next.start.x));
      next.x = state.x;
      next.scale = largest;
      frames_.push_back(std::move(next));
    }
  }

  const StepScene& scene() const { return scene_; }
  BodySystem<double>& system() { return body_->system; }
  const Body& body() const { return body_->body; }
  const State<double>& rest() const { return body_->start; }
  const std::vector<SolvedFrame>& frames() const { return frames_; }
  Status status() const { return status_; }
  double explicit_step() const {
    return safe_share * stable_step(find_integrator("semi_implicit_euler"), body_->system.spectral_bound());
  }

  double error(const SolvedFrame& f, const Field<double>& x) const { return distance(x, f.x) / f.scale; }

  /// Of Newton's method, in the last frame.
  std::pair<double, Status> difference_from_newton() const {
    State<double> state = frames_.back().start;
    Work work;
    const Status status =
        step_of({"newton", "multigrid"}, 0)->advance(body_->system, state, state.t + frame, work);
    return {status == Status::ok ? error(frames_.back(), state.x) : no_value, status};
  }

 private:
  double distance(const Field<double>& a, const Field<double>& b) const {
    double sum = 0;
    for (const std::ptrdiff_t site : body().sites())
      sum += body().mass(site) * (a.at(site) - b.at(site)).squaredNorm();
    return std::sqrt(sum / body().total_mass());
  }

  const StepScene& scene_;
  std::unique_ptr<MovingBody> body_;
  std::vector<SolvedFrame> frames_;
  Status status_ = Status::ok;
};

/// What so many iterations leave, frame by frame.
struct StoppedSteps {
  int iterations;
  std::vector<double> errors = {}, seconds = {};
  std::string status = "ok";  ///< of the last frame that was not

  double worst() const { return errors.empty() ? no_value : *std::max_element(errors.begin(), errors.end()); }
};

StoppedSteps stopped_after(StepProblem& p, const SolverPair& solver, int iterations) {
  StoppedSteps steps{iterations};
  try {
    const auto method = step_of(solver, iterations);
    for (const SolvedFrame& f : p.frames()) {
      State<double> state = f.start;
      Work work;
      Status status = Status::ok;
      steps.seconds.push_back(
          processor_seconds_of([&] { status = method->advance(p.system(), state, state.t + frame, work); }));
      if (status != Status::ok) steps.status = to_string(status);
      const double error = p.error(f, state.x);
      const bool has_answer = status == Status::ok || status == Status::newton_stalled;
      if (!has_answer || !std::isfinite(error)) {
        steps.errors.clear();
        if (has_answer) steps.status = to_string(Status::non_finite);
        break;
      }
      steps.errors.push_back(error);
    }
  } catch (const InputError& refused) {
    steps.status = fmt::format("refused: {}", refused.what());
  }
  return steps;
}

/// Until every frame is near enough; nothing if stopped.
std::optional<std::vector<StoppedSteps>> all_stopped(StepProblem& p, const SolverPair& solver,
                                                     const std::vector<int>& iterations,
                                                     const Progress& progress) {
  std::vector<StoppedSteps> all;
  for (const int k : iterations) {
    if (progress.stopped()) return std::nullopt;
    all.push_back(stopped_after(p, solver, k));
    if (all.back().worst() <= enough_error || all.back().seconds.empty()) break;
  }
  return all;
}

/// Iterations to an error, over frames; NaN if one frame does not come so near.
struct Needed {
  double mean = 0, most = 0;
};
Needed iterations_to(double error, const std::vector<StoppedSteps>& all, std::size_t frames) {
  Needed needed;
  for (std::size_t f = 0; f < frames; ++f) {
    const auto first = std::find_if(all.begin(), all.end(), [&](const StoppedSteps& steps) {
      return !steps.errors.empty() && steps.errors[f] <= error;
    });
    const double iterations = first == all.end() ? no_value : first->iterations;
    needed.mean += iterations;
    needed.most = std::isnan(iterations) ? no_value : std::max(needed.most, iterations);
  }
  if (std::isnan(needed.mean)) needed.most = no_value;
  needed.mean /= double(frames);
  return needed;
}

std::string outcome_of(const Needed& percent, const Needed& permille, const StoppedSteps& last) {
  if (last.errors.empty()) return last.status;
  if (std::isnan(percent.mean)) return fmt::format("above 1 percent after {} iterations", last.iterations);
  if (std::isnan(permille.mean)) return fmt::format("above 0.1 percent after {} iterations", last.iterations);
  return "ok";
}

/// Samples of one thing that is timed, in turn with the others.
struct Timed {
  std::function<double()> sample;  ///< seconds of one
  std::vector<double> seconds = {};
};

/// What solvers do, in explicit steps.
class StepCosts {
 public:
  explicit StepCosts(StepProblem& p) : p_(p), gradient_(p.system().size()), z_(p.system().size()) {
    const SolvedFrame& f = p.frames().back();
    p.system().force(f.start.t, f.start.x, f.start.v, gradient_);
    p.system().clear_prescribed(gradient_);
    for (const Cycle kind : {Cycle::v, Cycle::additive}) {
      cycles_.push_back(made(kind));
      cycles_.back()->place(f.start.x);
    }
    const double dt = p.explicit_step();
    const auto method = std::shared_ptr(find_integrator("semi_implicit_euler").make<double>({.dt = dt}));
    timed_.push_back({[this, dt, method] {
      constexpr int steps = 8;
      State<double> state = p_.rest();
      method->reset();
      Work work;
      return processor_seconds_of([&] { method->advance(p_.system(), state, steps * dt, work); }) / steps;
    }});
    for (std::size_t kind = 0; kind < 2; ++kind) {
      timed_.push_back({[this, kind] {
        constexpr int times = 4;
        return processor_seconds_of([&] {
                 for (int i = 0; i < times; ++i) cycles_[kind]->solve(gradient_, 1, {}, z_);
               }) /
               times;
      }});
      timed_.push_back({[this, kind] {
        return processor_seconds_of([&] { made(kind == 0 ? Cycle::v : Cycle::additive); });
      }});
    }
  }

  /// Adds a solver. An iteration is what a step of seven takes longer than one of two, over five.
  void add(const SolverPair& solver) {
    constexpr int from = 2, to = 7;
    const auto few = std::shared_ptr(step_of(solver, from)), more = std::shared_ptr(step_of(solver, to));
    const auto seconds = [this](Integrator<double>& method) {
      State<double> state = p_.frames().back().start;
      Work work;
      return processor_seconds_of([&] { method.advance(p_.system(), state, state.t + frame, work); });
    };
    seconds(*few), seconds(*more);  // sets them up
    timed_.push_back({[=] { return (seconds(*more) - seconds(*few)) / (to - from); }});
  }

  /// False if stopped.
  bool measure(int rounds, const Progress& progress) {
    return interleave(rounds, timed_.size(), progress,
                      [&](std::size_t i) { timed_[i].seconds.push_back(timed_[i].sample()); });
  }

  double step_seconds() const { return quartiles(timed_[0].seconds).median; }
  Quartiles application(Cycle kind) const { return over_step(kind == Cycle::v ? 1 : 3); }
  Quartiles set_up(Cycle kind) const { return over_step(kind == Cycle::v ? 2 : 4); }
  /// Of the solver that was added at that place.
  Quartiles iteration(std::size_t place) const { return over_step(5 + place); }

 private:
  std::unique_ptr<RestCycle> made(Cycle kind) {
    auto cycle = std::make_unique<RestCycle>(p_.system(), "mss convergence", kind);
    if (cycle->prepare({.mass = 1, .damping = frame, .stiffness = frame * frame}) != Status::ok)
      throw std::runtime_error("the preconditioner of " + p_.scene().name + " could not be prepared");
    return cycle;
  }
  Quartiles over_step(std::size_t i) const {
    return quartiles_of_ratio(timed_[i].seconds, timed_[0].seconds);
  }

  StepProblem& p_;
  Field<double> gradient_, z_;
  std::vector<std::unique_ptr<RestCycle>> cycles_;
  std::vector<Timed> timed_;
};

StepTables empty_steps() {
  return {Table({{"scene"},
                 {"solver"},
                 {"iterations"},
                 {"error"},
                 {"worst_error"},
                 {"seconds", "s"},
                 {"q1", "s"},
                 {"q3", "s"},
                 {"status"}}),
          Table({{"scene"},
                 {"poisson"},
                 {"particles"},
                 {"solver"},
                 {"iterations_to_1_percent"},
                 {"most_to_1_percent"},
                 {"iterations_to_1_permille"},
                 {"most_to_1_permille"},
                 {"application"},
                 {"iteration"},
                 {"iteration_q1"},
                 {"iteration_q3"},
                 {"set_up"},
                 {"explicit_step_seconds", "s"},
                 {"explicit_steps_per_frame"},
                 {"status"}}),
          Table({{"scene"},
                 {"particles"},
                 {"solver"},
                 {"iterations_to_1_percent"},
                 {"most_to_1_percent"},
                 {"seconds", "s"},
                 {"status"}}),
          Table({{"scene"},
                 {"description"},
                 {"particles"},
                 {"frames"},
                 {"explicit_steps_per_frame"},
                 {"uncertainty"},
                 {"status"}})};
}

void add_stopped(const StepProblem& p, const SolverPair& solver, const std::vector<StoppedSteps>& all,
                 Table& rows) {
  for (const StoppedSteps& steps : all) {
    const Quartiles time = quartiles(steps.seconds);
    rows.add({p.scene().name, solver.name(), steps.iterations, quartiles(steps.errors).median, steps.worst(),
              time.median, time.q1, time.q3, steps.status});
  }
}

void add_reference(StepProblem& p, Table& references) {
  double uncertainty = no_value;
  std::string status(to_string(p.status()));
  if (p.status() == Status::ok) {
    const auto [difference, newton] = p.difference_from_newton();
    uncertainty = difference;
    if (newton != Status::ok) status = fmt::format("Newton's method: {}", to_string(newton));
  } else {
    status = fmt::format("no converged step after {} frames: {}", p.frames().size(), status);
  }
  references.add({p.scene().name, p.scene().description, std::int64_t(p.body().particle_count()),
                  std::int64_t(p.frames().size()), std::ceil(frame / p.explicit_step()), uncertainty,
                  status});
}

/// False if stopped.
bool measure_body(const StepsConfig& config, StepProblem& p, StepTables& tables, const Progress& progress) {
  std::vector<std::vector<StoppedSteps>> stopped;
  StepCosts costs(p);
  for (const SolverPair& solver : config.bodies.solvers) {
    auto all = all_stopped(p, solver, config.bodies.iterations, progress);
    if (!all) return false;
    stopped.push_back(std::move(*all));
    costs.add(solver);
  }
  if (!costs.measure(config.rounds, progress)) return false;
  for (std::size_t i = 0; i < stopped.size(); ++i) {
    const SolverPair& solver = config.bodies.solvers[i];
    add_stopped(p, solver, stopped[i], tables.rows);
    const Cycle kind = solver.nonlinear == "additive_cg" ? Cycle::additive : Cycle::v;
    const Needed percent = iterations_to(percent_error, stopped[i], p.frames().size()),
                 permille = iterations_to(permille_error, stopped[i], p.frames().size());
    const Quartiles iteration = costs.iteration(i);
    tables.bodies.add({p.scene().name, p.scene().poisson, std::int64_t(p.body().particle_count()),
                       solver.name(), percent.mean, percent.most, permille.mean, permille.most,
                       costs.application(kind).median, iteration.median, iteration.q1, iteration.q3,
                       costs.set_up(kind).median, costs.step_seconds(), std::ceil(frame / p.explicit_step()),
                       outcome_of(percent, permille, stopped[i].back())});
  }
  return true;
}

/// False if stopped.
bool measure_scene(const StepsConfig& config, StepProblem& p, StepTables& tables, const Progress& progress) {
  for (const SolverPair& solver : config.scenes.solvers) {
    const auto all = all_stopped(p, solver, config.scenes.iterations, progress);
    if (!all) return false;
    add_stopped(p, solver, *all, tables.rows);
    const Needed percent = iterations_to(percent_error, *all, p.frames().size());
    const auto near = std::find_if(all->begin(), all->end(),
                                   [](const StoppedSteps& steps) { return steps.worst() <= percent_error; });
    tables.scenes.add({p.scene().name, std::int64_t(p.body().particle_count()), solver.name(), percent.mean,
                       percent.most, near == all->end() ? no_value : quartiles(near->seconds).median,
                       near == all->end() ? outcome_of({no_value, no_value}, percent, all->back()) : "ok"});
  }
  return true;
}

using MeasureSteps = bool(const StepsConfig&, StepProblem&, StepTables&, const Progress&);

void measure_group(const StepsConfig& config, const StepGroup& group, MeasureSteps& measure,
                   StepTables& tables, Progress& progress) {
  for (std::size_t i = 0; i < group.scenes.size() && tables.status == Status::ok; ++i) {
    progress.report(double(i) / double(group.scenes.size()), group.scenes[i].description);
    StepProblem problem(group.scenes[i], config.frames, config.threads);
    add_reference(problem, tables.references);
    if (progress.stopped() || (!problem.frames().empty() && !measure(config, problem, tables, progress)))
      tables.status = Status::interrupted;
  }
}

Json json_of(const StepGroup& group) {
  Json scenes = Json::object(), solvers = Json::array();
  for (const StepScene& scene : group.scenes) scenes[scene.name] = scene.description;
  for (const SolverPair& solver : group.solvers) solvers.push_back(solver.name());
  return {{"scenes", scenes}, {"solvers", solvers}, {"iterations", group.iterations}};
}

}  // namespace

std::string StepBody::name() const {
  return fmt::format("{}_{}", shape, cells) + (poisson == 0.3 ? "" : fmt::format("_nu{:g}", 100 * poisson));
}

StepScene StepBody::scene() const {
  return {name(),
          fmt::format("{}, {} cells a metre; E = {:g} MPa, nu = {:g}, damping ratio {:g}",
                      shape_of(shape).description, cells, body_young / 1e6, poisson, body_ratio),
          poisson, [body = *this](int threads) { return moving_body_of(body, threads); }};
}

StepsConfig steps_config(const ExperimentOptions& options) {
  StepsConfig config;
  for (const NonlinearSolverInfo& solver : nonlinear_solvers())
    if (solver.name != "newton") config.bodies.solvers.push_back({solver.name});
  config.bodies.iterations.resize(16);
  std::iota(config.bodies.iterations.begin(), config.bodies.iterations.end(), 1);
  for (const int further : {20, 24, 28, 32, 40, 60}) config.bodies.iterations.push_back(further);
  config.scenes.solvers = all_solvers();
  config.scenes.iterations = {1, 2, 3, 5, 10, 20, 50};
  const auto is_wanted = [&](const std::string& name, bool own_choice) {
    return options.scenes.empty() ? own_choice
                                  : std::count(options.scenes.begin(), options.scenes.end(), name) > 0;
  };
  for (const bool quick : {true, false})
    for (const StepBody& body : known_bodies(quick))
      if (is_wanted(body.name(), quick == options.quick)) config.bodies.scenes.push_back(body.scene());
  for (const BenchCase& which : bench_cases()) {
    const bool taken = std::count(taken_scenes.begin(), taken_scenes.end(), which.name()) > 0;
    constexpr int fewest = 4;  // cells across
    if (is_wanted(which.name(), taken))
      config.scenes.scenes.push_back(
          scene_of_case(which, options.quick ? fewest : find_bench_scene(which.scene).quick_cells));
  }
  return config;
}

std::vector<std::string> step_scene_names() {
  std::vector<std::string> names;
  for (const bool quick : {true, false})
    for (const StepBody& body : known_bodies(quick)) names.push_back(body.name());
  for (const std::string& name : bench_case_names()) names.push_back(name);
  return names;
}

StepTables measure_steps(const StepsConfig& config, Progress& progress) {
  StepTables tables = empty_steps();
  measure_group(config, config.bodies, measure_body, tables, progress);
  measure_group(config, config.scenes, measure_scene, tables, progress);
  return tables;
}

std::vector<NamedTable> step_files(const StepTables& tables) {
  return {{"convergence_bodies", tables.bodies},
          {"convergence_scenes", tables.scenes},
          {"convergence_steps", tables.rows},
          {"convergence_references", tables.references}};
}

Json step_configuration(const StepsConfig& config) {
  return {
      {"bodies", json_of(config.bodies)},
      {"scenes", json_of(config.scenes)},
      {"frames", config.frames},
      {"step", frame},
      {"converged", "lbfgs to its tolerance; uncertainty: the difference of Newton's method with multigrid"},
      {"rounds", config.rounds}};
}

}  // namespace mss::studies::convergence

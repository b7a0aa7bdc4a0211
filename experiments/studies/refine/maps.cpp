// Static problems in cells of several sizes: which cells are smaller, and what that saves.
#include "experiments/studies/refine/maps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "core/marking.hpp"
#include "core/refined_system.hpp"
#include "experiments/harness/measure.hpp"
#include "integrators/linear/linear_solver.hpp"
#include "integrators/modes.hpp"
#include "integrators/stable_step.hpp"

namespace mss::studies::refine {

namespace {

constexpr std::array<Map, 4> maps{Map::uniform, Map::by_hand, Map::estimated, Map::surface};
constexpr TangentSum stiffness{.stiffness = 1, .kind = Tangent::elastic};

/// From a box.
double distance(const Box& box, const Vec3& x) {
  return (box.lower - x).cwiseMax(x - box.upper).cwiseMax(0).norm();
}

LoadProblem patch_problem(const std::string& name, double edge) {
  const Box patch{{0.5 - edge / 2, 0.5 - edge / 2, 1}, {0.5 + edge / 2, 0.5 + edge / 2, 1}};
  return {.name = name,
          .description = fmt::format(
              "cube of 1 m on a held base, pressed in the middle of its top on {:g} x {:g} m", edge, edge),
          .shape = {.environment = {.holds = {{.box = {{0, 0, 0}, {1, 1, 0}}}}}},
          .patch = patch,
          .direction = -Vec3::UnitZ(),
          .distance = [patch](const Vec3& x) { return distance(patch, x); },
          .coarsest = 4,
          .finest = 64,
          .by_hand = {{4, 1}, {4, 2}, {4, 3}, {8, 3}, {8, 4}}};
}

LoadProblem without_load(const Problem& problem, const std::function<double(const Vec3&)>& distance,
                         const std::vector<std::pair<int, int>>& by_hand) {
  const Load load = problem.environment.loads.front();
  LoadProblem taken{.name = problem.name,
                    .description = problem.description,
                    .shape = problem,
                    .patch = load.box,
                    .direction = load.force.normalized(),
                    .distance = distance,
                    .by_hand = by_hand};
  taken.shape.environment.loads.clear();
  return taken;
}

/// A body that is solved: cells of one size have a system without what refinement needs.
struct Solid {
  Solid(const BodyConfig& config, const RefinementMap& map, const Environment& environment)
      : body(config, map) {
    if (body.levels().size() == 1)
      system = std::make_unique<SpringSystem<double>>(body.levels().front().body, environment, Execution{1});
    else
      system = std::make_unique<RefinedSystem<double>>(body, environment, Execution{1});
  }
  RefinedBody body;
  std::unique_ptr<SolidSystem<double>> system;
};

struct Solution {
  Status status = Status::ok;
  Field<double> displacement{};
  double value = no_value;    ///< the displacement under the load [m]
  double seconds = no_value;  ///< of the solution, its matrix included
};

Solution solve(Solid& solid, const LoadProblem& problem, const char* solver) {
  const State<double> rest = solid.system->undeformed_state();
  Field<double> load = traction(solid.body.levels(), problem.patch, problem.direction);
  solid.body.hand_over(load);
  Solution solved{.displacement = Field<double>(solid.system->size())};
  Work work;
  solved.seconds = seconds_of([&] {
    const auto linear = find_linear_solver(solver).make(1e-9);
    solved.status = linear->prepare(*solid.system, 0, rest.x, rest.v, stiffness, work);
    if (solved.status == Status::ok) solved.status = linear->solve(load, solved.displacement, work);
  });
  solved.value = 0;
  for (const std::ptrdiff_t site : solid.system->particles())
    solved.value += load.at(site).dot(solved.displacement.at(site));
  return solved;
}

/// Seconds of a step of Verlet's method; a step is short, so it is taken from as many as last long enough.
double seconds_per_step(System<double>& system, State<double> state, double sample_seconds) {
  const KickDrift verlet{.kick_before = 1e-6, .drift_new = 1e-6};
  const auto seconds_for = [&](long steps) {
    return seconds_of([&] { system.kick_drift(verlet, 1e-6, steps, state); });
  };
  const SampleLength length = sample_length(sample_seconds, seconds_for);
  std::vector<double> samples;
  for (int i = 0; i < 5; ++i) samples.push_back(seconds_for(length.steps) / double(length.steps));
  return *std::min_element(samples.begin(), samples.end());
}

/// Cells of a depth are split that are closer to what concentrates stress than two of them are long.
RefinementMap split_near(const BodyConfig& body, const std::function<double(const Vec3&)>& distance,
                         int levels) {
  RefinementMap map;
  constexpr double cells = 2;
  const auto split = [&](auto&& self, int depth, const RefinementMap::Cell& cell) -> void {
    const double edge = std::ldexp(body.cell_size, -depth);
    const Vec3 middle = body.origin + edge * (Vec3(cell[0], cell[1], cell[2]) + Vec3::Constant(0.5));
    if (depth == levels || distance(middle) > cells * edge) return;
    map.split(depth, cell);
    for (int c = 0; c < 8; ++c)
      self(self, depth + 1,
           {2 * cell[0] + (c & 1), 2 * cell[1] + ((c >> 1) & 1), 2 * cell[2] + ((c >> 2) & 1)});
  };
  for (int k = 0; k < body.voxels.nz(); ++k)
    for (int j = 0; j < body.voxels.ny(); ++j)
      for (int i = 0; i < body.voxels.nx(); ++i)
        if (body.voxels.at(i, j, k)) split(split, 0, {i, j, k});
  return map;
}

/// Cells with a face that no other cell has are split: two layers of smaller ones.
RefinementMap split_surface(const BodyConfig& body) {
  RefinementMap map;
  const VoxelGrid& voxels = body.voxels;
  for (int k = 0; k < voxels.nz(); ++k)
    for (int j = 0; j < voxels.ny(); ++j)
      for (int i = 0; i < voxels.nx(); ++i) {
        const bool inside = voxels.at(i - 1, j, k) && voxels.at(i + 1, j, k) && voxels.at(i, j - 1, k) &&
                            voxels.at(i, j + 1, k) && voxels.at(i, j, k - 1) && voxels.at(i, j, k + 1);
        if (voxels.at(i, j, k) && !inside) map.split(0, {i, j, k});
      }
  return map;
}

/// v in v + c h^p through three values at sizes each half of the one before.
double extrapolated(const std::vector<double>& values) {
  const double ratio = (values[1] - values[0]) / (values[2] - values[1]);
  return values[2] + (values[2] - values[1]) / (ratio - 1);
}

class Maps {
 public:
  Maps(const MapConfig& config, Progress& progress) : config_(config), progress_(progress) {}
  MapTables run();

 private:
  BodyConfig body(int n) const { return in_cells(problem_->shape, n, config_.material, config_.face_share); }
  void find_reference();
  void measure_uniform();
  void measure_by_hand();
  void measure_estimated();
  void measure_surface();
  Solution measure(Map map, int n, Solid& solid);
  bool goes_on(Map map, int n);
  bool fits(const RefinedBody& body) const { return body.sites().size() <= config_.most_particles; }

  const MapConfig& config_;
  Progress& progress_;
  const LoadProblem* problem_ = nullptr;
  double reference_ = no_value;
  double period_ = no_value;  ///< of the slowest vibration [s]
  MapTables tables_{.rows = Table({{"problem"},
                                   {"description"},
                                   {"map"},
                                   {"cells_per_metre"},
                                   {"levels"},
                                   {"particles"},
                                   {"value", "m"},
                                   {"reference", "m"},
                                   {"error"},
                                   {"static_seconds", "s"},
                                   {"step_seconds", "s"},
                                   {"steps_per_period"},
                                   {"period_seconds", "s"},
                                   {"local_period_seconds", "s"},
                                   {"status"}}),
                    .gains = Table({{"problem"}, {"map"}, {"error"}, {"quantity"}, {"gain"}, {"status"}})};
};

/// False if stopped.
bool Maps::goes_on(Map map, int n) {
  const auto at = double(problem_ - config_.problems.data());
  progress_.report(at / double(config_.problems.size()),
                   fmt::format("{}, {}, {} cells a metre", problem_->name, to_string(map), n));
  if (progress_.stopped()) tables_.status = Status::interrupted;
  return tables_.status == Status::ok;
}

/// And the period, of the middle one of the three sizes.
void Maps::find_reference() {
  std::vector<double> values;
  for (const int share : {4, 2, 1}) {
    const int n = problem_->finest / (share * config_.reference_coarsening);
    if (!goes_on(Map::uniform, n)) return;
    Solid solid(body(n), {}, problem_->shape.environment);
    values.push_back(solve(solid, *problem_, "automatic").value);
  }
  reference_ = extrapolated(values);
  Solid solid(body(problem_->coarsest), {}, problem_->shape.environment);
  Work work;
  const Modes modes = slowest_modes(*solid.system, solid.system->undeformed_state(), 1, work);
  period_ = modes.status == Status::ok ? 2 * std::numbers::pi / modes.modes.front().omega : no_value;
}

Solution Maps::measure(Map map, int n, Solid& solid) {
  const bool one_size = solid.body.levels().size() == 1;
  constexpr std::size_t most_factored = 1000;  // above, products are quicker
  const bool factored = solid.system->particles().size() <= most_factored;
  Solution solved = solve(solid, *problem_, one_size ? "automatic" : factored ? "cholmod" : "matrix_free");
  const IntegratorInfo& verlet = find_integrator("verlet");
  SolidSystem<double>& system = *solid.system;
  const double dt = safe_share * stable_step(verlet, system.spectral_bound()),
               local_dt = safe_share * stable_step(verlet, system.local_bound());
  const std::unique_ptr<System<double>> in_local_steps = system.with_local_steps(local_dt);
  const State<double> rest = system.undeformed_state();
  const double step = seconds_per_step(system, rest, config_.sample_seconds),
               local_step =
                   in_local_steps ? seconds_per_step(*in_local_steps, rest, config_.sample_seconds) : step;
  const bool ok = solved.status == Status::ok;
  tables_.rows.add({problem_->name, problem_->description, to_string(map), n,
                    solid.body.depth(solid.body.levels().size() - 1),
                    std::int64_t(solid.system->particles().size()), ok ? solved.value : no_value, reference_,
                    ok ? std::abs(solved.value / reference_ - 1) : no_value, solved.seconds, step,
                    period_ / dt, step * period_ / dt, local_step * period_ / local_dt,
                    std::string(to_string(solved.status))});
  return solved;
}

void Maps::measure_uniform() {
  for (const int n : config_.uniform_cells) {
    if (!goes_on(Map::uniform, n)) return;
    Solid solid(body(n), {}, problem_->shape.environment);
    if (solid.body.sites().size() <= config_.most_uniform) measure(Map::uniform, n, solid);
  }
}

void Maps::measure_by_hand() {
  for (const auto& [n, levels] : problem_->by_hand) {
    if (!goes_on(Map::by_hand, n)) return;
    Solid solid(body(n), split_near(body(n), problem_->distance, levels), problem_->shape.environment);
    if (!fits(solid.body)) return;
    measure(Map::by_hand, n, solid);
  }
}

void Maps::measure_estimated() {
  const int n = problem_->coarsest;
  auto solid = std::make_unique<Solid>(body(n), RefinementMap(), problem_->shape.environment);
  while (goes_on(Map::estimated, n)) {
    const Solution solved = measure(Map::estimated, n, *solid);
    if (solved.status != Status::ok) return;
    const RefinementMap next = split_by_estimate(solid->body, solved.displacement);
    solid = std::make_unique<Solid>(body(n), next, problem_->shape.environment);
    if (!fits(solid->body)) return;
  }
}

void Maps::measure_surface() {
  for (const int n : config_.uniform_cells) {
    if (n % 2 != 0 || !goes_on(Map::surface, n / 2)) continue;
    Solid solid(body(n / 2), split_surface(body(n / 2)), problem_->shape.environment);
    if (solid.body.levels().size() > 1) measure(Map::surface, n / 2, solid);
  }
}

/// What x a curve has at an error, by interpolation of the logarithms between its points of falling error;
/// NaN where it has none.
double at_error(const Table& rows, const std::string& column, double error) {
  double least = no_value;
  for (std::size_t r = 0; r + 1 < rows.size(); ++r) {
    const double before = rows.number(r, "error"), after = rows.number(r + 1, "error");
    if (!(before >= error && error >= after) || before == after) continue;
    const double share = std::log(before / error) / std::log(before / after);
    const double x = std::exp((1 - share) * std::log(rows.number(r, column)) +
                              share * std::log(rows.number(r + 1, column)));
    least = std::fmin(least, x);
  }
  return least;
}

void add_gains(const Table& rows, Table& gains) {
  constexpr std::array<double, 4> errors{0.1, 0.05, 0.02, 0.01};
  constexpr std::array<const char*, 4> quantities{"particles", "static_seconds", "period_seconds",
                                                  "local_period_seconds"};
  for (const std::string& problem : rows.distinct("problem")) {
    const Table of_problem = rows.where("problem", problem);
    const Table uniform = of_problem.where("map", to_string(Map::uniform));
    for (const Map map : {Map::by_hand, Map::estimated, Map::surface})
      for (const double error : errors)
        for (const char* quantity : quantities) {
          const double gain = at_error(uniform, quantity, error) /
                              at_error(of_problem.where("map", to_string(map)), quantity, error);
          gains.add({problem, to_string(map), error, std::string(quantity), gain,
                     std::string(std::isfinite(gain) ? "ok" : "error not passed")});
        }
  }
}

MapTables Maps::run() {
  for (const LoadProblem& problem : config_.problems) {
    problem_ = &problem;
    find_reference();
    measure_uniform();
    measure_by_hand();
    measure_estimated();
    measure_surface();
    if (tables_.status != Status::ok) break;
  }
  add_gains(tables_.rows, tables_.gains);
  return std::move(tables_);
}

/// The integral of (1 - s, s) over what [lower, upper] covers of [0, 1].
std::array<double, 2> linear_weights(double lower, double upper) {
  const double a = std::clamp(lower, 0.0, 1.0), b = std::clamp(upper, 0.0, 1.0);
  const double second = (b * b - a * a) / 2;
  return {b - a - second, second};
}

}  // namespace

const std::string& to_string(Map map) {
  static const std::array<std::string, 4> names{"uniform", "by hand", "estimated", "surface layers"};
  return names[std::size_t(map)];
}

Field<double> traction(const std::vector<Level>& levels, const Box& patch, const Vec3& direction) {
  Field<double> force(levels.back().first + levels.back().body.lattice().size);
  int normal = 0;
  while (patch.lower[normal] != patch.upper[normal]) ++normal;
  const int u = (normal + 1) % 3, w = (normal + 2) % 3;
  double area = 0;
  for (const Level& level : levels) {
    const double h = level.body.config().cell_size;
    level.body.for_each_cell([&](std::ptrdiff_t cell) {
      const Vec3 lower = level.body.rest_position(cell);
      const double layer = (patch.lower[normal] - lower[normal]) / h;
      if (std::abs(layer - 1) > 1e-9 && std::abs(layer) > 1e-9) return;
      const int side = int(std::lround(layer)) << normal;
      const auto along = [&](int axis) {
        return linear_weights((patch.lower[axis] - lower[axis]) / h, (patch.upper[axis] - lower[axis]) / h);
      };
      const std::array<double, 2> of_u = along(u), of_w = along(w);
      for (std::size_t c = 0; c < 4; ++c) {
        const double share = h * h * of_u[c & 1] * of_w[c >> 1];
        const std::ptrdiff_t site =
            level.first + cell + level.body.lattice().corner(side + (int(c & 1) << u) + (int(c >> 1) << w));
        force.set(site, force.at(site) + share * direction);
        area += share;
      }
    });
  }
  if (area == 0) throw InputError("the load's box covers no face of a cell");
  force.array() /= area;
  return force;
}

std::vector<LoadProblem> load_problems() {
  const auto from_edge = [](const Vec3& x) { return std::hypot(x[0] - 1, x[2] - 1); };
  const auto from_clamp = [](const Vec3& x) { return x[0]; };
  return {patch_problem("patch of a quarter", 0.25), patch_problem("patch of an eighth", 0.125),
          without_load(bracket(), from_edge, {{2, 1}, {4, 1}, {4, 2}, {8, 1}, {8, 2}, {12, 2}, {16, 2}}),
          without_load(beam(), from_clamp, {{2, 1}, {4, 1}, {8, 1}, {12, 1}})};
}

MapConfig map_config(const ExperimentOptions& options) {
  MapConfig config{.problems = load_problems()};
  config.uniform_cells =
      options.quick ? std::vector{1, 2, 4, 6} : std::vector{1, 2, 3, 4, 6, 8, 10, 12, 16, 20, 24, 32};
  config.reference_coarsening = options.quick ? 4 : 1;
  config.most_uniform = options.quick ? 2000 : 80000;
  config.most_particles = options.quick ? 1000 : 30000;
  config.sample_seconds = options.quick ? 0.005 : 0.05;
  return config;
}

MapTables measure_maps(const MapConfig& config, Progress& progress) { return Maps(config, progress).run(); }

}  // namespace mss::studies::refine

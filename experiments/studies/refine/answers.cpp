// What bodies in cells of one size or of several say to the problems of `mss refine`.
#include "experiments/studies/refine/answers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/error.hpp"
#include "core/refinement/refined_system.hpp"
#include "experiments/harness/measure.hpp"
#include "integrators/analysis/modes.hpp"
#include "integrators/analysis/stable_step.hpp"
#include "integrators/linear/linear_solver.hpp"

namespace mss::studies::refine {

namespace {

constexpr TangentCoefficients stiffness{.stiffness = 1, .kind = Tangent::elastic};

/// The fastest that takes the body: multigrid takes cells of one size alone.
const char* static_solver(const Solid& solid) {
  constexpr std::size_t most_factored = 1000;  // above, products are quicker
  if (solid.body.levels().size() == 1) return "automatic";
  return solid.system->particles().size() <= most_factored ? "cholmod" : "matrix_free";
}

/// A force of size 1, as the particles that move have it.
Field<double> load_on(const Solid& solid, const Box& patch, const Vec3& direction) {
  Field<double> load = traction(solid.body.levels(), patch, direction);
  solid.body.scatter_to_masters(load);
  return load;
}

Answer displacement_at_rest(Solid& solid, const MapProblem& problem) {
  const State<double> rest = solid.system->undeformed_state();
  Answer answer{.displacement = Field<double>(solid.system->size())};
  Work work;
  const auto linear = find_linear_solver(static_solver(solid)).make(1e-9);
  const auto solve = [&](const Field<double>& load, Field<double>& u) {
    if (answer.status == Status::ok) answer.status = linear->solve(load, u, work);
  };
  answer.status = linear->prepare(*solid.system, 0, rest.x, rest.v, stiffness, work);
  Field<double> weight = load_on(solid, problem.patch, problem.direction);
  solve(weight, answer.displacement);
  if (problem.looked_at) {
    weight = load_on(solid, *problem.looked_at, problem.looked_along);
    answer.dual.emplace(solid.system->size());
    solve(weight, *answer.dual);
  }
  answer.value = 0;
  for (const std::ptrdiff_t site : solid.system->particles())
    answer.value += weight.at(site).dot(answer.displacement.at(site));
  return answer;
}

/// How far the centre of mass has gone along a direction, and how fast it goes.
struct Advance {
  double way = 0, speed = 0;
};

Advance along(const Solid& solid, const State<double>& state, const Vec3& direction) {
  Advance sum;
  for (const std::ptrdiff_t site : solid.system->particles()) {
    const double mass = solid.system->mass(site);
    sum.way += mass * direction.dot(state.x.at(site) - solid.system->rest_position(site));
    sum.speed += mass * direction.dot(state.v.at(site));
  }
  const double mass = solid.system->total_mass();
  return {sum.way / mass, sum.speed / mass};
}

/// Verlet's method in safe steps until the centre of mass turns back; the deformation is the one then.
Answer deepest_point(Solid& solid, const MapProblem& problem) {
  constexpr long most_steps = 1000000;
  SolidSystem<double>& system = *solid.system;
  const IntegratorInfo& verlet = find_integrator("verlet");
  const double dt = safe_share * stable_step(verlet, system.spectral_bound());
  const std::unique_ptr<Integrator<double>> method = verlet.make<double>({.dt = dt});
  State<double> state = system.undeformed_state();
  for (const std::ptrdiff_t site : system.particles()) state.v.set(site, problem.speed * problem.direction);
  Answer answer{.displacement = Field<double>(system.size()), .value = 0};
  Work work;
  Advance now{0, problem.speed};
  while (now.speed > 0 && work.steps < most_steps && answer.status == Status::ok) {
    answer.status = method->advance(system, state, state.t + dt, work);
    now = along(solid, state, problem.direction);
    answer.value = std::max(answer.value, now.way);
  }
  if (answer.status == Status::ok && now.speed > 0) answer.status = Status::step_limit;
  for (const std::ptrdiff_t site : system.particles())
    answer.displacement.set(site,
                            state.x.at(site) - system.rest_position(site) - now.way * problem.direction);
  return answer;
}

/// The integral of (1 - s, s) over what [lower, upper] covers of [0, 1].
std::array<double, 2> linear_weights(double lower, double upper) {
  const double a = std::clamp(lower, 0.0, 1.0), b = std::clamp(upper, 0.0, 1.0);
  const double second = (b * b - a * a) / 2;
  return {b - a - second, second};
}

}  // namespace

Solid::Solid(const BodyConfig& config, const RefinementMap& map, const Environment& environment)
    : body(config, map), system(make_solid_system<double>(body, environment, {.threads = 1})) {}

std::string to_string(Quantity quantity) {
  switch (quantity) {
    case Quantity::displacement:
      return "displacement [m]";
    case Quantity::frequency:
      return "frequency [Hz]";
    case Quantity::impact:
      return "way of the centre [m]";
  }
  return {};
}

Answer answer(Solid& solid, const MapProblem& problem) {
  const Stopwatch watch;
  Answer found = [&] {
    switch (problem.quantity) {
      case Quantity::displacement:
        return displacement_at_rest(solid, problem);
      case Quantity::frequency:
        return slowest_vibration(solid);
      case Quantity::impact:
        return deepest_point(solid, problem);
    }
    return Answer{};
  }();
  found.seconds = watch.seconds();
  return found;
}

Answer slowest_vibration(Solid& solid) {
  Work work;
  constexpr int rigid_motions = 6;
  const bool is_free = unknowns_of(*solid.system).size() == 3 * solid.system->particles().size();
  const int count = is_free ? rigid_motions + 1 : 1;
  Modes modes = slowest_modes(*solid.system, solid.system->undeformed_state(), count, work);
  if (modes.status != Status::ok) return {.status = modes.status};
  Mode& mode = modes.modes.back();
  const double frequency = mode.omega / (2 * std::numbers::pi);
  return {.displacement = std::move(mode.shape), .value = frequency, .period = 1 / frequency};
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

}  // namespace mss::studies::refine

// Problems that cells of several sizes are tried on.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiments/studies/refine/maps.hpp"

namespace mss::studies::refine {

namespace {

/// From the outline of a flat box, where the stress of what is pressed has no bound.
double distance_from_outline(const Box& box, const Vec3& x) {
  const Vec3 outside = (box.lower - x).cwiseMax(x - box.upper);
  const double across = std::max(outside[0], outside[1]);
  const double along = across > 0 ? outside.head<2>().cwiseMax(0).norm() : -across;
  return std::hypot(along, outside[2]);
}

MapProblem patch_problem(const std::string& name, double edge) {
  const Box patch{{0.5 - edge / 2, 0.5 - edge / 2, 1}, {0.5 + edge / 2, 0.5 + edge / 2, 1}};
  return {.name = name,
          .description = fmt::format(
              "cube of 1 m on a held base, pressed in the middle of its top on {:g} x {:g} m", edge, edge),
          .shape = {.environment = {.holds = {{.box = {{0, 0, 0}, {1, 1, 0}}}}}},
          .patch = patch,
          .direction = -Vec3::UnitZ(),
          .distance = [patch](const Vec3& x) { return distance_from_outline(patch, x); },
          .coarsest = 4,
          .finest = 64,
          .by_hand = {{4, 1}, {4, 2}, {4, 3}, {8, 2}, {8, 3}, {16, 3}}};
}

MapProblem without_load(const Problem& problem, const std::function<double(const Vec3&)>& distance,
                        const std::vector<std::pair<int, int>>& by_hand) {
  const Load load = problem.environment.loads.front();
  MapProblem taken{.name = problem.name,
                   .description = problem.description,
                   .shape = problem,
                   .patch = load.box,
                   .direction = load.force.normalized(),
                   .distance = distance,
                   .by_hand = by_hand};
  taken.shape.environment.loads.clear();
  return taken;
}

/// A displacement where hardly anything of the load arrives.
MapProblem far_from_load() {
  const Problem problem = far_goal();
  MapProblem far = without_load(problem, [](const Vec3& x) { return std::hypot(x[0] - 1, x[2] - 1); },
                                {{2, 1}, {4, 1}, {8, 1}});
  far.looked_at = problem.goal;
  far.looked_along = problem.direction;
  return far;
}

/// On a held part of its base, whose outline concentrates stress.
MapProblem vibration_on_pedestal() {
  const Box pedestal{{0.25, 0.25, 0}, {0.75, 0.75, 0}};
  return {.name = "vibration on a pedestal",
          .description = "cube of 1 m held by 0.5 x 0.5 m of its base: its lowest frequency",
          .quantity = Quantity::frequency,
          .shape = {.environment = {.holds = {{.box = pedestal}}}},
          .distance = [pedestal](const Vec3& x) { return distance_from_outline(pedestal, x); },
          .multiple = 4,  // so that the pedestal is as wide as it should be
          .coarsest = 4,
          .finest = 32,
          .most_particles = 8000,
          .by_hand = {{4, 1}, {4, 2}, {8, 1}, {8, 2}}};
}

MapProblem vibration_of_beam() {
  Problem shape = beam();
  shape.environment.loads.clear();
  return {.name = "vibration of the beam",
          .description = "cantilever 4 x 1 x 1 m, its end clamped: its lowest frequency",
          .quantity = Quantity::frequency,
          .shape = shape,
          .distance = [](const Vec3& x) { return x[0]; },
          .coarsest = 2,
          .finest = 16,
          .most_particles = 8000,
          .by_hand = {{2, 1}, {4, 1}, {8, 1}}};
}

/// Stress concentrates where the foot begins. Corners and edges would be no problem for small deformations:
/// contact there has the same strains at every size.
MapProblem landing_on_foot() {
  const Box joint{{0.25, 0.25, 0.25}, {0.75, 0.75, 0.25}};
  Problem shape{.size = {1, 1, 1.25}, .filled = [](const Vec3& x) {
                  return x[2] > 0.25 || (std::abs(x[0] - 0.5) < 0.25 && std::abs(x[1] - 0.5) < 0.25);
                }};
  shape.environment.planes = {{.contact = ContactLaw::penalty, .restitution = 1, .friction = 0}};
  return {.name = "landing on a foot",
          .description =
              "cube of 1 m landing at 0.1 m/s on a foot of 0.5 x 0.5 x 0.25 m: how far its centre sinks",
          .quantity = Quantity::impact,
          .shape = shape,
          .direction = -Vec3::UnitZ(),
          .speed = 0.1,
          .distance = [joint](const Vec3& x) { return std::min(distance_from_outline(joint, x), x[2]); },
          .multiple = 4,
          .coarsest = 4,
          .finest = 32,
          .most_particles = 12000,
          .by_hand = {{4, 1}, {4, 2}, {4, 3}}};
}

}  // namespace

std::vector<MapProblem> map_problems() {
  const auto from_edge = [](const Vec3& x) { return std::hypot(x[0] - 1, x[2] - 1); };
  const auto from_clamp = [](const Vec3& x) { return x[0]; };
  return {patch_problem("patch of a quarter", 0.25),
          patch_problem("patch of an eighth", 0.125),
          without_load(bracket(), from_edge, {{2, 1}, {4, 1}, {4, 2}, {8, 1}, {8, 2}, {12, 2}, {16, 2}}),
          without_load(beam(), from_clamp, {{2, 1}, {4, 1}, {8, 1}, {12, 1}}),
          far_from_load(),
          vibration_on_pedestal(),
          vibration_of_beam(),
          landing_on_foot()};
}

}  // namespace mss::studies::refine

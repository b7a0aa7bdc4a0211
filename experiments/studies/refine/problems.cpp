#include "experiments/studies/refine/problems.hpp"

#include <cmath>

namespace mss::studies::refine {

Problem beam() {
  const Vec3 size(4, 1, 1);
  const Box end{{size[0], 0, 0}, size};
  return {.name = "beam",
          .description = "cantilever 4 x 1 x 1 m, its end clamped, sheared at its tip",
          .size = size,
          .environment = {.holds = {{.box = {{0, 0, 0}, {0, 1, 1}}}},
                          .loads = {{.box = end, .force = {0, 0, total_load}}}},
          .goal = end};
}

Problem bracket() {
  const Vec3 size(3, 1, 3);
  const Box end{{3, 0, 0}, {3, 1, 1}};
  return {.name = "bracket",
          .description = "L of 3 x 1 x 3 m, its arms 1 m thick, clamped on top, pulled down at its end",
          .size = size,
          .filled = [](const Vec3& x) { return x[0] < 1 || x[2] < 1; },
          .environment = {.holds = {{.box = {{0, 0, 3}, {1, 1, 3}}}},
                          .loads = {{.box = end, .force = {0, 0, -total_load}}}},
          .goal = end,
          .direction = -Vec3::UnitZ()};
}

Problem far_goal() {
  const Vec3 size(4, 1, 1);
  return {.name = "far goal",
          .description = "block 4 x 1 x 1 m glued to the floor, pressed at one end, its other end looked at",
          .size = size,
          .environment = {.holds = {{.box = {{0, 0, 0}, {4, 1, 0}}}},
                          .loads = {{.box = {{0, 0, 1}, {1, 1, 1}}, .force = {0, 0, -total_load}}}},
          .goal = {{4, 0, 0.5}, {4, 1, 1}},
          .direction = Vec3::UnitX(),
          .at_the_load = false};
}

std::vector<Problem> problems() { return {beam(), bracket(), far_goal()}; }

BodyConfig in_cells(const Problem& problem, int n, const ElasticConstants& material, double face_share) {
  const auto count = [&](int axis) { return int(std::lround(problem.size[axis] * n)); };
  VoxelGrid cells = VoxelGrid::box(count(0), count(1), count(2));
  if (problem.filled)
    for (int k = 0; k < cells.nz(); ++k)
      for (int j = 0; j < cells.ny(); ++j)
        for (int i = 0; i < cells.nx(); ++i)
          cells.set(i, j, k, problem.filled(Vec3(i + 0.5, j + 0.5, k + 0.5) / n));
  BodyConfig body{.voxels = cells, .cell_size = 1.0 / n};
  body.fill(material, face_share);
  return body;
}

}  // namespace mss::studies::refine

#include "core/scene/scene_edit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/error.hpp"

namespace mss {

namespace {

void change_cells(Scene& scene, int level) {
  const int before = level_of(scene);
  if (level == before) return;
  BodyConfig& body = scene.body;
  double sites = 1;
  for (const int count : body.voxels.size()) sites *= double(count) / before * level + 1;
  if (sites > most_sites())
    throw InputError(
        fmt::format("{}: cells of {:.4g} m make a lattice of {:.0f} million particles; at most "
                    "{:.0f} million fit",
                    scene.file.string(), body.cell_size * before / level, sites / 1e6, most_sites() / 1e6));
  if (scene.mesh) {
    scene.mesh->config.cell_size = body.cell_size * before / level;
    fill_cells(*scene.mesh, body);
  } else {
    resample(body, before, level);
    body.cell_size = body.cell_size * before / level;
  }
  scene.refine = scene.voxel_file.empty() ? 1 : level;
}

/// For the same moduli: k goes with h in a solid, not at all in a sheet, and with 1/h in a rope.
SpringConstants scaled(const SpringConstants& k, const BodyConfig& body, double finer) {
  const double parts = std::pow(finer, body.voxels.dimensions() - 2);
  return {.edge = k.edge / parts, .face = k.face / parts, .body = k.body / parts, .volume = k.volume};
}

/// Of parts beside part 0 nothing is edited but what other cells and springs change.
void change_part(Part& part, const SceneEdit& edit, const BodyConfig& body, double finer) {
  part.springs =
      part.elastic ? body.calibrated(*part.elastic, edit.face_share) : scaled(part.springs, body, finer);
  if (!edit.volume_force) part.springs.volume = 0;
  if (part.damping.law == Damping::Law::ratio) part.damping.zeta *= finer;
}

}  // namespace

SceneEdit edit_of(const Scene& scene) {
  const BodyConfig& body = scene.body;
  const SolveConfig& solve = scene.solve;
  return {.level = level_of(scene),
          .model = scene.model,
          .elastic = body.elastic,
          .springs = body.springs,
          .face_share = scene.face_share,
          .volume_force = scene.volume_force,
          .topology = body.topology,
          .sharing = body.sharing,
          .damping = body.damping,
          .integrator = solve.integrator,
          .dt = solve.dt,
          .precision = solve.precision,
          .linear_solver = solve.linear_solver,
          .tolerance = solve.tolerance,
          .threads = solve.threads,
          .device = solve.device};
}

int level_of(const Scene& scene) {
  if (!scene.voxel_file.empty()) return scene.refine;
  if (scene.mesh) return std::max(1, int(std::lround(scene.mesh->longest_extent() / scene.body.cell_size)));
  const std::array<int, 3> cells = scene.body.voxels.size();
  return std::gcd(cells[0], std::gcd(cells[1], cells[2]));
}

Scene edited(Scene scene, const SceneEdit& edit) {
  const int before = level_of(scene);
  const double finer = double(edit.level) / before;
  change_cells(scene, edit.level);
  BodyConfig& body = scene.body;
  scene.model = edit.model;
  body.elastic = edit.elastic;
  scene.face_share = edit.face_share;
  scene.volume_force = edit.volume_force;
  if (edit.elastic)
    body.fill(*edit.elastic, edit.face_share);
  else
    body.springs = scaled(edit.springs, body, finer);
  if (!edit.volume_force) body.springs.volume = 0;
  for (Part& part : body.parts) change_part(part, edit, body, finer);
  body.topology = edit.topology;
  body.sharing = edit.sharing;
  body.damping = edit.damping;
  if (body.damping.law == Damping::Law::ratio) body.damping.zeta *= finer;
  scene.solve.integrator = edit.integrator;
  scene.solve.dt = edit.dt;
  scene.solve.precision = edit.precision;
  scene.solve.linear_solver = edit.linear_solver;
  scene.solve.tolerance = edit.tolerance;
  scene.solve.threads = edit.threads;
  scene.solve.device = edit.device;
  if (edit.level != before) check_boxes(scene);
  scene.warnings = scene_warnings(scene);
  return scene;
}

}  // namespace mss

// Which smaller cells a scene at rest needs only in places.
#include "experiments/advise/static_maps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/scene/scene_edit.hpp"
#include "experiments/harness/measure.hpp"
#include "experiments/simulation/scene_check.hpp"

namespace mss::advise {

namespace {

constexpr int most_levels = 3;

bool is_in(const Box& box, const Vec3& x, double margin) {
  return ((x - box.lower).array() >= -margin).all() && ((x - box.upper).array() <= margin).all();
}

/// Of the particles that move in the box of the displacement in [expect], along an axis.
double mean_displacement_of(const Scene& scene, const std::vector<ParticleRecord>& particles, int axis) {
  double sum = 0;
  int count = 0;
  for (const Expectation& e : scene.expectations) {
    if (e.quantity != mean_displacement) continue;
    const double margin = 1e-9 * scene.body.cell_size;
    for (const ParticleRecord& p : particles) {
      if (!is_in(e.box, p.rest, margin)) continue;
      sum += (p.x - p.rest)[axis];
      ++count;
    }
  }
  return sum / count;
}

double value_of(const Scene& scene, const std::string& quantity, const SimulationResult& result) {
  if (quantity.starts_with("displacement"))
    return mean_displacement_of(scene, result.particles, quantity.back() - 'x');
  return result.series.back().elastic + result.series.back().volume_energy;
}

MapTried solve_map(Scene scene, const std::string& quantity, int levels, Progress& progress) {
  const bool of_energy = !quantity.starts_with("displacement");
  scene.auto_refinement = {
      .goal = of_energy ? AutoRefinement::Goal::energy : AutoRefinement::Goal::displacement,
      .levels = levels};
  MapTried tried{.cell_size = scene.body.cell_size, .levels = levels};
  SimulationResult result;
  tried.seconds = seconds_of([&] { result = simulate(scene, progress); });
  tried.status = result.status;
  tried.particles = result.particles.size();
  tried.boxes = extents_of_boxes(scene, result.particles);
  if (result.status == Status::ok) tried.value = value_of(scene, quantity, result);
  return tried;
}

}  // namespace

BoxExtents extents_of_boxes(const Scene& scene, const std::vector<ParticleRecord>& particles) {
  std::vector<Box> boxes;
  for (const Load& load : scene.environment.loads) boxes.push_back(load.box);
  for (const Hold& hold : scene.environment.holds) boxes.push_back(hold.box);
  for (const Expectation& e : scene.expectations)
    if (e.quantity == mean_displacement) boxes.push_back(e.box);
  BoxExtents extents(boxes.size());
  for (const ParticleRecord& p : particles)
    for (std::size_t i = 0; i < boxes.size(); ++i)
      if (is_in(boxes[i], p.rest, 1e-9 * scene.body.cell_size)) extents[i].extend(p.rest);
  return extents;
}

bool same_extents(const BoxExtents& a, const BoxExtents& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& one, const auto& other) { return one.isApprox(other, 1e-9); });
}

bool can_be_split(const Scene& scene) {
  Scene split = scene;
  split.auto_refinement.emplace();
  try {
    check_solve(split);
    RefinedBody(split.body, {});
  } catch (const InputError&) {
    return false;
  }
  return !scene.mesh && scene.model == spring_model;
}

std::vector<MapTried> try_maps(const Scene& scene, const std::string& quantity,
                               const std::vector<double>& cell_sizes, std::size_t most_particles,
                               Progress& progress) {
  std::vector<MapTried> tried;
  for (const double cell_size : cell_sizes) {
    SceneEdit edit = edit_of(scene);
    edit.level = int(std::lround(edit.level * scene.body.cell_size / cell_size));
    for (int levels = 1; levels <= most_levels && !progress.stopped(); ++levels) {
      progress.report(0,
                      fmt::format("cells of {:.4g} m, halved up to {} times in places", cell_size, levels));
      try {
        tried.push_back(solve_map(edited(scene, edit), quantity, levels, progress));
      } catch (const InputError&) {  // no equilibrium to choose cells by, or a hold of half a larger cell
        break;
      }
      if (tried.back().particles >= most_particles) break;
    }
  }
  return tried;
}

}  // namespace mss::advise

#include "experiments/view/bodies_surface.hpp"

#include <algorithm>

#include "core/base/field_part.hpp"
#include "experiments/view/surface_mesh.hpp"
#include "experiments/view/true_surface.hpp"

namespace mss::view {

BodiesSurface::BodiesSurface(const std::vector<Level>& levels,
                             std::vector<std::unique_ptr<DrawnSurface>> parts)
    : parts_(std::move(parts)) {
  for (const auto& [body, first] : levels) sites_of_.push_back({first, body.lattice().size});
  std::uint32_t vertices = 0;
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    first_triangle_.push_back(triangles_.size());
    for (const std::ptrdiff_t site : parts_[b]->sites()) sites_.push_back(sites_of_[b].first + site);
    for (const std::uint32_t corner : parts_[b]->triangles()) triangles_.push_back(vertices + corner);
    vertices += std::uint32_t(parts_[b]->vertices().size());
  }
  copy_vertices();
}

void BodiesSurface::copy_vertices() {
  vertices_.clear();
  for (const auto& part : parts_)
    vertices_.insert(vertices_.end(), part->vertices().begin(), part->vertices().end());
}

void BodiesSurface::update(const Field<double>& x, const std::vector<float>& values) {
  auto of_part = values.begin();
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    const auto end = of_part + std::ptrdiff_t(parts_[b]->sites().size());
    parts_[b]->update(part_of(x, sites_of_[b].first, sites_of_[b].count), std::vector<float>(of_part, end));
    of_part = end;
  }
  copy_vertices();
}

std::ptrdiff_t BodiesSurface::site_at(std::size_t triangle, const Vec3& point) const {
  const auto after = std::upper_bound(first_triangle_.begin(), first_triangle_.end(), triangle);
  const auto b = std::size_t(after - first_triangle_.begin()) - 1;
  return sites_of_[b].first + parts_[b]->particle_at(triangle - first_triangle_[b], point);
}

std::unique_ptr<DrawnSurface> surface_of_cells(const Scene& scene, const std::vector<Level>& levels) {
  if (scene.others.empty()) return std::make_unique<SurfaceMesh>(levels);
  std::vector<std::unique_ptr<DrawnSurface>> parts;
  for (const Level& level : levels) parts.push_back(std::make_unique<SurfaceMesh>(level.body));
  return std::make_unique<BodiesSurface>(levels, std::move(parts));
}

std::unique_ptr<DrawnSurface> surface_of_meshes(const Scene& scene, const std::vector<Level>& levels) {
  const std::vector<const SceneBody*> bodies = bodies_of(scene);
  std::vector<std::unique_ptr<DrawnSurface>> parts;
  for (std::size_t b = 0; b < bodies.size(); ++b)
    if (bodies[b]->mesh)
      parts.push_back(std::make_unique<TrueSurface>(bodies[b]->mesh->surface(), levels[b].body));
    else
      parts.push_back(std::make_unique<SurfaceMesh>(levels[b].body));
  if (parts.size() == 1) return std::move(parts.front());
  return std::make_unique<BodiesSurface>(levels, std::move(parts));
}

}  // namespace mss::view

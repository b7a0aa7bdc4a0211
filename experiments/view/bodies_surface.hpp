#pragma once

#include <memory>
#include <vector>

#include "core/body/body.hpp"
#include "core/scene/scene.hpp"
#include "experiments/view/drawn_surface.hpp"

namespace mss::view {

/// The surfaces of several bodies, each as if it were alone.
class BodiesSurface final : public DrawnSurface {
 public:
  /// One of each level's body.
  BodiesSurface(const std::vector<Level>& levels, std::vector<std::unique_ptr<DrawnSurface>> parts);

  void update(const Field<double>& x, const std::vector<float>& values) override;
  std::optional<Motion> motion() const override { return std::nullopt; }

 private:
  std::ptrdiff_t site_at(std::size_t triangle, const Vec3& point) const override;
  void copy_vertices();

  /// Where a body's sites are in fields of all bodies.
  struct Sites {
    std::ptrdiff_t first, count;
  };

  std::vector<Sites> sites_of_;  ///< by part
  std::vector<std::unique_ptr<DrawnSurface>> parts_;
  std::vector<std::size_t> first_triangle_;  ///< by part: its first index in triangles()
};

/// What is drawn of a scene's bodies: the faces of their cells, or the meshes where they were given as such.
std::unique_ptr<DrawnSurface> surface_of_cells(const Scene& scene, const std::vector<Level>& levels);
std::unique_ptr<DrawnSurface> surface_of_meshes(const Scene& scene, const std::vector<Level>& levels);

}  // namespace mss::view

#pragma once

#include "core/body/body.hpp"
#include "experiments/view/drawn_surface.hpp"

namespace mss::view {

/// The faces between cells and no cell, as triangles. Faces with the same normal at rest share vertices and
/// are shaded smoothly; edges between sides of the body stay sharp. A face is four triangles about its
/// centre: that treats its corners alike, and encloses with every other face exactly the volume of the
/// trilinear cells.
class SurfaceMesh final : public DrawnSurface {
 public:
  /// At rest; all values 0.
  explicit SurfaceMesh(const std::vector<Level>& levels);
  explicit SurfaceMesh(const Body& body) : SurfaceMesh(std::vector<Level>{{body}}) {}

  void update(const Field<double>& x, const std::vector<float>& values) override;

 private:
  using Face = std::array<std::uint32_t, 4>;  ///< vertices, counter-clockwise as seen from outside

  /// The nearest.
  std::ptrdiff_t site_at(std::size_t triangle, const Vec3& point) const override;
  void add_faces(const std::vector<Level>& levels, const Level& level);
  void add_triangles();
  std::uint32_t centre(std::size_t face) const { return std::uint32_t(corner_site_.size() + face); }

  std::vector<Face> faces_;
  std::vector<std::ptrdiff_t>
      corner_site_;  ///< per vertex that is a corner; the centres of faces come after them
  std::vector<std::size_t> corner_entry_;  ///< per such vertex: its place in sites()
};

}  // namespace mss::view

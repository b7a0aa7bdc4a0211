#pragma once

#include "core/body/body.hpp"
#include "experiments/view/drawn_surface.hpp"

namespace mss::view {

/// What a sheet or a rope is across, which its particles do not say: vectors from its middle to its sides.
class CrossSection {
 public:
  /// Of a body of fewer than three dimensions; drawn no thinner than its largest extent over 300.
  explicit CrossSection(const Body& body);
  /// Along the normal of a sheet, and across a rope as it is least turned from rest.
  void update(const Field<double>& x);
  /// From the particle at a site to the side that a corner of its cell is on along flat axes [m].
  Vec3 to_corner(std::ptrdiff_t site, int corner) const;

 private:
  Vec3 normal_of_sheet(std::ptrdiff_t site, int flat, const Field<double>& x) const;
  Vec3 tangent_of_rope(std::ptrdiff_t site, int along, const Field<double>& x) const;

  Body body_;
  double half_;                             ///< [m]
  std::array<std::vector<Vec3>, 3> sides_;  ///< by axis and particle, unit vectors; empty: not flat
};

/// The faces between cells and no cell, as triangles. Faces with the same normal at rest share vertices and
/// are shaded smoothly; edges between sides of the body stay sharp. A face is four triangles about its
/// centre: that treats its corners alike, and encloses with every other face exactly the volume of the
/// trilinear cells. Sheets and ropes are drawn as thick as they are.
class SurfaceMesh final : public DrawnSurface {
 public:
  /// At rest; all values 0.
  explicit SurfaceMesh(const std::vector<Level>& levels);
  explicit SurfaceMesh(const Body& body) : SurfaceMesh(std::vector<Level>{{body}}) {}

  void update(const Field<double>& x, const std::vector<float>& values) override;
  /// Of solids.
  std::optional<Motion> motion() const override;

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
  std::vector<int> corner_of_cell_;        ///< per such vertex: the corner of its cell
  std::optional<CrossSection> section_;    ///< of a sheet or a rope
};

}  // namespace mss::view

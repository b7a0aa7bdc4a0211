#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/body.hpp"

namespace mss::view {

/// A half-line from `origin` along the unit vector `direction`.
struct Ray {
  Vec3 origin;
  Vec3 direction;
};

/// A corner of triangles as the graphics card takes it.
struct SurfaceVertex {
  std::array<float, 3> position{};
  std::array<float, 3> normal{};  ///< unit, outward
  float value = 0;                ///< what the colour stands for
  std::array<float, 2> cells{};   ///< where on its side of the body, in cells: whole numbers on their edges
};

/// The faces between cells and no cell, as triangles. Faces with the same normal at rest share vertices and
/// are shaded smoothly; edges between sides of the body stay sharp. A face is four triangles about its
/// centre: that treats its corners alike, and encloses with every other face exactly the volume of the
/// trilinear cells.
class SurfaceMesh {
 public:
  /// At rest; all values 0.
  explicit SurfaceMesh(const Body& body);

  std::size_t face_count() const { return faces_.size(); }
  /// Particles on the surface, as lattice sites, ascending.
  const std::vector<std::ptrdiff_t>& sites() const { return sites_; }

  const std::vector<SurfaceVertex>& vertices() const { return vertices_; }
  /// Three vertices per triangle, counter-clockwise as seen from outside.
  const std::vector<std::uint32_t>& triangles() const { return triangles_; }

  /// Moves the particles to x [m] and gives those of sites() their values.
  void update(const Field<double>& x, const std::vector<float>& values);

  /// Volume that the triangles enclose, by the divergence theorem [m^3].
  double volume() const;

  struct Hit {
    std::ptrdiff_t site;  ///< the particle nearest to it, of the face that was hit
    double distance;      ///< along the ray [m]
  };
  /// Where a ray first meets the surface.
  std::optional<Hit> hit(const Ray& ray) const;

 private:
  using Face = std::array<std::uint32_t, 4>;  ///< vertices, counter-clockwise as seen from outside

  void add_faces(const Body& body);
  void add_triangles();
  std::uint32_t centre(std::size_t face) const { return std::uint32_t(corner_site_.size() + face); }
  Vec3 position(std::uint32_t vertex) const;

  std::vector<Face> faces_;
  std::vector<std::ptrdiff_t> sites_;
  std::vector<std::ptrdiff_t>
      corner_site_;  ///< per vertex that is a corner; the centres of faces come after them
  std::vector<std::size_t> corner_entry_;  ///< per such vertex: its place in sites_
  std::vector<SurfaceVertex> vertices_;
  std::vector<std::uint32_t> triangles_;
};

}  // namespace mss::view

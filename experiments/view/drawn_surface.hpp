#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/field.hpp"

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

/// Triangles that particles move, as they are drawn.
class DrawnSurface {
 public:
  DrawnSurface() = default;
  DrawnSurface(const DrawnSurface&) = delete;
  DrawnSurface& operator=(const DrawnSurface&) = delete;
  virtual ~DrawnSurface() = default;

  /// Moves the particles to x [m] and gives those of sites() their values.
  virtual void update(const Field<double>& x, const std::vector<float>& values) = 0;

  /// How particles alone move its vertices, at all times: what update() does, for others to do.
  struct Motion {
    struct Share {
      std::size_t entry;  ///< a place in sites(),
      double weight;      ///< and what of that particle's position and value the vertex has
    };
    std::vector<std::vector<Share>> shares{};  ///< by vertex
    /// Four vertices each, counter-clockwise; in triangles the last one twice.
    std::vector<std::array<std::uint32_t, 4>> faces{};
    std::vector<std::vector<std::uint32_t>>
        faces_at{};  ///< by vertex: those whose areas add up to its normal
  };
  /// Empty: they have more to do with it.
  virtual std::optional<Motion> motion() const = 0;

  /// Particles that move it, as lattice sites, ascending.
  const std::vector<std::ptrdiff_t>& sites() const { return sites_; }
  const std::vector<SurfaceVertex>& vertices() const { return vertices_; }
  /// Three vertices per triangle, counter-clockwise as seen from outside.
  const std::vector<std::uint32_t>& triangles() const { return triangles_; }

  /// Volume that the triangles enclose, by the divergence theorem [m^3].
  double volume() const;

  struct Hit {
    std::ptrdiff_t site;  ///< a particle at the triangle that was hit
    double distance;      ///< along the ray [m]
  };
  /// Where a ray first meets the surface.
  std::optional<Hit> hit(const Ray& ray) const;
  /// The particle of a triangle, by its first index in triangles(), that a point on it stands for.
  std::ptrdiff_t particle_at(std::size_t triangle, const Vec3& point) const {
    return site_at(triangle, point);
  }

 protected:
  /// As particle_at().
  virtual std::ptrdiff_t site_at(std::size_t triangle, const Vec3& point) const = 0;

  Vec3 position(std::uint32_t vertex) const;
  double distance(std::uint32_t vertex, const Vec3& point) const { return (position(vertex) - point).norm(); }
  /// Sets sites() to these, each once, and returns the place of each in it.
  std::vector<std::size_t> collect_sites(const std::vector<std::ptrdiff_t>& all);
  /// Makes sums of areas times normals unit normals.
  void normalise();

  std::vector<std::ptrdiff_t> sites_;
  std::vector<SurfaceVertex> vertices_;
  std::vector<std::uint32_t> triangles_;
};

std::array<float, 3> to_array(const Vec3& v);
void add(std::array<float, 3>& sum, const Vec3& v);

}  // namespace mss::view

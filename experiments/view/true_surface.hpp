#pragma once

#include "core/body/body.hpp"
#include "core/mesh/embedded_surface.hpp"
#include "experiments/view/drawn_surface.hpp"

namespace mss::view {

/// The mesh that a body was given as, carried by its cells. Where triangles meet at more than 60 degrees at
/// rest the edge is sharp: they do not share vertices.
class TrueSurface final : public DrawnSurface {
 public:
  /// At rest; all values 0.
  TrueSurface(const TriangleMesh& mesh, const Body& body);

  void update(const Field<double>& x, const std::vector<float>& values) override;
  std::optional<Motion> motion() const override;

 private:
  /// Of the corner nearest to the point, the particle with the largest weight.
  std::ptrdiff_t site_at(std::size_t triangle, const Vec3& point) const override;
  void divide_at_edges(const TriangleMesh& mesh);
  float value_of(std::size_t point, const std::vector<float>& values) const;

  EmbeddedSurface surface_;
  Lattice lattice_;
  std::vector<std::uint32_t> point_of_;  ///< per vertex: that of the mesh
  std::vector<std::size_t> entry_;       ///< eight per vertex of the mesh: places in sites() of its corners
};

}  // namespace mss::view

#pragma once

#include <span>
#include <vector>

#include "core/body/body.hpp"
#include "core/mesh/embedded_surface.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace mss {

/// The faces between cells and no cell at rest, each as four triangles about its centre, so that corners are
/// treated alike. Of a body of three dimensions.
TriangleMesh faces_of_cells(const Body& body);

/// The same surface with vertices added in the middle of edges until none is longer than `longest` [m].
TriangleMesh divided(TriangleMesh mesh, double longest);

/// The surface by which a body touches others and itself: triangles whose vertices are where weights of its
/// particles say.
class ContactSurface {
 public:
  /// A part of a vertex that a particle carries.
  struct Share {
    std::ptrdiff_t site;  ///< in the body's lattice
    double weight;
  };

  /// Of a mesh that the body's cells carry, divided where its edges are longer than cells; nullptr: the faces
  /// of the cells.
  ContactSurface(const Body& body, const TriangleMesh* mesh);

  /// At rest.
  const TriangleMesh& mesh() const { return mesh_; }
  std::size_t size() const { return mesh_.vertices.size(); }
  std::span<const Share> shares(std::size_t vertex) const {
    return std::span(shares_).subspan(first_share_[vertex], first_share_[vertex + 1] - first_share_[vertex]);
  }
  /// Where a field over the body's lattice has the vertex.
  template <class Real>
  Vec3 at(std::size_t vertex, const Field<Real>& field) const {
    Vec3 value = Vec3::Zero();
    for (const auto& [site, weight] : shares(vertex)) value += weight * field.at(site);
    return value;
  }
  /// A share of the surface's area [m^2].
  double area(std::size_t vertex) const { return area_[vertex]; }
  /// A vertex's mass over area, see SurfaceContact; at most what the body's lightest vertex would have if its
  /// cells were full [kg/m^2].
  double mass_per_area(std::size_t vertex) const { return mass_per_area_[vertex]; }
  /// Triangles that a vertex is a corner of.
  std::span<const int> triangles_at(std::size_t vertex) const {
    return std::span(around_).subspan(first_around_[vertex],
                                      first_around_[vertex + 1] - first_around_[vertex]);
  }

 private:
  void find_mass_per_area(const Body& body, const EmbeddedSurface& surface);
  void find_triangles_around();

  TriangleMesh mesh_;
  std::vector<Share> shares_;
  std::vector<std::size_t> first_share_;
  std::vector<double> area_;
  std::vector<double> mass_per_area_;
  std::vector<int> around_;
  std::vector<std::size_t> first_around_;
};

}  // namespace mss

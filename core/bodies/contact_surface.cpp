#include "core/bodies/contact_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/environment/surface_contact.hpp"

namespace mss {

namespace {

/// Corners of a cell's face on a side of an axis, counter-clockwise from outside.
std::array<int, 4> corners_of_face(int axis, int side) {
  const int b = 1 << (axis + 1) % 3, c = 1 << (axis + 2) % 3, up = side << axis;
  if (side == 1) return {up, up + b, up + b + c, up + c};
  return {up, up + c, up + b + c, up + b};
}

/// Vertices of a mesh by the sites they are at.
class VerticesAtSites {
 public:
  explicit VerticesAtSites(const Body& body) : body_(body), vertex_(std::size_t(body.lattice().size), -1) {}
  int at(std::ptrdiff_t site, TriangleMesh& mesh) {
    int& vertex = vertex_[std::size_t(site)];
    if (vertex < 0) {
      vertex = int(mesh.vertices.size());
      mesh.vertices.push_back(body_.rest_position(site));
    }
    return vertex;
  }

 private:
  const Body& body_;
  std::vector<int> vertex_;
};

void add_face(const std::array<int, 4>& corners, TriangleMesh& mesh) {
  const int centre = int(mesh.vertices.size());
  Vec3 mean = Vec3::Zero();
  for (const int corner : corners) mean += mesh.vertices[std::size_t(corner)] / 4;
  mesh.vertices.push_back(mean);
  for (std::size_t i = 0; i < 4; ++i) mesh.triangles.push_back({corners[i], corners[(i + 1) % 4], centre});
}

/// Vertices in the middle of edges, made where they are asked for.
class Middles {
 public:
  Middles(TriangleMesh& mesh, double longest) : mesh_(mesh), longest_(longest) {}
  /// -1 where the edge is short enough.
  int of(int a, int b) {
    const Vec3 from = mesh_.vertices[std::size_t(std::min(a, b))],
               to = mesh_.vertices[std::size_t(std::max(a, b))];
    if (!((to - from).norm() > longest_)) return -1;
    const auto [entry, is_new] = middle_.try_emplace(std::minmax({a, b}), int(mesh_.vertices.size()));
    if (is_new) mesh_.vertices.emplace_back((from + to) / 2);
    return entry->second;
  }

 private:
  TriangleMesh& mesh_;
  double longest_;
  std::map<std::pair<int, int>, int> middle_;
};

/// The parts of a triangle some of whose edges have a vertex in the middle, or -1: on the edges ab, bc, ca.
void add_parts(const std::array<int, 3>& t, const std::array<int, 3>& middle,
               std::vector<std::array<int, 3>>& parts) {
  const auto divided_edges = 3 - std::count(middle.begin(), middle.end(), -1);
  if (divided_edges == 0) parts.push_back(t);
  if (divided_edges == 3) {
    parts.push_back(middle);
    for (std::size_t i = 0; i < 3; ++i) parts.push_back({t[i], middle[i], middle[(i + 2) % 3]});
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const int a = t[i], b = t[(i + 1) % 3], c = t[(i + 2) % 3];
    const int ab = middle[i], bc = middle[(i + 1) % 3], ca = middle[(i + 2) % 3];
    if (divided_edges == 1 && ab >= 0) parts.insert(parts.end(), {{a, ab, c}, {ab, b, c}});
    if (divided_edges == 2 && ca < 0) parts.insert(parts.end(), {{ab, b, bc}, {a, ab, bc}, {a, bc, c}});
  }
}

/// With cells that are full of what they hold.
BodyConfig filled_up(BodyConfig config) {
  for (CellContent& content : config.contents) {
    float whole = 0;
    for (const PartFill& part : content) whole += part.fill.share();
    for (PartFill& part : content) part.fill = CellFill::even(part.fill.share() / whole);
  }
  return config;
}

}  // namespace

TriangleMesh faces_of_cells(const Body& body) {
  TriangleMesh mesh;
  VerticesAtSites vertices(body);
  const Lattice& lattice = body.lattice();
  body.for_each_cell([&](std::ptrdiff_t site) {
    const std::array<int, 3> cell = lattice.coordinates(site);
    for (int axis = 0; axis < 3; ++axis)
      for (int side = 0; side < 2; ++side) {
        std::array<int, 3> beside = cell;
        beside[std::size_t(axis)] += 2 * side - 1;
        if (body.config().voxels.at(beside[0], beside[1], beside[2])) continue;
        std::array<int, 4> corners = corners_of_face(axis, side);
        for (int& corner : corners) corner = vertices.at(site + lattice.corner(corner), mesh);
        add_face(corners, mesh);
      }
  });
  return mesh;
}

TriangleMesh divided(TriangleMesh mesh, double longest) {
  for (std::size_t before = 0; before != mesh.vertices.size();) {
    before = mesh.vertices.size();
    Middles middles(mesh, longest);
    std::vector<std::array<int, 3>> parts;
    for (const std::array<int, 3>& t : mesh.triangles)
      add_parts(t, {middles.of(t[0], t[1]), middles.of(t[1], t[2]), middles.of(t[2], t[0])}, parts);
    mesh.triangles = std::move(parts);
  }
  return mesh;
}

ContactSurface::ContactSurface(const Body& body, const TriangleMesh* mesh)
    : mesh_(mesh ? divided(*mesh, body.config().cell_size) : faces_of_cells(body)) {
  constexpr double negligible = 1e-12;
  const EmbeddedSurface surface(mesh_, body.config().voxels, body.config().cell_size, body.config().origin);
  area_ = vertex_areas(mesh_);
  first_share_.push_back(0);
  for (std::size_t v = 0; v < size(); ++v) {
    for (int c = 0; c < 8; ++c)
      if (const double weight = surface.weights(v)[std::size_t(c)]; std::abs(weight) > negligible)
        shares_.push_back({surface.site(v) + body.lattice().corner(c), weight});
    first_share_.push_back(shares_.size());
  }
  find_mass_per_area(body, surface);
  find_triangles_around();
}

void ContactSurface::find_mass_per_area(const Body& body, const EmbeddedSurface& surface) {
  const std::vector<double> masses = vertex_masses(mesh_, surface, body),
                            full = body.config().contents.empty()
                                       ? masses
                                       : vertex_masses(mesh_, surface, Body(filled_up(body.config())));
  double most = std::numeric_limits<double>::infinity();
  for (std::size_t v = 0; v < size(); ++v)
    if (area_[v] > 0) most = std::min(most, full[v] / area_[v]);
  for (std::size_t v = 0; v < size(); ++v)
    mass_per_area_.push_back(area_[v] > 0 ? std::min(most, masses[v] / area_[v]) : most);
}

void ContactSurface::find_triangles_around() {
  first_around_.assign(size() + 1, 0);
  for (const std::array<int, 3>& triangle : mesh_.triangles)
    for (const int vertex : triangle) ++first_around_[std::size_t(vertex) + 1];
  for (std::size_t v = 0; v < size(); ++v) first_around_[v + 1] += first_around_[v];
  around_.resize(first_around_.back());
  std::vector<std::size_t> next = first_around_;
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t)
    for (const int vertex : mesh_.triangles[t]) around_[next[std::size_t(vertex)]++] = int(t);
}

}  // namespace mss

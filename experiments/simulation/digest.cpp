#include "experiments/simulation/digest.hpp"

namespace mss {

namespace {

void add_body(const BodyConfig& body, Digest& digest) {
  const auto [nx, ny, nz] = body.voxels.size();
  for (const int count : {nx, ny, nz}) digest.add(count);
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) digest.add(body.content_at(i, j, k));
  for (const CellContent& content : body.contents) {
    digest.add(content.size());
    for (const PartFill& part : content) {
      digest.add(part.part);
      for (const float share : part.fill.octant) digest.add(share);
      for (const float share : part.fill.corner) digest.add(share);
    }
  }
}

}  // namespace

std::string digest_of(const std::vector<Level>& levels, const Scene& scene) {
  Digest digest;
  for (const Level& level : levels) add_body(level.body.config(), digest);
  for (const SceneBody* one : bodies_of(scene)) {
    const auto& surface = one->contact_surface;
    if (!surface) continue;
    for (const Vec3& vertex : surface->vertices)
      for (const double coordinate : {vertex[0], vertex[1], vertex[2]}) digest.add(coordinate);
    for (const auto& triangle : surface->triangles)
      for (const auto corner : triangle) digest.add(corner);
  }
  return digest.text();
}

}  // namespace mss

#pragma once

#include <memory>

#include "core/body/body.hpp"
#include "core/environment/environment.hpp"
#include "core/mesh/mesh_fill.hpp"

namespace mss::testing {

/// A body that fills a mesh.
inline BodyConfig mesh_config(const TriangleMesh& mesh, double cell_size, double young = 1e5,
                              FillMode mode = FillMode::local) {
  MeshFill fill = fill_mesh(mesh, {.cell_size = cell_size, .mode = mode});
  BodyConfig config{.voxels = fill.voxels,
                    .contents = fill.contents,
                    .content_of = fill.content_of,
                    .cell_size = fill.cell_size,
                    .origin = fill.origin};
  config.fill({.young = young, .poisson = 0.3}, 0.5);
  return config;
}

/// The same environment where planes touch the mesh.
inline Environment on_surface(Environment environment, const TriangleMesh& mesh) {
  environment.contact_surface = std::make_shared<TriangleMesh>(mesh);
  return environment;
}

}  // namespace mss::testing

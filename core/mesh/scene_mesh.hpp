#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/mesh_fill.hpp"

namespace mss {

class TomlTable;

/// Keys of [body] that go with `mesh`, and of the table `mesh_rotation` in it.
inline const std::vector<std::string> mesh_keys{"mesh",          "cells_across",     "mesh_scale",
                                                "mesh_rotation", "mesh_translation", "fill"};
inline const std::vector<std::string> mesh_rotation_keys{"axis", "degrees"};

/// A body given as a mesh.
struct SceneMesh {
  std::string file;  ///< as the scene has it
  Placement placement{};
  MeshFillConfig config{};
  TriangleMesh mesh;  ///< placed
  MeshFill fill;
};

/// Reads `body.mesh` with the keys beside it, from a file relative to `folder`, and fills cells with it. The
/// cell size is `cell_size` [m], or the longest extent of the mesh over `cells_across`. Throws InputError
/// with file, line and key.
SceneMesh read_scene_mesh(const TomlTable& body, const std::filesystem::path& folder);

}  // namespace mss

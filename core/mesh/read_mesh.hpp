#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace mss {

/// A mesh of a file, and what was repaired or left out, a sentence each without the name of the file.
struct MeshOfFile {
  TriangleMesh mesh;
  std::vector<std::string> repairs{};
};

/// Reads the triangles of a Wavefront OBJ, STL (text or binary) or PLY file in double precision: all meshes
/// of the file joined, polygons divided, points and lines left out, identical vertices merged, then seams
/// welded and triangles turned alike (mesh_repair.hpp). Coordinates are metres.
///
/// Throws InputError, one sentence that names the file, for one that cannot be read, is larger than 1 GiB, is
/// no mesh, promises more than it holds, has an index of no vertex, a coordinate that is not finite or larger
/// than 1e15 m, or no triangle. Needs memory in proportion to the size of the file, whatever it claims.
MeshOfFile read_mesh(const std::filesystem::path& file);

}  // namespace mss

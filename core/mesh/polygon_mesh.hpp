#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace mss {

/// The faces of a file, as it has them: polygons whose vertices may not exist.
struct PolygonMesh {
  struct Face {
    std::size_t end;   ///< of its corners in `corners`; they begin where those of the face before end
    std::size_t line;  ///< of the file; 0: it has no lines
  };
  std::vector<Vec3> vertices{};         ///< [m]
  std::vector<std::int64_t> corners{};  ///< vertices, counted from 0
  std::vector<Face> faces{};
  std::vector<std::string> remarks{};  ///< what was left out, a sentence each

  void end_face(std::size_t line = 0) { faces.push_back({corners.size(), line}); }
};

/// The formats of files, from their bytes. Numbers of texts and of the type double are read in double
/// precision. Memory is in proportion to the size of the file, whatever it claims. Throw InputError, a
/// sentence with the line or the element where there is one, without the name of the file.
///
/// Wavefront OBJ: `v` and `f` with any of v, v/t, v//n and v/t/n, indices counted from the end where they are
/// negative, comments, continued lines. Weights and colours of vertices are not used.
PolygonMesh read_obj(std::string_view content);
/// STL, as text or binary by what is in it, whatever it begins with.
PolygonMesh read_stl(std::string_view content);
/// PLY, as text or binary, of either order of bytes.
PolygonMesh read_ply(std::string_view content);

/// Faces of fewer than three corners, which make no triangle.
std::size_t short_faces(const PolygonMesh& mesh);

/// Divides polygons into triangles by cutting ears. Throws InputError for a coordinate that is not finite or
/// above 1e15 m, a corner that is no vertex, or a polygon of more than 1000 corners.
TriangleMesh triangles_of(const PolygonMesh& mesh);

}  // namespace mss

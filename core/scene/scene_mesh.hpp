#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/body/body.hpp"
#include "core/mesh/mesh_fill.hpp"

namespace mss {

class TomlTable;

/// A body given as a mesh, and meshes of parts in it.
struct SceneMesh {
  std::string file;                       ///< as the scene has it
  std::vector<std::string> part_files{};  ///< the same of parts beside the first
  Placement placement{};                  ///< of all of them
  MeshFillConfig config{};
  bool by_count = false;          ///< the scene has `cells_across` in place of a cell size
  std::vector<MeshPart> parts{};  ///< placed; part 0 first
  std::vector<MeshReport> reports{};

  double longest_extent() const;  ///< of all meshes together [m]
  TriangleMesh surface() const;   ///< all in one; facing outward once cells are filled
};

/// Reads `body.mesh` with the keys beside it, and `part.mesh`, from files relative to `folder`. The cell size
/// is `cell_size` [m], or the longest extent of the meshes over `cells_across`. Throws InputError with file,
/// line and key.
SceneMesh read_scene_mesh(const TomlTable& body, const std::vector<TomlTable>& parts,
                          const std::filesystem::path& folder);

/// As scene files spell it.
const std::string& to_string(FillMode mode);

/// Fills the cells of a body with a mesh, in cells of config.cell_size; the body's other settings stay.
/// Throws as fill_meshes() does.
void fill_cells(SceneMesh& mesh, BodyConfig& body);

}  // namespace mss

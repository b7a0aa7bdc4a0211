#include "core/scene/scene_mesh.hpp"

#include <fmt/format.h>

#include "core/base/error.hpp"
#include "core/mesh/read_mesh.hpp"
#include "core/mesh/shapes.hpp"
#include "core/scene/toml_reader.hpp"

namespace mss {

namespace {

constexpr Quantity cell_size{"a length", "a positive number of metres",
                             [](double value) { return value > 0; }};
constexpr Quantity cells_across{"a number of cells",
                                "a number of at least 1, of cells along the mesh's longest extent",
                                [](double value) { return value >= 1; }};
constexpr Quantity scale{"a scale", "a positive number", [](double value) { return value > 0; }};
constexpr Quantity axis{"an axis", "a direction [x, y, z] that is not zero", [](double) { return true; }};
constexpr Quantity degrees{"an angle", "a finite number of degrees", [](double) { return true; }};
constexpr Quantity translation{"a displacement", "three finite numbers of metres",
                               [](double) { return true; }};

const std::vector<std::pair<std::string, FillMode>> mesh_fills{{"local", FillMode::local},
                                                               {"staircase", FillMode::staircase}};

Placement read_placement(const TomlTable& body) {
  Placement placement;
  placement.scale = body.number("mesh_scale", scale, placement.scale);
  placement.translation = body.vector("mesh_translation", translation, placement.translation);
  if (body.has("mesh_rotation")) {
    const TomlTable rotation = body.table("mesh_rotation");
    placement.axis = rotation.vector("axis", axis);
    if (!(placement.axis.stableNorm() > 0))
      rotation.reject("axis", fmt::format("is not {}; give {}", axis.noun, axis.allowed));
    placement.degrees = rotation.number("degrees", degrees);
  }
  return placement;
}

double read_cell_size(const TomlTable& body, const SceneMesh& mesh) {
  if (!mesh.by_count) {
    if (!body.has("cell_size"))
      body.reject_missing("cell_size", "give a positive number of metres, or cells_across = 20");
    return body.number("cell_size", cell_size);
  }
  if (body.has("cell_size"))
    body.reject("cells_across", "conflicts with body.cell_size; give one of the two");
  return mesh.longest_extent() / body.number("cells_across", cells_across);
}

/// Reads and places the mesh of a key; its faults become those of the key.
MeshPart read_part(const TomlTable& table, const std::filesystem::path& folder, const Placement& placement,
                   int part, std::string& file) {
  file = table.text("mesh", "a file name", "the path of an OBJ, STL or PLY file, relative to the scene file");
  const std::filesystem::path path = folder / file;
  try {
    MeshOfFile read = read_mesh(path);
    place(read.mesh, placement);
    return {.mesh = std::move(read.mesh),
            .part = part,
            .name = path.string(),
            .repairs = std::move(read.repairs)};
  } catch (const InputError& error) {
    table.reject("mesh", fmt::format("does not give a body: {}", error.what()));
  }
}

}  // namespace

double SceneMesh::longest_extent() const {
  const Box box = bounding_box(surface());
  return (box.upper - box.lower).maxCoeff();
}

TriangleMesh SceneMesh::surface() const {
  TriangleMesh all;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const bool flipped = i < reports.size() && reports[i].flipped;
    all = joined(all, flipped ? turned_inside_out(parts[i].mesh) : parts[i].mesh);
  }
  return all;
}

SceneMesh read_scene_mesh(const TomlTable& body, const std::vector<TomlTable>& parts,
                          const std::filesystem::path& folder) {
  for (const char* other : {"cells", "voxels"})
    if (body.has(other))
      body.reject("mesh", fmt::format("conflicts with body.{}; give one of the two", other));
  if (body.has("origin"))
    body.reject("origin", "conflicts with body.mesh, which says where the body is; give mesh_translation");
  SceneMesh mesh;
  mesh.placement = read_placement(body);
  mesh.by_count = body.has("cells_across");
  mesh.parts.push_back(read_part(body, folder, mesh.placement, 0, mesh.file));
  for (const TomlTable& part : parts) {
    mesh.part_files.emplace_back();
    mesh.parts.push_back(
        read_part(part, folder, mesh.placement, int(mesh.parts.size()), mesh.part_files.back()));
  }
  mesh.config = {.cell_size = read_cell_size(body, mesh),
                 .mode = body.choice("fill", "a way of filling cells", mesh_fills, FillMode::local)};
  return mesh;
}

void fill_cells(SceneMesh& mesh, BodyConfig& body) {
  MeshFill fill = fill_meshes(mesh.parts, mesh.config);
  body.voxels = std::move(fill.voxels);
  body.contents = std::move(fill.contents);
  body.content_of = std::move(fill.content_of);
  body.cell_size = fill.cell_size;
  body.origin = fill.origin;
  mesh.reports = std::move(fill.reports);
}

const std::string& to_string(FillMode mode) {
  for (const auto& [name, known] : mesh_fills)
    if (known == mode) return name;
  return mesh_fills.front().first;
}

}  // namespace mss

#include "core/mesh/scene_mesh.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/mesh/read_mesh.hpp"
#include "core/toml_reader.hpp"

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

const std::vector<std::pair<std::string, FillMode>> fills{{"local", FillMode::local},
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

double read_cell_size(const TomlTable& body, const TriangleMesh& mesh) {
  if (!body.has("cells_across")) {
    if (!body.has("cell_size"))
      body.reject_missing("cell_size", "give a positive number of metres, or cells_across = 20");
    return body.number("cell_size", cell_size);
  }
  if (body.has("cell_size")) body.reject("cells_across", "stands beside body.cell_size; give one of the two");
  const Box box = bounding_box(mesh);
  return (box.upper - box.lower).maxCoeff() / body.number("cells_across", cells_across);
}

/// What `make` makes of the mesh; its complaints become those of the key.
template <class Make>
auto from_mesh(const TomlTable& body, Make&& make) {
  try {
    return make();
  } catch (const InputError& error) {
    body.reject("mesh", fmt::format("does not give a body: {}", error.what()));
  }
}

}  // namespace

SceneMesh read_scene_mesh(const TomlTable& body, const std::filesystem::path& folder) {
  for (const char* other : {"cells", "voxels"})
    if (body.has(other))
      body.reject("mesh", fmt::format("stands beside body.{}; give one of the two", other));
  std::string file =
      body.text("mesh", "a file name", "the path of an OBJ, STL or PLY file, relative to the scene file");
  const std::filesystem::path path = folder / file;
  const Placement placement = read_placement(body);
  TriangleMesh mesh = from_mesh(body, [&] { return read_mesh(path); });
  place(mesh, placement);
  const MeshFillConfig config{.cell_size = read_cell_size(body, mesh),
                              .mode = body.choice("fill", "a way of filling cells", fills, FillMode::local)};
  MeshFill fill = from_mesh(body, [&] { return fill_mesh(mesh, config, path.string()); });
  return {.file = std::move(file),
          .placement = placement,
          .config = config,
          .mesh = std::move(mesh),
          .fill = std::move(fill)};
}

}  // namespace mss

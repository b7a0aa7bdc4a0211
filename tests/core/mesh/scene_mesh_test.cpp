// Meshes as scenes give them.
#include "core/mesh/scene_mesh.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "core/mesh/shapes.hpp"
#include "core/toml_reader.hpp"
#include "tests/core/scene_texts.hpp"

namespace mss {
namespace {

using ::testing::HasSubstr;

/// Reads a [body] with these lines, beside a file box.obj of 1 x 2 x 3 m.
SceneMesh read(const testing::SceneFolder& folder, const std::string& lines) {
  KnownKeys known{{"", {"body"}}, {"body", mesh_keys}, {"body.mesh_rotation", mesh_rotation_keys}};
  for (const char* key : {"cells", "voxels", "cell_size"}) known["body"].emplace_back(key);
  write_obj(folder.path() / "box.obj", box_mesh({0, 0, 0}, {1, 2, 3}));
  const TomlFile toml(folder.write("scene.toml", "[body]\n" + lines), {}, known);
  return read_scene_mesh(TomlTable(toml).table("body"), folder.path());
}

TEST(SceneMesh, IsReadPlacedAndFilled) {
  const testing::SceneFolder folder;
  const SceneMesh plain = read(folder, "mesh = \"box.obj\"\ncell_size = 0.5\n");
  EXPECT_EQ(plain.file, "box.obj");
  EXPECT_EQ(plain.fill.voxels.size(), (std::array<int, 3>{2, 4, 6}));
  EXPECT_EQ(plain.config.mode, FillMode::local);
  const SceneMesh placed = read(folder,
                                "mesh = \"box.obj\"\ncells_across = 12\nmesh_scale = 2\n"
                                "mesh_rotation = { axis = [0, 0, 2], degrees = 90 }\n"
                                "mesh_translation = [0, 0, 1]\nfill = \"staircase\"\n");
  EXPECT_EQ(placed.fill.voxels.size(), (std::array<int, 3>{8, 4, 12}));
  EXPECT_DOUBLE_EQ(placed.config.cell_size, 0.5);
  EXPECT_EQ(placed.config.mode, FillMode::staircase);
  EXPECT_LT((placed.fill.origin - Vec3(-4, 0, 1)).norm(), 1e-12);
  EXPECT_EQ(placed.fill.voxels.count(), 8U * 4 * 12);
}

TEST(SceneMesh, MistakesEndInASentence) {
  const testing::SceneFolder folder;
  const std::string mesh = "mesh = \"box.obj\"\n";
  const std::pair<std::string, const char*> mistakes[]{
      {mesh, "body.cell_size is missing; give a positive number of metres, or cells_across = 20"},
      {mesh + "cell_size = 1\ncells_across = 5\n", "body.cells_across = 5 stands beside body.cell_size"},
      {mesh + "cell_size = 0\n", "body.cell_size = 0 is not a length"},
      {mesh + "cells_across = 0.5\n", "body.cells_across = 0.5 is not a number of cells"},
      {mesh + "cells_across = 5\ncells = [1, 1, 1]\n", "body.mesh = \"box.obj\" stands beside body.cells"},
      {mesh + "cells_across = 5\nmesh_scale = -1\n", "body.mesh_scale = -1 is not a scale"},
      {mesh + "cells_across = 5\nmesh_rotation = { axis = [0, 0, 0], degrees = 3 }\n", "is not an axis"},
      {mesh + "cells_across = 5\nmesh_rotation = { axis = [0, 0, 1] }\n",
       "body.mesh_rotation.degrees is missing"},
      {mesh + "cells_across = 5\nfill = \"locl\"\n", "nearest is \"local\""},
      {mesh + "cell_size = 1e-9\n", "box.obj: cells of 1e-09 m make a lattice"},
      {"mesh = \"none.obj\"\ncell_size = 1\n", "does not give a body: "},
      {"mesh = 5\ncell_size = 1\n", "body.mesh = 5 is not a file name"},
  };
  for (const auto& [lines, says] : mistakes) try {
      read(folder, lines);
      ADD_FAILURE() << lines;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(says));
      EXPECT_THAT(error.what(), HasSubstr("scene.toml:"));
    }
}

}  // namespace
}  // namespace mss

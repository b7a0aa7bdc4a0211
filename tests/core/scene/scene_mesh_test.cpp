// Meshes as scenes give them.
#include "core/scene/scene_mesh.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>

#include "core/base/error.hpp"
#include "core/mesh/shapes.hpp"
#include "core/scene/scene.hpp"
#include "core/scene/scene_edit.hpp"
#include "core/scene/scene_writer.hpp"
#include "tests/core/scene/scene_texts.hpp"

namespace mss {
namespace {

using ::testing::HasSubstr;

const std::string material =
    "[material]\ndensity = 1000\nyoung = 1e5\npoisson = 0.3\n[solve]\nduration = 1\n";

/// Loads a scene with these lines in [body], beside a file box.obj of 1 x 2 x 3 m.
Scene read(const testing::SceneFolder& folder, const std::string& lines, const std::string& rest = material) {
  write_obj(folder.path() / "box.obj", box_mesh({0, 0, 0}, {1, 2, 3}));
  return load_scene(folder.write("scene.toml", "[body]\n" + lines + rest));
}

TEST(SceneMesh, IsReadPlacedAndFilled) {
  const testing::SceneFolder folder;
  const Scene plain = read(folder, "mesh = \"box.obj\"\ncell_size = 0.5\n");
  EXPECT_EQ(plain.mesh->file, "box.obj");
  EXPECT_EQ(plain.body.voxels.size(), (std::array<int, 3>{2, 4, 6}));
  EXPECT_EQ(plain.mesh->config.mode, FillMode::local);
  EXPECT_TRUE(plain.body.is_full());
  const Scene placed = read(folder,
                            "mesh = \"box.obj\"\ncells_across = 12\nmesh_scale = 2\n"
                            "mesh_rotation = { axis = [0, 0, 2], degrees = 90 }\n"
                            "mesh_translation = [0, 0, 1]\nfill = \"staircase\"\n");
  EXPECT_EQ(placed.body.voxels.size(), (std::array<int, 3>{8, 4, 12}));
  EXPECT_DOUBLE_EQ(placed.body.cell_size, 0.5);
  EXPECT_EQ(placed.mesh->config.mode, FillMode::staircase);
  EXPECT_LT((placed.body.origin - Vec3(-4, 0, 1)).norm(), 1e-12);
  EXPECT_EQ(placed.body.voxels.count(), 8U * 4 * 12);
}

// Cells of 0.4 m reach 0.1 m past both ends of the 3 m of a mesh, and past 1 m by as much on each side.
TEST(SceneMesh, SaysThatABoxLeavesOutParticlesOutsideTheMesh) {
  const testing::SceneFolder folder;
  const auto warnings_with = [&](const std::string& box, const std::string& size = "0.4") {
    return read(folder, "mesh = \"box.obj\"\ncell_size = " + size + "\n",
                material + "[[hold]]\n" + box + "\n")
        .warnings;
  };
  const auto short_of = ::testing::Contains(HasSubstr("hold.0: its box ends where the mesh does"));
  EXPECT_THAT(warnings_with("box = [[0, 0, 0], [1, 2, 0.5]]"), short_of);
  EXPECT_THAT(warnings_with("box = [[-0.4, -0.4, 0], [1.4, 2.4, 0.5]]"), short_of);  // below alone
  EXPECT_THAT(warnings_with("box = [[-0.4, -0.4, 2.5], [1.4, 2.4, 3]]"), short_of);  // above alone
  EXPECT_THAT(warnings_with("box = [[-0.4, -0.4, -0.4], [1.4, 2.4, 0.5]]"), ::testing::Not(short_of));
  EXPECT_THAT(warnings_with("box = [[-0.4, -0.4, 1], [1.4, 2.4, 2]]"), ::testing::Not(short_of));
  EXPECT_THAT(warnings_with("surface_box = [[0, 0, 0], [1, 2, 0]]"), ::testing::Not(short_of));
  EXPECT_THAT(warnings_with("box = [[0, 0, 0], [1, 2, 0]]", "0.5"), ::testing::Not(short_of));  // they fit
}

/// Kilograms of the bodies of a sphere of six decimals as it is, and moved far away and back.
std::pair<double, double> masses_near_and_far(const Vec3& far) {
  const testing::SceneFolder folder;
  std::array<double, 2> masses{};
  for (const bool moved : {false, true}) {
    const Vec3 shift = moved ? far : Vec3(Vec3::Zero());
    std::string text;
    for (const Vec3& x : icosphere(0.5, 10).vertices)
      text +=
          fmt::format("v {:.6f} {:.6f} {:.6f}\n", x.x() + shift.x(), x.y() + shift.y(), x.z() + shift.z());
    for (const auto& t : icosphere(0.5, 10).triangles)
      text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    folder.write("sphere.obj", text);
    const Scene scene =
        read(folder, fmt::format("mesh = \"sphere.obj\"\ncell_size = 0.1\nmesh_translation = [{:.1f}, "
                                 "{:.1f}, {:.1f}]\n",
                                 -shift.x(), -shift.y(), -shift.z()));
    EXPECT_TRUE(scene.warnings.empty()) << scene.warnings.front();
    masses[moved ? 1 : 0] = 1000 * scene.mesh->reports.at(0).filled_volume;
  }
  return {masses[0], masses[1]};
}

TEST(SceneMesh, InTheCoordinatesOfAMapIsMovedBackExactly) {
  for (const Vec3& far :
       {Vec3(400000, 5000000, 100), Vec3(40000, 50000, 0), Vec3(-4e6, 2e6, 5e6), Vec3(0, -1e7, 3)}) {
    const auto [near_mass, far_mass] = masses_near_and_far(far);
    EXPECT_DOUBLE_EQ(near_mass, far_mass) << far.transpose();
  }
}

TEST(SceneMesh, WarnsOfWhatCellsMiss) {
  const testing::SceneFolder folder;
  write_obj(folder.path() / "fin.obj",
            joined(box_mesh({0, 0, 0}, {1, 1, 0.2}), box_mesh({0.49, 0, 0.2}, {0.51, 1, 0.7})));
  const auto missed = [&](const std::string& cell_size) {
    std::string all;
    for (const std::string& warning :
         read(folder, "mesh = \"fin.obj\"\ncell_size = " + cell_size + "\n").warnings)
      all += warning + "; ";
    return all;
  };
  EXPECT_THAT(missed("0.1"),
              HasSubstr("fin.obj: cells of 0.1 m miss its part from (0.49, 0, 0.2) to (0.51, 1, 0.7) m"));
  EXPECT_THAT(missed("0.1"), HasSubstr("that of the mesh (0.5, 0.5, 0.1167) m"));
  EXPECT_THAT(missed("0.07"), ::testing::Not(HasSubstr("miss")));
}

TEST(SceneMesh, IsTheSameAfterItWasWritten) {
  const testing::SceneFolder folder;
  const Scene scene = read(folder,
                           "mesh = \"box.obj\"\ncells_across = 7\nrefine = 2\n"
                           "mesh_rotation = { axis = [1, 2, 3], degrees = 33 }\n");
  const Scene again = load_scene(folder.write("again.toml", to_toml(scene, folder.path())));
  EXPECT_EQ(again.body.cell_size, scene.body.cell_size);
  EXPECT_EQ(again.body.origin, scene.body.origin);
  EXPECT_EQ(again.body.contents, scene.body.contents);
  EXPECT_EQ(again.body.content_of, scene.body.content_of);
}

TEST(SceneMesh, PartsAreMeshesOfTheirOwn) {
  const testing::SceneFolder folder;
  write_obj(folder.path() / "top.obj", box_mesh({0, 0, 3}, {1, 2, 4}));
  const Scene scene =
      read(folder, "mesh = \"box.obj\"\ncell_size = 0.4\n",
           material + "[[part]]\nname = \"top\"\nmesh = \"top.obj\"\nyoung = 2e5\ndensity = 500\n");
  const Body body(scene.body);
  EXPECT_NEAR(body.total_mass(), 1000 * 6 + 500 * 2, 1);  // half a sample in 512 cells
  EXPECT_EQ(scene.body.parts.front().elastic->young, 2e5);
  EXPECT_THROW(read(folder, "mesh = \"box.obj\"\ncell_size = 0.4\n", material + "[[part]]\nname = \"top\"\n"),
               InputError);
}

TEST(SceneMesh, IsFilledAgainInOtherCells) {
  const testing::SceneFolder folder;
  const Scene scene = read(folder, "mesh = \"box.obj\"\ncells_across = 6\n");
  SceneEdit edit = edit_of(scene);
  EXPECT_EQ(edit.level, 6);
  edit.level = 9;  // no multiple
  const Scene finer = edited(scene, edit);
  EXPECT_NEAR(finer.body.cell_size, 3.0 / 9, 1e-12);
  EXPECT_EQ(finer.body.voxels.size(), (std::array<int, 3>{3, 6, 9}));
  EXPECT_EQ(level_of(finer), 9);
}

TEST(SceneMesh, PlanesTouchItsSurfaceWhereTheSceneSaysSo) {
  const testing::SceneFolder folder;
  const std::string mesh = "mesh = \"box.obj\"\ncells_across = 6\n";
  EXPECT_EQ(read(folder, mesh).environment.contact_surface, nullptr);
  EXPECT_EQ(read(folder, mesh + "contact_on = \"particles\"\n").environment.contact_surface, nullptr);
  const Scene scene = read(folder, mesh + "mesh_scale = 2\ncontact_on = \"surface\"\n",
                           material + "[[plane]]\npoint = [0, 0, -1]\nnormal = [0, 0, 1]\n");
  ASSERT_NE(scene.environment.contact_surface, nullptr);
  EXPECT_NEAR(enclosed_volume(*scene.environment.contact_surface), 48, 1e-12);
  const Scene again = load_scene(folder.write("again.toml", to_toml(scene, folder.path())));
  ASSERT_NE(again.environment.contact_surface, nullptr);
  EXPECT_EQ(again.environment.contact_surface->vertices, scene.environment.contact_surface->vertices);
}

// The four vertices of the top take a quarter each: the particles get the same force and moment.
TEST(SceneMesh, TakesLoadsOnItsVertices) {
  const testing::SceneFolder folder;
  const std::string load = "[[load]]\nsurface_box = [[0, 0, 3], [1, 2, 3]]\nforce = [1, 2, -8]\n";
  const Scene scene = read(folder, "mesh = \"box.obj\"\ncell_size = 0.4\n", material + load);
  const Body body(scene.body);
  const LoadedSites loads(body, scene.environment.loads);
  Field<double> f(body.lattice().size);
  loads.add(0, 0, body.lattice().sites, std::array<double*, 3>{f.axis(0), f.axis(1), f.axis(2)});
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();
  for (const std::ptrdiff_t site : body.sites()) {
    force += f.at(site);
    moment += body.rest_position(site).cross(f.at(site));
  }
  EXPECT_LT((force - Vec3(1, 2, -8)).norm(), 1e-13);
  EXPECT_LT((moment - Vec3(0.5, 1, 3).cross(Vec3(1, 2, -8))).norm(), 1e-12);
  const Scene again = load_scene(folder.write("again.toml", to_toml(scene, folder.path())));
  ASSERT_NE(again.environment.loads[0].surface, nullptr);
  EXPECT_EQ(again.environment.loads[0].box.lower, Vec3(0, 0, 3));
}

// Cells of .4 reach .1 beyond a box of 1 x 2 x 3, so the top is .1 from the highest particles and .3 from the
// next.
TEST(SceneMesh, HoldsParticlesAtItsFaces) {
  const testing::SceneFolder folder;
  const Scene scene = read(folder, "mesh = \"box.obj\"\ncell_size = 0.4\n",
                           material + "[[hold]]\nsurface_box = [[0, 0, 3], [1, 2, 3]]\naxes = \"z\"\n");
  const Body body(scene.body);
  const HeldSites held(body, scene.environment.holds);
  int count = 0;
  for (const std::ptrdiff_t site : body.sites()) {
    const bool on_top = body.rest_position(site)[2] > 3;
    EXPECT_EQ(held.holds(site, 2), on_top);
    EXPECT_FALSE(held.holds(site, 0));
    count += on_top;
  }
  EXPECT_EQ(count, 4 * 6);
  const Scene again = load_scene(folder.write("again.toml", to_toml(scene, folder.path())));
  ASSERT_NE(again.environment.holds[0].surface, nullptr);
  EXPECT_EQ(sites_of(again.environment.holds[0], body), sites_of(scene.environment.holds[0], body));
}

TEST(SceneMesh, RefusesWhatItsSurfaceCannotDo) {
  const testing::SceneFolder folder;
  const std::string on_surface = "mesh = \"box.obj\"\ncells_across = 6\ncontact_on = \"surface\"\n";
  const std::string plane = "[[plane]]\npoint = [0, 0, -1]\nnormal = [0, 0, 1]\n";
  const auto expect_refused = [&](const std::string& lines, const std::string& rest, const char* message) {
    try {
      read(folder, lines, rest);
      ADD_FAILURE() << message;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(message));
    }
  };
  expect_refused(
      on_surface, material + plane + "contact = \"thesis\"\n",
      "plane.0.contact = \"thesis\" is a law of particles, and body.contact_on is \"surface\"; give "
      "\"impulse\" or \"penalty\"");
  expect_refused(on_surface, material + "sleep = 1e-3\n" + plane,
                 "solve.sleep = 0.001 is for contact of particles, and body.contact_on is \"surface\"");
  expect_refused("mesh = \"box.obj\"\ncells_across = 6\ncontact_on = \"cells\"\n", material,
                 "body.contact_on = \"cells\" is not what planes touch; give");
  const std::string mesh = "mesh = \"box.obj\"\ncells_across = 6\n";
  expect_refused(mesh, material + "[[load]]\nsurface_box = [[0, 0, 1], [1, 2, 2]]\nforce = [0, 0, 1]\n",
                 "contains no vertex of the mesh; give one that does, it spans [0, 0, 0] to [1, 2, 3]");
  expect_refused(mesh, material + "[[hold]]\nsurface_box = [[0, 0, 3], [1, 0, 3]]\n",
                 "hold.0.surface_box = [[0, 0, 3], [1, 0, 3]] contains no whole face of the mesh; give one "
                 "that does");
  expect_refused(mesh,
                 material +
                     "[expect]\ndisplacement = { surface_box = [[0, 0, 0], [1, 2, 3]], box = [[0, 0, 0], "
                     "[1, 2, 3]], value = [0, 0, 0], within = 1 }\n",
                 "conflicts with expect.displacement.box; give one of the two");
  expect_refused("cells = [1, 1, 1]\ncell_size = 1\n",
                 material + "[[load]]\nsurface_box = [[0, 0, 0], [1, 1, 1]]\nforce = [0, 0, 1]\n",
                 "is about a mesh; give body.mesh, or box in its place");
  expect_refused("cells = [1, 1, 1]\ncell_size = 1\ncontact_on = \"surface\"\n", material,
                 "body.contact_on = \"surface\" is about a mesh; give body.mesh, or leave it out");
}

TEST(SceneMesh, MistakesEndInASentence) {
  const testing::SceneFolder folder;
  const std::string mesh = "mesh = \"box.obj\"\n";
  const std::pair<std::string, const char*> mistakes[]{
      {mesh, "body.cell_size is missing; give a positive number of metres, or cells_across = 20"},
      {mesh + "cell_size = 1\ncells_across = 5\n", "body.cells_across = 5 conflicts with body.cell_size"},
      {mesh + "cell_size = 0\n", "body.cell_size = 0 is not a length"},
      {mesh + "cells_across = 0.5\n", "body.cells_across = 0.5 is not a number of cells"},
      {mesh + "cells_across = 5\ncells = [1, 1, 1]\n", "body.mesh = \"box.obj\" conflicts with body.cells"},
      {mesh + "cells_across = 5\nmesh_scale = -1\n", "body.mesh_scale = -1 is not a scale"},
      {mesh + "cells_across = 5\nmesh_rotation = { axis = [0, 0, 0], degrees = 3 }\n", "is not an axis"},
      {mesh + "cells_across = 5\nmesh_rotation = { axis = [0, 0, 1] }\n",
       "body.mesh_rotation.degrees is missing"},
      {mesh + "cells_across = 5\nfill = \"locl\"\n", "nearest is \"local\""},
      {mesh + "cell_size = 1e-9\n", "box.obj: cells of 1e-09 m make a lattice"},
      {"mesh = \"none.obj\"\ncell_size = 1\n", "does not give a body: "},
      {"mesh = 5\ncell_size = 1\n", "body.mesh = 5 is not a file name"},
      {mesh + "cell_size = 1\norigin = [0, 0, 1]\n", "body.origin = [0, 0, 1] conflicts with body.mesh"},
      {"cells = [1, 1, 1]\ncell_size = 1\nfill = \"local\"\n", "body.fill = \"local\" is about a mesh"},
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

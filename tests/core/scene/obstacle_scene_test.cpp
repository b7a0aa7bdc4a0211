#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/base/error.hpp"
#include "core/environment/obstacle.hpp"
#include "core/mesh/shapes.hpp"
#include "core/scene/scene.hpp"
#include "core/scene/scene_writer.hpp"
#include "tests/core/scene/scene_texts.hpp"

namespace mss::obstacle_scene_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Scene with_obstacles(const testing::SceneFolder& folder, const std::string& tables) {
  return load_scene(folder.write("obstacles.toml", testing::plain_scene + tables));
}
std::string complaint_about(const std::string& keys) {
  const testing::SceneFolder folder;
  write_obj(folder.path() / "open.obj", [] {
    TriangleMesh mesh = box_mesh(Vec3::Zero(), Vec3::Ones());
    mesh.triangles.pop_back();
    return mesh;
  }());
  try {
    with_obstacles(folder, "[[obstacle]]\n" + keys);
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing";
}

TEST(ObstacleScene, IsReadAndWrittenAgain) {
  const testing::SceneFolder folder;
  write_obj(folder.path() / "block.obj", turned_inside_out(box_mesh(Vec3(-10, -10, -10), Vec3(10, 10, 10))));
  const Scene scene = with_obstacles(folder, R"([[obstacle]]
shape = "sphere"
radius = 0.2
centre = [0.5, 0.5, -3]
[[obstacle]]
shape = "capsule"
radius = 0.1
length = 1
axis = [2, 0, 0]
centre = [0, 0, -2]
contact = "penalty"
restitution = 0.1
friction = 0.7
path = [[0, 0, 0, 0], [1, 0, 0, 1]]
turn = { axis = [0, 1, 0], centre = [0, 0, -2], rate = 3, until = 2 }
[[obstacle]]
shape = "mesh"
mesh = "block.obj"
mesh_scale = 0.1
rotation = { axis = [0, 0, 1], degrees = 45 }
centre = [0, 0, -5]
[[obstacle]]
shape = "box"
size = [1, 2, 3]
centre = [0, 9, 0]
[[obstacle]]
shape = "cylinder"
radius = 0.3
length = 1
centre = [9, 0, 0]
contact = "thesis"
)");
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("obstacle.0: it is smaller than a cell")));
  const std::vector<Obstacle>& all = scene.environment.obstacles;
  ASSERT_EQ(all.size(), 5U);
  EXPECT_EQ(all[0].radius, 0.2);
  EXPECT_EQ(all[1].axis, Vec3::UnitX());
  EXPECT_EQ(all[1].path.at(0.5), Vec3(0, 0, 0.5));
  EXPECT_EQ(all[1].turn->until, 2);
  EXPECT_EQ(all[1].contact, ContactLaw::penalty);
  EXPECT_EQ(all[2].degrees, 45);
  EXPECT_EQ(all[3].size, Vec3(1, 2, 3));
  EXPECT_EQ(all[4].contact, ContactLaw::thesis);
  EXPECT_NEAR(ObstacleSurface(all[2]).gap(Vec3(0, 0, -3.5), 0), 0.5, 1e-12);
  const Scene again = load_scene(folder.write("again.toml", to_toml(scene, folder.path())));
  nlohmann::ordered_json before = to_json(scene), after = to_json(again);
  for (nlohmann::ordered_json* json : {&before, &after}) json->erase("name");
  EXPECT_EQ(before, after);
}

TEST(ObstacleScene, RefusesWhatAShapeHasNot) {
  EXPECT_THAT(complaint_about("radius = 1\ncentre = [0, 0, 0]\n"), HasSubstr("obstacle.0.shape is missing"));
  EXPECT_THAT(complaint_about("shape = \"spere\"\n"), HasSubstr("nearest is \"sphere\""));
  EXPECT_THAT(complaint_about("shape = \"sphere\"\ncentre = [0, 0, 0]\n"),
              HasSubstr("obstacle.0.radius is missing"));
  EXPECT_THAT(complaint_about("shape = \"sphere\"\nradius = 1\n"), HasSubstr("obstacle.0.centre is missing"));
  EXPECT_THAT(complaint_about("shape = \"sphere\"\nradius = -1\ncentre = [0, 0, 0]\n"),
              HasSubstr("a positive number of metres"));
  EXPECT_THAT(complaint_about("shape = \"sphere\"\nradius = 1\nsize = [1, 1, 1]\ncentre = [0, 0, 0]\n"),
              HasSubstr("obstacle.0.size = [1, 1, 1] is not of shape \"sphere\""));
  EXPECT_THAT(complaint_about("shape = \"box\"\nsize = [1, 1, 1]\naxis = [1, 0, 0]\ncentre = [0, 0, 0]\n"),
              HasSubstr("obstacle.0.axis = [1, 0, 0] is not of shape \"box\""));
  EXPECT_THAT(complaint_about("shape = \"box\"\nsize = [1, 0, 1]\ncentre = [0, 0, 0]\n"),
              HasSubstr("three positive numbers"));
  EXPECT_THAT(complaint_about("shape = \"mesh\"\nmesh = \"open.obj\"\ncentre = [0, 0, 0]\n"),
              HasSubstr("does not give an obstacle: is not closed"));
  EXPECT_THAT(complaint_about("shape = \"mesh\"\nmesh = \"none.obj\"\ncentre = [0, 0, 0]\n"),
              HasSubstr("obstacle.0.mesh"));
  EXPECT_THAT(complaint_about("shape = \"sphere\"\nradius = 1\ncentre = [0, 0, 0]\nspeed = 1\n"),
              HasSubstr("obstacle.0.speed"));
}

TEST(ObstacleScene, WarnsOfBodiesAndObstaclesInEachOther) {
  const auto warnings = [](const std::string& keys) {
    const testing::SceneFolder folder;  // the body is a cube of 1 m
    return with_obstacles(folder, "[[obstacle]]\n" + keys).warnings;
  };
  EXPECT_THAT(warnings("shape = \"sphere\"\nradius = 1\ncentre = [0.5, 0.5, -1]\n"), ElementsAre());
  EXPECT_THAT(
      warnings("shape = \"sphere\"\nradius = 1\ncentre = [0.5, 0.5, -0.9]\n"),
      ElementsAre(HasSubstr("obstacle.0: the body starts inside it, up to 0.1 m deep: it is pushed out")));
  EXPECT_THAT(warnings("shape = \"sphere\"\nradius = 0.1\ncentre = [0.3, 0.3, 0.3]\n"),
              ElementsAre(HasSubstr("its centre starts inside the body"), HasSubstr("smaller than a cell")));
  EXPECT_THAT(warnings("shape = \"sphere\"\nradius = 1\ncentre = [0.5, 0.5, -1]\nrestitution = 0.9\n"),
              ElementsAre(HasSubstr("obstacle.0.restitution = 0.9 is that of each particle")));
}

}  // namespace
}  // namespace mss::obstacle_scene_test

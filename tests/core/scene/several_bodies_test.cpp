// Scenes of several bodies, and of bodies that touch: what each says, what stands for all, what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/base/error.hpp"
#include "core/scene/scene.hpp"
#include "core/scene/scene_writer.hpp"
#include "tests/core/scene/scene_texts.hpp"

namespace mss::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string blocks = R"([material]
density = 1000
young = 1e6
poisson = 0.3
[damping]
ratio = 0.05
[start]
velocity = [0, 0, -1]
[contact]
bodies = true
friction = 0.25
[[body]]
name = "lower"
cells = [4, 4, 4]
cell_size = 0.05
[[body]]
name = "upper"
cells = [3, 2, 1]
cell_size = 0.04
refine = 2
origin = [0.02, 0.03, 0.2]
material = { young = 5e5, fold_guard = 20 }
damping = { viscosity = 10 }
start = { angular_velocity = [0, 0, 3] }
[[body.weight]]
box = [[0.02, 0.03, 0.2], [0.02, 0.03, 0.2]]
mass = 0.1
)";

std::string complaint_about(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    parse_scene(text, overrides);
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

std::string without(const std::string& part) {
  std::string text = blocks;
  return text.replace(text.find(part), part.size(), "");
}

TEST(SeveralBodies, HaveWhatTheySayAndElseWhatTheSceneSays) {
  const Scene scene = parse_scene(blocks);
  ASSERT_EQ(scene.others.size(), 1U);
  const SceneBody& lower = scene;
  const SceneBody& upper = scene.others[0];
  EXPECT_EQ(lower.body_name, "lower");
  EXPECT_EQ(upper.body_name, "upper");
  EXPECT_EQ(lower.body.elastic->young, 1e6);
  EXPECT_EQ(upper.body.elastic->young, 5e5);
  EXPECT_EQ(upper.body.elastic->poisson, 0.3);
  EXPECT_EQ(upper.body.density, 1000);
  EXPECT_EQ(lower.body.fold_guard, 0);
  EXPECT_EQ(upper.body.fold_guard, 20);
  EXPECT_EQ(lower.body.damping.zeta, 0.05);
  EXPECT_EQ(upper.body.damping.law, Damping::Law::viscosity);
  EXPECT_EQ(upper.start_velocity, Vec3(0, 0, -1));
  EXPECT_EQ(upper.start_angular_velocity, Vec3(0, 0, 3));
  EXPECT_EQ(lower.start_angular_velocity, Vec3(0, 0, 0));
  EXPECT_EQ(upper.body.cell_size, 0.02);
  EXPECT_EQ(upper.body.voxels.count(), 48U);
  EXPECT_EQ(upper.body.weights.size(), 1U);
  EXPECT_TRUE(lower.body.weights.empty());
  EXPECT_TRUE(scene.environment.contact.bodies);
  EXPECT_FALSE(scene.environment.contact.self);
  EXPECT_EQ(scene.environment.contact.friction, 0.25);
  EXPECT_LT((box_at_rest(scene).upper - Vec3(0.2, 0.2, 0.24)).norm(), 1e-15);
}

TEST(SeveralBodies, SpringsOfABodyStandForTheScenesModuli) {
  const Scene scene = parse_scene(blocks, {"body.1.material={springs={edge=10,face=20,body=30}}"});
  EXPECT_FALSE(scene.others[0].body.elastic.has_value());
  EXPECT_EQ(scene.others[0].body.springs.face, 20);
  EXPECT_TRUE(scene.body.elastic.has_value());
}

TEST(SeveralBodies, AreTextAgain) {
  const Scene scene = parse_scene(blocks);
  const Scene again = parse_scene(to_toml(scene, "."));
  EXPECT_EQ(to_json(again).dump(), to_json(scene).dump());
}

TEST(SeveralBodies, OneOfThemIsTheSceneOfOne) {
  const std::string one = "[material]\ndensity = 1000\nyoung = 1e6\npoisson = 0.3\n";
  const std::string cells = "cells = [4, 4, 4]\ncell_size = 0.05\n";
  EXPECT_EQ(to_json(parse_scene(one + "[[body]]\n" + cells)), to_json(parse_scene(one + "[body]\n" + cells)));
}

TEST(SeveralBodies, AreWarnedOfWithoutContact) {
  const auto asked = HasSubstr("bodies do not touch each other"), ring = HasSubstr("face each other");
  EXPECT_THAT(parse_scene(without("[contact]\nbodies = true\nfriction = 0.25\n")).warnings, Contains(asked));
  EXPECT_THAT(parse_scene(blocks, {"contact.bodies=false"}).warnings, Not(Contains(asked)));
  EXPECT_THAT(parse_scene(blocks).warnings, Not(Contains(asked)));
  const SceneFolder folder;
  folder.write("ring.txt", "###\n#.#\n###\n");
  const auto file = folder.write(
      "scene.toml",
      "[body]\nvoxels = \"ring.txt\"\ncell_size = 0.1\n[material]\ndensity = 1\nyoung = 1\npoisson = 0\n");
  EXPECT_THAT(load_scene(file).warnings, Contains(ring));
  EXPECT_THAT(load_scene(file, {"contact.self=true"}).warnings, Not(Contains(ring)));
}

TEST(SeveralBodies, AreRefusedInOneSentence) {
  const auto where = [](const char* table) { return blocks + table; };
  EXPECT_THAT(complaint_about(blocks, {"body.1.name=\"lower\""}), HasSubstr("the name of another body"));
  EXPECT_THAT(complaint_about(blocks, {"body.1.cell_size=-1"}), HasSubstr("body.1.cell_size = -1"));
  EXPECT_THAT(complaint_about(blocks, {"body.1.material.young=-1"}), HasSubstr("body.1.material.young = -1"));
  EXPECT_THAT(complaint_about(without("density = 1000\n")), HasSubstr("material.density is missing"));
  EXPECT_THAT(complaint_about(where("[[part]]\nname = \"A\"\n")), HasSubstr("[[body.part]]"));
  EXPECT_THAT(complaint_about(where("[[refine]]\nbox = [[0,0,0],[1,1,1]]\n")),
              HasSubstr("for a scene of one"));
  EXPECT_THAT(complaint_about(blocks, {"body.0.match=\"bending\""}), HasSubstr("for a scene of one [body]"));
  EXPECT_THAT(complaint_about(where("[[hold]]\nbox = [[5,5,5],[6,6,6]]\n")),
              HasSubstr("hold.0.box = [[5, 5, 5], [6, 6, 6]] contains no particle"));
  EXPECT_THAT(complaint_about(blocks, {"body.1.weight.0.box=[[0,0,0],[0,0,0]]"}),
              HasSubstr("body.1.weight.0.box"));
  EXPECT_THAT(complaint_about(blocks, {"contact.friction=-1"}), HasSubstr("contact.friction = -1"));
  EXPECT_THAT(complaint_about(where("[expect]\nbody_2_x = { value = 0, within = 1 }\n")),
              HasSubstr("2 bodies; count them from 0"));
  EXPECT_THAT(complaint_about("body = []\n"), HasSubstr("write [[body]] above each"));
}

}  // namespace
}  // namespace mss::testing

// Scene files: every key, default and override sets its field. Malformed ones are in scene_error_test.cpp.
#include "core/scene/scene.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/error.hpp"
#include "core/scene/scene_edit.hpp"
#include "core/scene/scene_reference.hpp"
#include "core/scene/scene_writer.hpp"
#include "tests/core/scene/scene_texts.hpp"

namespace mss::testing {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using Path = std::filesystem::path;

Scene load_text(const std::string& text, const std::vector<std::string>& overrides = {}) {
  const SceneFolder folder;
  return load_scene(folder.write("scene.toml", text), overrides);
}

TEST(Scene, OfATextIsThatOfAFileWithIt) {
  EXPECT_EQ(to_json(parse_scene(full_scene, {"solve.dt=3e-4"})),
            to_json(load_text(full_scene, {"solve.dt=3e-4"})));
  try {
    parse_scene("body.cells = [1, 1, 1]\nbody.cell_size = -1\n");
    ADD_FAILURE() << "a negative size was accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), StartsWith("scene:2: body.cell_size = -1 "));
  }
}

TEST(Scene, ReadsTheBody) {
  const BodyConfig body = load_text(full_scene).body;
  EXPECT_THAT(body.voxels.size(), ElementsAre(4, 2, 3));
  EXPECT_EQ(body.voxels.count(), 24U);
  EXPECT_EQ(body.cell_size, 0.25);
  EXPECT_EQ(body.origin, Vec3(0.5, 0, -1));
  EXPECT_EQ(body.topology, Topology::edges_body);
  EXPECT_EQ(body.sharing, Sharing::uniform);
  EXPECT_EQ(body.density, 900);
  EXPECT_EQ(body.springs.edge, 100);
  EXPECT_EQ(body.springs.face, 110.5);
  EXPECT_EQ(body.springs.body, 300);
  EXPECT_EQ(body.springs.volume, -0.1);
  EXPECT_EQ(body.damping.law, Damping::Law::ratio);
  EXPECT_EQ(body.damping.zeta, 0.05);
  ASSERT_EQ(body.weights.size(), 1U);
  EXPECT_EQ(body.weights[0].box.upper, Vec3(1.5, 0.25, -1));
  EXPECT_EQ(body.weights[0].mass, 12);
}

TEST(Scene, ReadsTheEnvironment) {
  const Environment environment = load_text(full_scene).environment;
  EXPECT_EQ(environment.gravity, Vec3(0, 0.5, -9.81));
  ASSERT_EQ(environment.holds.size(), 2U);
  EXPECT_THAT(environment.holds[0].axes, ElementsAre(true, true, true));
  EXPECT_FALSE(environment.holds[0].moves());
  const Hold& hold = environment.holds[1];
  EXPECT_EQ(hold.box.lower, Vec3(1.5, 0, -1));
  EXPECT_EQ(hold.box.upper, Vec3(1.5, 0.5, -0.25));
  EXPECT_THAT(hold.axes, ElementsAre(true, false, true));
  EXPECT_EQ(hold.velocity, Vec3(0, 0, 1));
  EXPECT_EQ(hold.displacement, Vec3(0.1, 0.2, 0.3));
  ASSERT_TRUE(hold.turn.has_value());
  EXPECT_EQ(hold.turn->axis, Vec3(0, 0, 1));
  EXPECT_EQ(hold.turn->centre, Vec3(1.5, 0.25, 0));
  EXPECT_EQ(hold.turn->rate, -1.5);
  EXPECT_EQ(hold.turn->until, 0.75);
  ASSERT_EQ(environment.loads.size(), 1U);
  EXPECT_EQ(environment.loads[0].box.upper, Vec3(1.5, 0, -1));
  EXPECT_EQ(environment.loads[0].force, Vec3(1, 2, 3));
  ASSERT_EQ(environment.strikes.size(), 1U);
  EXPECT_EQ(environment.strikes[0].box.upper, Vec3(0.5, 0.5, -1));
  EXPECT_EQ(environment.strikes[0].at, 0.5);
  EXPECT_EQ(environment.strikes[0].impulse, Vec3(0, 0.25, -2));
}

TEST(Scene, ReadsPlanes) {
  const std::vector<Plane> planes = load_text(full_scene).environment.planes;
  ASSERT_EQ(planes.size(), 2U);
  EXPECT_EQ(planes[0].point, Vec3(0, 0, -2));
  EXPECT_LT((planes[0].normal - Vec3(0, 0.6, 0.8)).norm(), 1e-15);
  EXPECT_EQ(planes[0].contact, ContactLaw::penalty);
  EXPECT_EQ(planes[0].restitution, 0.25);
  EXPECT_EQ(planes[0].friction, 1.5);
  EXPECT_EQ(planes[1].point, Vec3(1, 2, -3));
  EXPECT_EQ(planes[1].contact, ContactLaw::impulse);
  EXPECT_EQ(planes[1].restitution, 0.5);
  EXPECT_EQ(planes[1].friction, 0.4);
  EXPECT_EQ(load_text(full_scene, {"plane.1.contact=thesis"}).environment.planes[1].contact,
            ContactLaw::thesis);
  EXPECT_EQ(load_text(full_scene, {"plane.1.contact=paper"}).environment.planes[1].contact,
            ContactLaw::thesis);  // its name before
}

TEST(Scene, ReadsStartAndSolve) {
  const Scene scene = load_text(full_scene);
  EXPECT_EQ(scene.name, "scene");
  EXPECT_EQ(scene.start_velocity, Vec3(4, 5, 6));
  EXPECT_EQ(scene.start_angular_velocity, Vec3(7, 8, 9));
  EXPECT_EQ(scene.solve.integrator, "velocity_verlet");
  EXPECT_EQ(scene.solve.dt, 2e-4);
  EXPECT_EQ(scene.solve.duration, 3);
  EXPECT_EQ(scene.solve.threads, 2);
  EXPECT_EQ(scene.solve.precision, Precision::single);
  EXPECT_EQ(scene.solve.linear_solver, "matrix_free");
  EXPECT_EQ(scene.solve.nonlinear_solver, "lbfgs");
  EXPECT_EQ(scene.solve.iterations, 5);
  EXPECT_EQ(scene.solve.tangent, Tangent::projected);
  EXPECT_EQ(scene.solve.spectral_radius, 0.5);
  EXPECT_EQ(scene.solve.region_width, 3);
  EXPECT_EQ(scene.solve.alpha, 0.25);
  EXPECT_EQ(scene.solve.tolerance, 1e-5);
  EXPECT_EQ(scene.solve.every, 0.5);
}

TEST(Scene, ReadsKeysByTheNamesTheyHadBefore) {
  const Scene scene = load_text(replaced(plain_scene, "[solve]",
                                         "[damping]\npaper = true\n[start]\nspin = [7, 8, 9]\n[solve]\n"
                                         "acceleration = 0.5"));
  EXPECT_EQ(scene.body.damping.law, Damping::Law::thesis);
  EXPECT_EQ(scene.start_angular_velocity, Vec3(7, 8, 9));
  EXPECT_EQ(scene.solve.chebyshev_radius, 0.5);
  const nlohmann::json json = to_json(scene);
  EXPECT_EQ(json["start"]["angular_velocity"], nlohmann::json({7, 8, 9}));
  EXPECT_EQ(json["solve"]["chebyshev_radius"], 0.5);
  EXPECT_FALSE(json["start"].contains("spin") || json["solve"].contains("acceleration"));
}

TEST(Scene, OverridesByOldNamesTakeThePlaceOfNewOnes) {
  EXPECT_EQ(load_text(full_scene, {"start.spin=[0, 0, 2]"}).start_angular_velocity, Vec3(0, 0, 2));
  EXPECT_EQ(load_text(full_scene, {"start.spin.1=3"}).start_angular_velocity, Vec3(7, 3, 9));
  EXPECT_EQ(load_text(full_scene, {"start={spin=[0, 0, 2]}"}).start_angular_velocity, Vec3(0, 0, 2));
  const std::string old = replaced(full_scene, "angular_velocity =", "spin =");
  EXPECT_EQ(load_text(old, {"start.angular_velocity=[0, 0, 2]"}).start_angular_velocity, Vec3(0, 0, 2));
}

TEST(Scene, FillsInDefaults) {
  const Scene scene = load_text(replaced(plain_scene, "dt = 1e-3", ""));
  EXPECT_EQ(scene.body.origin, Vec3(0, 0, 0));
  EXPECT_EQ(scene.body.topology, Topology::full);
  EXPECT_EQ(scene.body.sharing, Sharing::weighted);
  EXPECT_EQ(scene.body.damping.law, Damping::Law::none);
  EXPECT_TRUE(scene.body.weights.empty());
  EXPECT_EQ(scene.environment.gravity, Vec3(0, 0, 0));
  EXPECT_TRUE(scene.environment.holds.empty());
  EXPECT_TRUE(scene.environment.loads.empty());
  EXPECT_TRUE(scene.environment.planes.empty());
  EXPECT_EQ(scene.start_velocity, Vec3(0, 0, 0));
  EXPECT_EQ(scene.start_angular_velocity, Vec3(0, 0, 0));
  EXPECT_EQ(scene.solve.integrator, "verlet");
  EXPECT_FALSE(scene.solve.dt.has_value());
  EXPECT_EQ(scene.solve.threads, 0);
  EXPECT_EQ(scene.solve.precision, Precision::dbl);
  EXPECT_EQ(scene.solve.linear_solver, "automatic");
  EXPECT_EQ(scene.solve.nonlinear_solver, "newton");
  EXPECT_EQ(scene.solve.iterations, 0);
  EXPECT_EQ(scene.solve.tangent, Tangent::elastic);
  EXPECT_EQ(scene.solve.spectral_radius, 0.9);
  EXPECT_EQ(scene.solve.region_width, 2);
  EXPECT_EQ(scene.solve.alpha, 1);
  EXPECT_EQ(scene.solve.tolerance, 1e-6);
  EXPECT_TRUE(scene.warnings.empty());
}

TEST(Scene, ATurnNeedNotEnd) {
  const Scene scene = load_text(replaced(full_scene, ", until = 0.75", ""));
  EXPECT_EQ(scene.environment.holds[1].turn->until, std::numeric_limits<double>::infinity());
}

TEST(Scene, CalibratesSprings) {
  const SpringConstants half = calibrate({.young = 1e5, .poisson = 0.3}, 0.5, 0.5);
  EXPECT_EQ(load_text(plain_scene).body.springs.edge, half.edge);
  EXPECT_EQ(load_text(plain_scene).body.springs.volume, half.volume);
  const SpringConstants all = calibrate({.young = 1e5, .poisson = 0.3}, 0.5, 1);
  const SpringConstants read = load_text(plain_scene, {"material.face_share=1"}).body.springs;
  EXPECT_EQ(load_text(plain_scene).body.fold_guard, 0);
  EXPECT_EQ(load_text(plain_scene, {"material.fold_guard=5"}).body.fold_guard, 5);
  EXPECT_EQ(read.face, all.face);
  EXPECT_EQ(read.body, 0);
}

TEST(Scene, LeavesTheVolumeForceOut) {
  const SpringConstants with = load_text(plain_scene).body.springs;
  const BodyConfig without = load_text(plain_scene, {"material.volume_force=false"}).body;
  EXPECT_NE(with.volume, 0);
  EXPECT_EQ(without.springs.volume, 0);
  EXPECT_EQ(without.springs.edge, with.edge);
  EXPECT_TRUE(without.elastic.has_value());
}

TEST(Scene, SplitsCells) {
  const BodyConfig body = load_text(plain_scene, {"body.refine=3"}).body;
  EXPECT_THAT(body.voxels.size(), ElementsAre(6, 6, 6));
  EXPECT_EQ(body.voxels.count(), 216U);
  EXPECT_DOUBLE_EQ(body.cell_size, 0.5 / 3);
  EXPECT_DOUBLE_EQ(body.springs.edge, load_text(plain_scene).body.springs.edge / 3);
  const SceneFolder folder;
  folder.write("ell.txt", "#.\n##\n");
  const std::string text = replaced(plain_scene, "cells = [2, 2, 2]", "voxels = \"ell.txt\"\nrefine = 2");
  const Scene scene = load_scene(folder.write("ell.toml", text));
  EXPECT_THAT(scene.body.voxels.size(), ElementsAre(4, 4, 2));
  EXPECT_EQ(scene.body.voxels.count(), 24U);
  EXPECT_FALSE(scene.body.voxels.at(2, 1, 0));
  EXPECT_TRUE(scene.body.voxels.at(2, 2, 0));
}

/// What is written as TOML and read again is the same scene: its configuration, and the bits that follow.
void expect_same_when_read_again(const Scene& scene, const SceneFolder& folder) {
  std::filesystem::create_directory(folder.path() / "again");
  const Scene again =
      load_scene(folder.write("again/" + scene.name + ".toml", to_toml(scene, folder.path() / "again")));
  auto written = to_json(scene), read = to_json(again);
  for (auto* json : {&written, &read}) {  // the same files from another folder
    auto& body = (*json)["body"];
    const auto leave_out = [](auto& one) {
      for (const char* key : {"voxels", "mesh"}) one.erase(key);
    };
    if (body.is_object()) leave_out(body);
    for (auto& one : body)
      if (one.is_object() && body.is_array()) leave_out(one);
    for (auto& part : (*json)["part"]) part.erase("mesh");
  }
  EXPECT_EQ(read, written) << scene.name;
  EXPECT_EQ(again.body.cell_size, scene.body.cell_size) << scene.name;
  EXPECT_EQ(again.body.voxels.size(), scene.body.voxels.size()) << scene.name;
  EXPECT_EQ(again.body.damping.law, scene.body.damping.law) << scene.name;
  EXPECT_EQ(again.body.damping.viscosity, scene.body.damping.viscosity) << scene.name;
  EXPECT_EQ(again.volume_force, scene.volume_force) << scene.name;
  EXPECT_EQ(again.warnings, scene.warnings) << scene.name;
}

TEST(Scene, IsTextAgain) {
  const SceneFolder folder;
  const auto file = folder.write("scene.toml", full_scene);
  expect_same_when_read_again(load_scene(file, {"solve.dt=3e-4", "hold.0.axes=xy", "damping.ratio=0.25"}),
                              folder);
  const auto plain = folder.write("plain.toml", plain_scene);
  for (const char* more : {"body.refine=7", "material.volume_force=false", "material.face_share=1",
                           "damping={ thesis = true }", "damping={ viscosity = 12.5 }", "solve.dt=safe"})
    expect_same_when_read_again(load_scene(plain, {more}), folder);
}

TEST(Scene, AllThatAreShippedAreTextAgain) {
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(Path(MSS_SOURCE_DIR) / "experiments/scenes")) {
    if (entry.path().extension() != ".toml") continue;
    const SceneFolder folder;
    expect_same_when_read_again(load_scene(entry.path()), folder);
    ++scenes;
  }
  EXPECT_GT(scenes, 15);
}

TEST(SceneEdit, ChangesNothingByItself) {
  for (const std::string& text : {plain_scene, full_scene}) {
    const Scene scene = load_text(text, {"material.fold_guard=5"});
    const Scene same = edited(scene, edit_of(scene));
    EXPECT_EQ(to_json(same), to_json(scene));
    EXPECT_EQ(same.body.springs.volume, scene.body.springs.volume);
    EXPECT_EQ(same.warnings, scene.warnings);
  }
}

TEST(SceneEdit, IsWhatAFileCouldSay) {
  const Scene scene = load_text(plain_scene, {"damping.ratio=0.1"});
  SceneEdit edit = edit_of(scene);
  EXPECT_EQ(edit.level, 2);
  edit.level = 6;
  edit.face_share = 1;
  edit.volume_force = false;
  edit.integrator = "rk4";
  edit.dt.reset();
  edit.precision = Precision::single;
  const Scene finer = edited(scene, edit);
  const Scene read =
      load_text(plain_scene, {"body.cells=[6, 6, 6]", fmt::format("body.cell_size={}", 1.0 / 6),
                              "damping.ratio=0.3", "material.face_share=1", "material.volume_force=false",
                              "solve.integrator=rk4", "solve.dt=safe", "solve.precision=single"});
  auto a = to_json(finer), b = to_json(read);
  EXPECT_NEAR(a["damping"]["ratio"].get<double>(), 0.3, 1e-15);
  a.erase("damping");
  b.erase("damping");
  EXPECT_EQ(a, b);
}

// The ratio of other cells changes so that the viscosity stays; a viscosity just stays.
TEST(SceneEdit, KeepsTheViscosityInOtherCells) {
  const Scene scene = load_text(plain_scene, {"damping.viscosity=12.5"});
  SceneEdit edit = edit_of(scene);
  edit.level = 6;
  EXPECT_EQ(edited(scene, edit).body.damping.viscosity, 12.5);
}

TEST(SceneEdit, RefusesCellsThatABoxMisses) {
  const Scene scene = load_text(plain_scene +
                                "[[load]]\nbox = [[0.5, 0.5, 0.5], [0.5, 0.5, 0.5]]\n"
                                "force = [1, 0, 0]\n");
  SceneEdit edit = edit_of(scene);
  edit.level = 1;
  EXPECT_THROW(edited(scene, edit), InputError);
}

TEST(Scene, ReadsFourKindsOfDampingAndSafeSteps) {
  const Damping viscous = load_text(plain_scene + "[damping]\nviscosity = 12.5").body.damping;
  EXPECT_EQ(viscous.law, Damping::Law::viscosity);
  EXPECT_EQ(viscous.viscosity, 12.5);
  EXPECT_EQ(load_text(plain_scene + "[damping]\nviscosity = 0").body.damping.law, Damping::Law::none);
  EXPECT_EQ(load_text(plain_scene + "[damping]\nthesis = true").body.damping.law, Damping::Law::thesis);
  EXPECT_EQ(load_text(plain_scene + "[damping]\npaper = true").body.damping.law, Damping::Law::thesis);
  EXPECT_EQ(load_text(plain_scene + "[damping]\npaper = false\nratio = 1").body.damping.law,
            Damping::Law::ratio);
  EXPECT_EQ(load_text(plain_scene + "[damping]\nratio = 0").body.damping.law, Damping::Law::none);
  EXPECT_FALSE(load_text(replaced(plain_scene, "1e-3", "\"safe\"")).solve.dt.has_value());
  EXPECT_EQ(load_text(replaced(full_scene, "edges+body", "one-diagonal")).body.topology,
            Topology::one_diagonal);
}

TEST(Scene, FindsVoxelFilesBesideItself) {
  const SceneFolder folder;
  folder.write("shape.txt", "##.\n#..\n\n#..\n...\n");
  const Path file =
      folder.write("scene.toml", replaced(plain_scene, "cells = [2, 2, 2]", "voxels = \"shape.txt\""));
  const Scene scene = load_scene(file);
  EXPECT_THAT(scene.body.voxels.size(), ElementsAre(3, 2, 2));
  EXPECT_EQ(scene.body.voxels.count(), 4U);
  EXPECT_TRUE(scene.body.voxels.at(1, 0, 0));
  EXPECT_TRUE(scene.body.voxels.at(0, 1, 0));
  EXPECT_FALSE(scene.body.voxels.at(0, 1, 1));
}

/// Makes `folder` the current one, until it ends.
class StandingIn {
 public:
  explicit StandingIn(const Path& folder) : before_(std::filesystem::current_path()) {
    std::filesystem::current_path(folder);
  }
  ~StandingIn() { std::filesystem::current_path(before_); }
  StandingIn(const StandingIn&) = delete;
  StandingIn& operator=(const StandingIn&) = delete;

 private:
  Path before_;
};

TEST(Scene, LooksForFilesOfTheCommandLineInTheCurrentFolderFirst) {
  const SceneFolder scenes, here;
  const Path file =
      scenes.write("scene.toml", replaced(plain_scene, "cells = [2, 2, 2]", "voxels = \"a.txt\""));
  scenes.write("a.txt", "#\n");
  scenes.write("b.txt", "##\n");
  here.write("a.txt", "###\n");
  const StandingIn there(here.path());
  const auto count = [&](const std::vector<std::string>& settings) {
    return load_scene(file, settings).body.voxels.count();
  };
  EXPECT_EQ(count({}), 1U);
  EXPECT_EQ(count({"body.voxels=a.txt"}), 3U);
  EXPECT_EQ(count({"body.voxels=b.txt"}), 2U);
  EXPECT_THROW(count({"body.voxels=c.txt"}), InputError);
}

/// Cells of two parts and of tenths.
const std::string mixed_scene = replaced(plain_scene, "cells = [2, 2, 2]", "voxels = \"mixed.txt\"") +
                                R"([damping]
ratio = 0.1
[[part]]
name = "A"
young = 2e5
[[part]]
name = "B"
density = 2000
young = 3e5
poisson = 0.2
damping = { viscosity = 7 }
)";

TEST(Scene, ReadsFillsAndParts) {
  const SceneFolder folder;
  folder.write("mixed.txt", "#A\n5B\n\n.A\n55\n");
  const Scene scene = load_scene(folder.write("scene.toml", mixed_scene));
  const BodyConfig& body = scene.body;
  ASSERT_EQ(body.parts.size(), 2U);
  const Part &a = body.parts[0], &b = body.parts[1];
  EXPECT_EQ(a.density, 1000);
  EXPECT_EQ(a.elastic->poisson, 0.3);
  EXPECT_EQ(a.springs.edge, 2 * body.springs.edge);
  EXPECT_EQ(a.damping.zeta, 0.1);
  EXPECT_EQ(b.density, 2000);
  EXPECT_EQ(b.springs.edge, calibrate({.young = 3e5, .poisson = 0.2}, 0.5, 0.5).edge);
  EXPECT_EQ(b.damping.law, Damping::Law::viscosity);
  EXPECT_EQ(b.damping.viscosity, 7);
  const auto content = [&](int i, int j, int k) {
    const CellContent& all = body.contents[body.content_of[body.voxels.index(i, j, k)]];
    EXPECT_EQ(all.size(), 1U);
    return std::pair(all[0].part, all[0].fill.share());
  };
  EXPECT_EQ(body.contents.size(), 4U);
  EXPECT_EQ(content(0, 0, 0), std::pair(0, 1.0F));
  EXPECT_EQ(content(1, 0, 0), std::pair(1, 1.0F));
  EXPECT_EQ(content(0, 1, 0), std::pair(0, 0.5F));
  EXPECT_EQ(content(1, 1, 0), std::pair(2, 1.0F));
  EXPECT_EQ(content(1, 1, 1), std::pair(0, 0.5F));
  EXPECT_FALSE(body.voxels.at(0, 0, 1));
  EXPECT_NEAR(Body(body).total_mass(), 0.125 * (1000 * (1 + 2 + 1.5) + 2000), 1e-9);
  EXPECT_THAT(scene.warnings, ElementsAre(HasSubstr("part \"B\": the volume stiffness is negative")));
  expect_same_when_read_again(scene, folder);
}

TEST(Scene, SplitsFillsAndParts) {
  const SceneFolder folder;
  folder.write("mixed.txt", "#A\n5B\n");
  const auto file = folder.write("scene.toml", mixed_scene);
  const Scene coarse = load_scene(file), fine = load_scene(file, {"body.refine=2"});
  EXPECT_NEAR(Body(fine.body).total_mass(), Body(coarse.body).total_mass(), 1e-9);
  EXPECT_EQ(fine.body.content_of[fine.body.voxels.index(3, 1, 1)], coarse.body.content_of[1]);
  EXPECT_EQ(fine.body.content_of[fine.body.voxels.index(1, 2, 0)], coarse.body.content_of[2]);
  SceneEdit edit = edit_of(coarse);
  edit.level = 2;
  const Scene edited_fine = edited(coarse, edit);
  EXPECT_EQ(edited_fine.body.content_of, fine.body.content_of);
  EXPECT_EQ(edited_fine.body.parts[0].springs.edge, fine.body.parts[0].springs.edge);
  EXPECT_EQ(edited_fine.body.parts[0].damping.zeta, 2 * fine.body.parts[0].damping.zeta);  // keeps viscosity
  edit = edit_of(fine);
  edit.level = 1;
  EXPECT_EQ(edited(fine, edit).body.content_of, coarse.body.content_of);
}

TEST(Scene, ReadsWhatSmallerCellsAreChosenFor) {
  const SceneFolder folder;
  const Scene scene = load_scene(
      folder.write("scene.toml", plain_scene + R"([expect]
displacement = { box = [[0, 0, 1], [1, 1, 1]], value = [0, 0, 0], within = 1 }
)"),
      {"body.refinement=\"auto\"", "body.refinement_levels=2", "body.refinement_goal=\"displacement\""});
  ASSERT_TRUE(scene.auto_refinement);
  EXPECT_EQ(scene.auto_refinement->levels, 2);
  EXPECT_EQ(scene.auto_refinement->goal, AutoRefinement::Goal::displacement);
  EXPECT_TRUE(is_refined(scene));
  EXPECT_THROW(refined_body(scene), InputError);
  EXPECT_EQ(to_json(scene)["body"]["refinement"], "auto");
  expect_same_when_read_again(scene, folder);
  const Scene plain = load_text(plain_scene, {"body.refinement=\"auto\""});
  EXPECT_EQ(plain.auto_refinement->levels, 1);
  EXPECT_EQ(plain.auto_refinement->goal, AutoRefinement::Goal::energy);
  EXPECT_FALSE(is_refined(load_text(plain_scene)));
}

TEST(Scene, ReadsWhereCellsAreSmaller) {
  const SceneFolder folder;
  const Scene scene = load_scene(folder.write("scene.toml", plain_scene + R"([[refine]]
box = [[0, 0, 0], [0.4, 1, 1]]
[[refine]]
box = [[0, 0, 0], [0.1, 0.1, 0.1]]
levels = 3
[[hold]]
box = [[0, 0.0625, 0], [0, 0.0625, 0]]
)"));
  ASSERT_EQ(scene.refined_boxes.size(), 2U);
  EXPECT_EQ(scene.refined_boxes[0].levels, 1);
  EXPECT_EQ(scene.refined_boxes[0].box.upper, Vec3(0.4, 1, 1));
  EXPECT_EQ(scene.refined_boxes[1].levels, 3);
  const std::unique_ptr<const RefinedBody> body = refined_body(scene);
  ASSERT_EQ(body->levels().size(), 4U);
  EXPECT_EQ(body->levels()[3].body.config().cell_size, 0.0625);
  EXPECT_EQ(refined_body(load_text(plain_scene)), nullptr);
  EXPECT_EQ(to_json(scene)["refine"][1]["levels"], 3);
  expect_same_when_read_again(scene, folder);
}

TEST(Scene, WarnsOfContrastsThatItsCellsCannotResolve) {
  const SceneFolder folder;
  const auto file = folder.write("scene.toml", mixed_scene);
  const std::vector<std::string> stiff{"part.0.young=2e8", "part.1.poisson=0.3"};
  const auto warnings_of = [&](const char* cells, const std::vector<std::string>& overrides) {
    folder.write("mixed.txt", cells);
    return load_scene(file, overrides).warnings;
  };
  EXPECT_THAT(warnings_of("#AB\n", stiff),
              ElementsAre(HasSubstr("\"A\" is 2e+03 times as stiff as [material]")));
  EXPECT_THAT(warnings_of("#BA\n", stiff),
              ElementsAre());  // 667 times as stiff as B, and not beside the first
  EXPECT_THAT(warnings_of("#A\n5B\n", {"part.0.young=9e7", "part.1.poisson=0.3"}), ElementsAre());
}

TEST(Scene, ReadsItsModel) {
  const Scene springs = load_text(plain_scene);
  EXPECT_EQ(springs.model, "springs");
  EXPECT_EQ(springs.body.elastic->young, 1e5);
  // A model without springs has no warnings about them.
  const Scene elements = load_text(plain_scene, {"material.model=linear", "material.poisson=0.1"});
  EXPECT_EQ(elements.model, "linear");
  EXPECT_EQ(elements.body.elastic->poisson, 0.1);
  EXPECT_TRUE(elements.warnings.empty());
  EXPECT_EQ(to_json(elements)["material"]["model"], "linear");
}

TEST(Scene, WarnsAboutMaterials) {
  const std::string springs = "springs = { edge = 100, face = 100, body = 300 }\nvolume = 0.1";
  const std::string anisotropic = replaced(plain_scene, "young = 1e5\npoisson = 0.3", springs);
  EXPECT_THAT(load_text(anisotropic).warnings,
              ElementsAre(HasSubstr("Zener ratio 5"), HasSubstr("percent of shear")));
  EXPECT_THAT(load_text(plain_scene, {"material.poisson=0.1"}).warnings,
              ElementsAre(AllOf(HasSubstr("volume stiffness is negative"), HasSubstr("percent of tension"))));
  EXPECT_THAT(load_text(plain_scene, {"body.sharing=uniform"}).warnings,
              ElementsAre(HasSubstr("\"weighted\"")));
  EXPECT_THAT(load_text(plain_scene, {"body.topology=edges+body"}).warnings,
              ElementsAre(HasSubstr("softer in shear")));
}

TEST(Scene, KeepsPathsAndHistories) {
  const Scene scene =
      load_text(plain_scene, {"hold=[{box=[[0,0,0],[1,1,0]], path=[[0,0,0,0],[1.5,0,0,2]]}]",
                              "load=[{box=[[0,0,1],[1,1,1]], force=[1,0,0], history=[[0.5,0],[2,-1]]}]"});
  const Hold& hold = scene.environment.holds.front();
  ASSERT_EQ(hold.path.points.size(), 2U);
  EXPECT_EQ(hold.path.at(0.75), Vec3(0, 0, 1));
  EXPECT_EQ(scene.environment.loads.front().history.at(1.25), -0.5);
  const nlohmann::ordered_json json = to_json(scene);
  EXPECT_EQ(json["hold"][0]["path"], nlohmann::ordered_json::parse("[[0.0,0.0,0.0,0.0],[1.5,0.0,0.0,2.0]]"));
  EXPECT_EQ(json["load"][0]["history"], nlohmann::ordered_json::parse("[[0.5,0.0],[2.0,-1.0]]"));
  EXPECT_FALSE(
      to_json(load_text(plain_scene, {"load=[{box=[[0,0,0],[1,1,0]],force=[1,0,0]}]"}))["load"][0].contains(
          "history"));
}

TEST(Scene, WarnsOfWhatContradictsOrDoesNothing) {
  const auto warnings = [](const std::string& holds, const std::string& more) {
    return load_text(plain_scene, {"hold=[" + holds + "]", more}).warnings;  // a cube of 1 m
  };
  const std::string below = "{box=[[0,0,0],[1,1,0]]}", none = "start.velocity=[0,0,0]";
  EXPECT_THAT(warnings(below + ",{box=[[0,0,0],[0,1,1]], velocity=[1,0,0]}", none),
              ElementsAre(AllOf(HasSubstr("hold.0 and hold.1"), HasSubstr("they obey hold.1"))));
  EXPECT_THAT(warnings(below + ",{box=[[0,0,0],[0,1,1]], path=[[0,0,0,0],[1,0,1,0]]}", none),
              ElementsAre(HasSubstr("hold.0 and hold.1")));
  EXPECT_THAT(warnings(below + ",{box=[[0,0,0],[1,1,1]], velocity=[0,0,1]}", none),
              ElementsAre(HasSubstr("hold.0 and hold.1")));
  EXPECT_THAT(warnings(below + ",{box=[[0,0,0.5],[1,1,1]]},{box=[[1,0,0],[1,1,1]], velocity=[0,1,0]}", none),
              Contains(HasSubstr("hold.0 and hold.2")));
  EXPECT_THAT(warnings(below + "," + below, none), ElementsAre());  // the same
  EXPECT_THAT(
      warnings("{box=[[0,0,0],[1,1,0]],axes='x'},{box=[[0,0,0],[1,1,0]],axes='y',velocity=[0,1,0]}", none),
      ElementsAre());
  EXPECT_THAT(warnings(below + ",{box=[[0,0,1],[1,1,1]], velocity=[0,0,1]}", none), ElementsAre());
  EXPECT_THAT(warnings(below, "load=[{box=[[0,0,0],[1,1,0]], force=[1,0,0]}]"),
              ElementsAre(AllOf(HasSubstr("load.0"), HasSubstr("hold.0"))));
  EXPECT_THAT(warnings(below, "load=[{box=[[0,0,0],[0,1,0]], force=[0,0,-1]}]"),
              ElementsAre(AllOf(HasSubstr("load.0"), HasSubstr("hold.0"))));
  EXPECT_THAT(warnings(below, "load=[{box=[[0,0,0],[1,1,0]], force=[1,0,0], history=[[0,0],[1,1]]}]"),
              ElementsAre(HasSubstr("load.0")));
  EXPECT_THAT(warnings("{box=[[0,0,0],[1,1,0]],axes='z'}", "load=[{box=[[0,0,0],[1,1,0]], force=[0,0,1]}]"),
              ElementsAre(HasSubstr("load.0")));
  EXPECT_THAT(warnings("{box=[[0,0,0],[1,1,0]],axes='z'}", "load=[{box=[[0,0,0],[1,1,0]], force=[1,0,0]}]"),
              ElementsAre());
  EXPECT_THAT(warnings(below, "load=[{box=[[0,0,1],[1,1,1]], force=[1,0,0]}]"), ElementsAre());
}

TEST(Scene, WarnsOfAFallThatNothingStops) {
  const auto warnings = [](const std::string& normal, const std::string& more = "start.velocity=[0,0,0]") {
    return load_text(plain_scene, {"plane=[{point=[0,0,-1], normal=" + normal + "}]",
                                   "environment.gravity=[0,0,-9.81]", more})
        .warnings;
  };
  EXPECT_THAT(warnings("[0,0,1]"), ElementsAre());
  EXPECT_THAT(warnings("[1,0,0.01]"), ElementsAre());
  EXPECT_THAT(warnings("[1,0,0]", "body.origin=[1,0,0]"), ElementsAre(HasSubstr("falls for ever")));
  EXPECT_THAT(warnings("[0,0,-1]", "body.origin=[0,0,-3]"), ElementsAre(HasSubstr("falls for ever")));
  EXPECT_THAT(warnings("[0,1,0]", "body.origin=[0,1,0]"), ElementsAre(HasSubstr("falls for ever")));
  EXPECT_THAT(warnings("[0,0,1]", "environment.gravity=[0,0,9.81]"),
              ElementsAre(HasSubstr("falls for ever")));
  EXPECT_THAT(warnings("[1,0,0]", "hold=[{box=[[0,0,0],[1,1,0]]}]"), ElementsAre());
}

TEST(Scene, WarnsOfMillimetres) {
  EXPECT_THAT(load_text(plain_scene, {"body.cell_size=250"}).warnings,
              ElementsAre(HasSubstr("metres, kilograms and seconds")));
  EXPECT_THAT(load_text(plain_scene, {"body.cell_size=1", "body.cells=[1,60,1]"}).warnings,
              ElementsAre(HasSubstr("metres, kilograms and seconds")));
  EXPECT_THAT(load_text(plain_scene, {"body.cell_size=20", "body.cells=[3,3,3]"}).warnings,
              ElementsAre(HasSubstr("give body.cell_size a thousandth")));
  EXPECT_THAT(load_text(plain_scene, {"body.cell_size=20"}).warnings,  // 40 m, and 64,000 t
              ElementsAre(HasSubstr("kg: scenes are in metres")));
  EXPECT_THAT(load_text(plain_scene, {"material.density=1e9"}).warnings,
              ElementsAre(HasSubstr("give it in kg/m^3")));
  EXPECT_THAT(load_text(plain_scene, {"body.cell_size=1e-5"}).warnings,
              Contains(HasSubstr(
                  "so small a body takes very short steps; if it was meant larger, give body.cell_size")));
}

TEST(Scene, WarnsOfAStartBehindAPlane) {
  const auto warnings = [](const std::string& plane, std::vector<std::string> more = {}) {
    more.push_back("plane=[{" + plane + "}]");
    return load_text(plain_scene, more).warnings;  // a cube of 1 m
  };
  const std::string ground = "normal=[0,0,1],point=[0,0,";
  EXPECT_THAT(warnings(ground + "0]"), ElementsAre());
  EXPECT_THAT(
      warnings(ground + "0.05]"),
      ElementsAre(HasSubstr("plane.0: 5 percent of the body start behind it, up to 0.05 m deep: it is "
                            "pushed out")));
  EXPECT_THAT(warnings(ground + "0.75],contact='penalty'"),
              ElementsAre(AllOf(HasSubstr("75 percent"), HasSubstr("throw it out"))));
  EXPECT_THAT(warnings(ground + "0.25],contact='thesis'"), ElementsAre(HasSubstr("leaves it there")));
  EXPECT_THAT(warnings(ground + "1]"), ElementsAre(HasSubstr("the whole body starts behind it")));
  EXPECT_THAT(warnings(ground + "0.05]", {"hold=[{box=[[0,0,0],[1,1,0]]}]"}), ElementsAre());
}

TEST(Scene, WarnsThatRestitutionIsAParticles) {
  const auto warnings = [](const std::string& keys, const std::string& cells = "[2,2,2]") {
    return load_text(plain_scene,
                     {"body.cells=" + cells, "plane=[{point=[0,0,0],normal=[0,0,1]," + keys + "}]"})
        .warnings;
  };
  EXPECT_THAT(warnings("restitution=0.7"),
              ElementsAre(HasSubstr("plane.0.restitution = 0.7 is that of each particle, not of the body")));
  EXPECT_THAT(warnings("restitution=0.7", "[1,1,1]"), ElementsAre());
  EXPECT_THAT(warnings("friction=0.3"), ElementsAre());
  EXPECT_THAT(warnings("restitution=0.7,contact='penalty'"), ElementsAre());
}

TEST(Scene, IsWrittenWithDefaultsFilledIn) {
  const nlohmann::json plain = to_json(load_text(replaced(plain_scene, "dt = 1e-3", "")));
  EXPECT_EQ(plain["body"]["cells"], nlohmann::json({2, 2, 2}));
  EXPECT_EQ(plain["body"]["topology"], "full");
  EXPECT_EQ(plain["material"]["young"], 1e5);
  EXPECT_EQ(plain["material"]["springs"]["face"], calibrate({.young = 1e5, .poisson = 0.3}, 0.5, 0.5).face);
  EXPECT_EQ(plain["damping"]["ratio"], 0);
  EXPECT_EQ(plain["hold"], nlohmann::json::array());
  EXPECT_EQ(plain["solve"]["dt"], "safe");
  const nlohmann::json full = to_json(load_text(full_scene));
  EXPECT_FALSE(full["material"].contains("young"));
  EXPECT_EQ(full["material"]["volume"], -0.1);
  EXPECT_EQ(full["environment"]["gravity"], nlohmann::json({0, 0.5, -9.81}));
  EXPECT_EQ(full["hold"][1]["axes"], "xz");
  EXPECT_EQ(full["hold"][1]["box"], nlohmann::json({{1.5, 0, -1}, {1.5, 0.5, -0.25}}));
  EXPECT_EQ(full["hold"][1]["turn"]["until"], 0.75);
  EXPECT_EQ(full["load"][0]["force"], nlohmann::json({1, 2, 3}));
  EXPECT_EQ(full["strike"][0]["impulse"], nlohmann::json({0, 0.25, -2}));
  EXPECT_EQ(full["plane"][0]["contact"], "penalty");
  EXPECT_EQ(full["plane"][0]["normal"][1], 3.0 / 5);
  EXPECT_EQ(full["plane"][1], nlohmann::json({{"point", {1, 2, -3}},
                                              {"normal", {0, 0, 1}},
                                              {"contact", "impulse"},
                                              {"restitution", 0.5},
                                              {"friction", 0.4}}));
  EXPECT_EQ(full["start"]["angular_velocity"], nlohmann::json({7, 8, 9}));
  EXPECT_EQ(full["solve"]["dt"], 2e-4);
}

TEST(Scene, ReadsSheetsAndRopes) {
  const Scene sheet = load_text(plain_scene, {"body.cells=[3, 0, 2]", "body.thickness=0.01", "body.refine=2",
                                              "material.poisson=0.333"});
  EXPECT_EQ(sheet.body.voxels.size(), (std::array{6, 0, 4}));
  EXPECT_EQ(sheet.body.across(), 0.01);
  EXPECT_NEAR(sheet.body.springs.face, 3.0 / 8 * 1e5 * 0.01, 1e-9);
  EXPECT_EQ(sheet.body.springs.body, 0);
  EXPECT_EQ(sheet.body.springs.volume, 0);
  EXPECT_THAT(sheet.warnings, ElementsAre());
  const Scene rope = load_text(plain_scene, {"body.cells=[0, 0, 5]"});
  EXPECT_EQ(rope.body.across(), 0.5) << "a cell's edge where it is not said";
  EXPECT_NEAR(rope.body.springs.edge, 1e5 * 0.5, 1e-6);
  EXPECT_THAT(rope.warnings,
              ElementsAre(HasSubstr("body.thickness is missing and taken as body.cell_size, 0.5 m: a rope"),
                          HasSubstr("material.poisson = 0.3 is not used: a rope")));
  EXPECT_THAT(load_text(plain_scene, {"body.cells=[1, 1, 0]", "body.thickness=0.5"}).warnings,
              ElementsAre(HasSubstr("material.poisson = 0.3 is not used: springs of a sheet make it 1/3")));
  const std::string given = replaced(plain_scene, "young = 1e5\npoisson = 0.3", "springs = { edge = 7 }");
  EXPECT_EQ(load_text(given, {"body.cells=[5, 0, 0]"}).body.springs.edge, 7);
  EXPECT_THAT(
      load_text(given, {"body.cells=[5, 2, 0]", "body.thickness=0.5", "material.springs.face=0"}).warnings,
      ElementsAre(HasSubstr("do not resist shear")));
}

TEST(Scene, WritesSheetsAndRopes) {
  for (const char* cells : {"body.cells=[3, 0, 2]", "body.cells=[0, 4, 0]"}) {
    const Scene scene = load_text(plain_scene, {cells, "body.thickness=0.01", "body.refine=3"});
    const Scene again = parse_scene(to_toml(scene, "."));
    EXPECT_EQ(to_json(again)["body"], to_json(scene)["body"]);
    EXPECT_EQ(again.body.springs.edge, scene.body.springs.edge);
    EXPECT_THAT(again.warnings, ElementsAre());
    SceneEdit finer = edit_of(scene);
    finer.level *= 2;
    const Scene edited_scene = edited(scene, finer);
    EXPECT_EQ(edited_scene.body.voxels.dimensions(), scene.body.voxels.dimensions());
    EXPECT_EQ(edited_scene.body.across(), 0.01);
    EXPECT_NEAR(edited_scene.body.young_of(edited_scene.body.springs, 1), 1e5, 1e-6);
  }
}

TEST(Scene, ReadsItsExpectations) {
  const std::string expect =
      "\n[expect]\nmax_stretch = { value = 0.5, within = 0.25 }\nhold_1_z = { value = -3, within = 0.5 }\n"
      "displacement = { box = [[0.5, 0, -1], [1.5, 0.5, -1]], value = [1, 2, 3], within = 0 }\n";
  const Scene scene = load_text(full_scene + expect);
  ASSERT_EQ(scene.expectations.size(), 3U);
  EXPECT_EQ(scene.expectations[2].quantity, "hold_1_z");
  EXPECT_THAT(scene.expectations[2].value, ElementsAre(-3));
  const Expectation& moved = scene.expectations[0];
  EXPECT_EQ(moved.quantity, mean_displacement);
  EXPECT_THAT(moved.value, ElementsAre(1, 2, 3));
  EXPECT_EQ(moved.box.upper, Vec3(1.5, 0.5, -1));
  EXPECT_EQ(scene.expectations[1].quantity, "max_stretch");
  EXPECT_THAT(scene.expectations[1].value, ElementsAre(0.5));
  EXPECT_EQ(scene.expectations[1].within, 0.25);
  const nlohmann::json json = to_json(scene)["expect"];
  EXPECT_EQ(json["max_stretch"]["value"], 0.5);
  EXPECT_EQ(json["displacement"]["value"][2], 3);
  EXPECT_TRUE(load_text(full_scene).expectations.empty());
}

TEST(Scene, ReadsExpectationsByTheNamesThatColumnsHadBefore) {
  const Scene scene = load_text(plain_scene +
                                    "[expect]\nspin_y = { value = 2, within = 0.5 }\n"
                                    "gravitational = { value = 3, within = 0.25 }\n",
                                {"expect.spin_y.value=1"});
  ASSERT_EQ(scene.expectations.size(), 2U);
  EXPECT_EQ(scene.expectations[0].quantity, "external_potential");
  EXPECT_THAT(scene.expectations[0].value, ElementsAre(3));
  EXPECT_EQ(scene.expectations[1].quantity, "angular_momentum_y");
  EXPECT_THAT(scene.expectations[1].value, ElementsAre(1));
  EXPECT_EQ(scene.expectations[1].within, 0.5);
}

TEST(Scene, OverridesComeBeforeChecks) {
  const std::string wrong = replaced(plain_scene, "density = 1000", "density = -1");
  EXPECT_EQ(load_text(wrong, {"material.density=5"}).body.density, 5);
  EXPECT_EQ(load_text(plain_scene, {"material.density=5", "material.density=6"}).body.density, 6);
  EXPECT_EQ(load_text(plain_scene, {" start.angular_velocity = [0, 0, 2] "}).start_angular_velocity,
            Vec3(0, 0, 2));
  EXPECT_EQ(load_text(plain_scene, {"solve.integrator=rk4"}).solve.integrator, "rk4");
  EXPECT_EQ(load_text(plain_scene, {"solve.integrator=\"rk4\""}).solve.integrator, "rk4");
  EXPECT_FALSE(load_text(plain_scene, {"solve.dt=safe"}).solve.dt.has_value());
}

TEST(Scene, OverridesReachIntoArrays) {
  const std::vector<std::string> overrides{"hold.1.velocity=[0, 0, 7]", "hold.1.displacement.2 = 9",
                                           "hold.0.turn.axis=[1,0,0]", "hold.0.turn.centre=[0,0,0]",
                                           "hold.0.turn.rate=3"};
  const auto holds = load_text(full_scene, overrides).environment.holds;
  EXPECT_EQ(holds[1].velocity, Vec3(0, 0, 7));
  EXPECT_EQ(holds[1].displacement, Vec3(0.1, 0.2, 9));
  ASSERT_TRUE(holds[0].turn.has_value());
  EXPECT_EQ(holds[0].turn->rate, 3);
}

TEST(Scene, AllThatAreShippedLoad) {
  const Path scenes = Path(MSS_SOURCE_DIR) / "experiments" / "scenes";
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(scenes)) {
    if (entry.path().extension() != ".toml") continue;
    std::ifstream in(entry.path());
    std::string comment;
    std::getline(in, comment);
    EXPECT_THAT(comment, StartsWith("# ")) << entry.path() << ": `mss list scenes` shows the first line";
    names.insert(load_scene(entry.path()).name);
  }
  for (const auto* name : {"fig5_1_stretch", "fig5_1_compress", "fig5_1_twist", "cantilever"})
    EXPECT_EQ(names.count(name), 1U) << name;
}

TEST(SceneKeys, HaveTheReferenceThatTheirReadmeShows) {
  std::ifstream file(MSS_SOURCE_DIR "/core/scene/README.md");
  const std::string readme{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(readme.find(scene_reference()), std::string::npos)
      << "core/scene/README.md is to contain what follows\n"
      << scene_reference();
}

}  // namespace
}  // namespace mss::testing

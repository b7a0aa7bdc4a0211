// Reduced bodies as scenes have them: their files, what a run says of them, and going on.
#include "experiments/simulation/reduced_model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "core/base/error.hpp"
#include "experiments/harness/progress.hpp"
#include "experiments/simulation/diagnostics.hpp"
#include "experiments/simulation/restart.hpp"
#include "experiments/simulation/simulation.hpp"
#include "experiments/view/session.hpp"
#include "tests/core/scene/scene_texts.hpp"

namespace mss {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const std::string held_beam = R"([body]
cells = [16, 4, 4]
cell_size = 0.0625
[material]
model = "modal"
density = 1000
young = 1e7
poisson = 0.3
[damping]
viscosity = 307.7
[environment]
gravity = [0, 0, -4.358]
[[hold]]
box = [[0, 0, 0], [0, 1, 1]]
[solve]
integrator = "reduced"
duration = 0.25
every = 0.0125
)";

std::string said(const Scene& scene) {
  Progress progress;
  const SimulationResult result = simulate(scene, progress);
  EXPECT_EQ(result.status, Status::ok);
  std::string all;
  for (const std::string& sentence : diagnostics_of(scene, result)) all += sentence + "\n";
  return all;
}

std::string said_of(const std::string& model, double gravity, const std::vector<std::string>& more = {}) {
  std::vector<std::string> settings{"material.model=\"" + model + "\"",
                                    "environment.gravity=[0,0," + std::to_string(-gravity) + "]"};
  settings.insert(settings.end(), more.begin(), more.end());
  return said(parse_scene(held_beam, settings));
}

TEST(ReducedModel, SaysNothingWhereItIsGood) {
  EXPECT_EQ(said_of("modal", 4.358), "");
  EXPECT_EQ(said_of("modal_cubic", 32.85), "");
  EXPECT_EQ(said_of("modal_warped", 32.85), "");
}

TEST(ReducedModel, WarnsWhereItIsNot) {
  EXPECT_THAT(said_of("modal", 151.1), HasSubstr("modal is at its end"));
  EXPECT_THAT(said_of("modal", 32.85), HasSubstr("modal is at its end"));
  EXPECT_THAT(said_of("modal_cubic", 151.1), HasSubstr("modal_cubic is at its end"));
  EXPECT_THAT(said_of("modal_warped", 151.1), HasSubstr("modal_warped is at its end"));
  const std::vector<std::string> plane{"plane=[{point=[0,0,-0.02],normal=[0,0,1],contact=\"penalty\"}]"};
  for (const char* model : {"modal", "modal_cubic", "modal_warped"})
    EXPECT_THAT(said_of(model, 32.85, plane), HasSubstr("a plane pushes the body")) << model;
}

TEST(ReducedModel, WarnsOfTwistThatCubicShapesDoNotFollow) {
  const std::vector<std::string> couple{
      "load=[{box=[[1,0,0],[1,0.25,0]],force=[0,3000,0]},{box=[[1,0,0.25],[1,0.25,0.25]],force=[0,-3000,0]}"
      "]"};
  EXPECT_THAT(said_of("modal_cubic", 0, couple), HasSubstr("the body twists by"));
  EXPECT_THAT(said_of("modal_warped", 0, couple), Not(HasSubstr("twists")));
}

TEST(ReducedModel, WarnsOfFastSpin) {
  const std::string cube = R"([body]
cells = [6, 6, 6]
cell_size = 0.1666666666666667
[material]
model = "modal"
density = 1000
young = 1e6
poisson = 0.3
[solve]
integrator = "reduced"
duration = 0.5
every = 0.025
[start]
)";
  EXPECT_EQ(said(parse_scene(cube + "angular_velocity = [1, 2, 2]\n")), "");
  EXPECT_THAT(said(parse_scene(cube + "angular_velocity = [7, 13, 20]\n")),
              HasSubstr("spinning or deforming that much"));
}

TEST(ReducedModel, KeepsItsShapesBesideTheScene) {
  const testing::SceneFolder folder;
  const auto file = folder.path() / "beam.toml";
  std::ofstream(file) << held_beam;
  Scene scene = load_scene(file);
  const auto kept = shapes_file(scene);
  EXPECT_EQ(kept, folder.path() / "beam.shapes");
  const auto first_x = [&](const Scene& of) {
    const Body body(of.body);
    const auto system = make_reduced(of, body);
    State<double> state = system->rest_state();
    system->reduced()->take(state);
    EXPECT_TRUE(system->reduced()->step(0.1, 1));
    system->reduced()->give(state);
    return state.x.at(body.sites().back());
  };
  const Vec3 computed = first_x(scene);
  ASSERT_TRUE(std::filesystem::exists(kept));
  const auto written = std::filesystem::last_write_time(kept);
  EXPECT_EQ(first_x(scene), computed);
  EXPECT_EQ(std::filesystem::last_write_time(kept), written) << "it was computed again";
  std::filesystem::resize_file(kept, std::filesystem::file_size(kept) / 2);
  EXPECT_EQ(first_x(scene), computed) << "a file cut short";
  const Scene softer = load_scene(file, {"material.young=1e6"});
  EXPECT_NE(first_x(softer), computed) << "shapes of another body";
  EXPECT_TRUE(shapes_file(parse_scene(held_beam)).empty());
}

TEST(ReducedModel, GoesOnWithTheSameBits) {
  const testing::SceneFolder folder;
  for (const char* model : {"modal", "modal_warped", "modal_cubic"}) {
    const std::vector<std::string> settings{std::string("material.model=\"") + model + "\""};
    std::vector<std::string> shorter = settings;
    shorter.push_back("solve.duration=0.1");
    const auto run = [&](const std::vector<std::string>& with, Restart* from) {
      Progress progress;
      return simulate(parse_scene(held_beam, with), progress, {}, {},
                      {.from = from, .keep = [&](const Restart& left) {
                         write_restart(folder.path() / restart_file, left);
                       }});
    };
    const SimulationResult whole = run(settings, nullptr);
    run(shorter, nullptr);
    Restart left = read_restart(folder.path());
    const SimulationResult parts = run(settings, &left);
    ASSERT_EQ(whole.particles.size(), parts.particles.size());
    for (std::size_t i = 0; i < whole.particles.size(); ++i)
      EXPECT_EQ(whole.particles[i].x, parts.particles[i].x) << model;
  }
}

TEST(ReducedModel, IsShownInTheWindowAndNotPulledThere) {
  for (const char* model : {"modal", "modal_warped", "modal_cubic"}) {
    view::Session session(parse_scene(held_beam, {std::string("material.model=\"") + model + "\""}));
    session.advance(0.05);
    session.record();
    EXPECT_EQ(session.status(), Status::ok) << model;
    EXPECT_NEAR(session.time(), 0.05, 0.02) << model;
    EXPECT_FALSE(session.grab(8)) << model;
  }
}

TEST(ReducedModel, SaysWhatOfTheStartIsLost) {
  EXPECT_THAT(said_of("modal", 4.358, {"start.velocity=[30,0,0]"}),
              HasSubstr("is no motion of modal's shapes"));
  const std::vector<std::string> strike{"strike=[{box=[[0.5,0,0.25],[0.5,0,0.25]],at=0.1,impulse=[0,0,-1]}]"};
  EXPECT_THAT(said_of("modal", 4.358, strike), HasSubstr("is no motion of modal's shapes"));
}

TEST(ReducedModel, ModesAreRefusedWhereTheyDoNothing) {
  Progress progress;
  try {
    simulate(parse_scene(held_beam,
                         {"material.model=\"springs\"", "material.modes=4", "solve.integrator=\"verlet\""}),
             progress);
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("modes = 4 is of models that reduce the body"));
  }
}

}  // namespace
}  // namespace mss

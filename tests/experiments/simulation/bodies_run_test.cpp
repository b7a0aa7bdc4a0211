// Runs of several bodies: what is written of each, that nothing depends on threads or on an interruption, and
// what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/base/error.hpp"
#include "core/mesh/shapes.hpp"
#include "experiments/simulation/diagnostics.hpp"
#include "experiments/simulation/restart.hpp"
#include "experiments/simulation/result_files.hpp"
#include "experiments/simulation/scene_check.hpp"
#include "experiments/simulation/simulation.hpp"
#include "tests/core/scene/scene_texts.hpp"
#include "tests/experiments/stop_after.hpp"

namespace mss {
namespace {

using ::testing::HasSubstr;

/// A block lies on the ground, another slides and turns on it.
const std::string blocks = R"([material]
density = 1000
young = 1e6
poisson = 0.3
[damping]
ratio = 0.05
[environment]
gravity = [0, 0, -9.81]
[contact]
bodies = true
[[plane]]
point = [0, 0, 0]
normal = [0, 0, 1]
[[body]]
cells = [4, 4, 2]
cell_size = 0.05
[[body]]
cells = [3, 2, 2]
cell_size = 0.04
origin = [0.02, 0.03, 0.1]
material = { young = 5e5 }
start = { velocity = [0.3, 0, 0], angular_velocity = [0, 0, 3] }
[solve]
duration = 0.1
every = 0.02
threads = 1
)";

std::string files_of(const SimulationResult& result) {
  std::ostringstream particles;
  write_particles(particles, result.particles);
  return series_table(result.series).csv() + particles.str();
}

SimulationResult run(const std::vector<std::string>& overrides = {}) {
  Progress progress;
  return simulate(parse_scene(blocks, overrides), progress);
}

TEST(RunOfBodies, SaysWhereEachIsAndHowTheyTouch) {
  const SimulationResult result = run({"solve.duration=0.5"});
  ASSERT_EQ(result.status, Status::ok);
  const SeriesRow &first = result.series.front(), &last = result.series.back();
  ASSERT_EQ(last.bodies.bodies.size(), 2U);
  ASSERT_TRUE(last.bodies.contact.has_value());
  EXPECT_GT(last.bodies.contact->touches, 4U);
  EXPECT_NEAR(last.bodies.bodies[1].centre[2], 0.14, 1e-3);  // it lies on the lower one
  EXPECT_GT(last.bodies.bodies[1].centre[0], first.bodies.bodies[1].centre[0] + 1e-3);  // and has slid
  EXPECT_LT(last.bodies.bodies[1].kinetic, 0.05 * first.bodies.bodies[1].kinetic);  // until friction held it
  const double upper_weight = 3 * 2 * 2 * std::pow(0.04, 3) * 1000 * 9.81;
  EXPECT_NEAR(last.bodies.contact->force, upper_weight, 0.2 * upper_weight);
  EXPECT_TRUE(result.contact.has_value());
  EXPECT_THAT(series_table(result.series).csv(), HasSubstr(",body_1_min_jacobian,contact_touches,"));
}

TEST(RunOfBodies, IsTheSameForAnyNumberOfThreads) {
  const std::string one = files_of(run());
  for (const char* threads : {"solve.threads=2", "solve.threads=3"}) EXPECT_EQ(files_of(run({threads})), one);
  const std::string implicit = "solve.integrator=\"backward_euler\"", step = "solve.dt=0.01";
  EXPECT_EQ(files_of(run({implicit, step, "solve.threads=2"})), files_of(run({implicit, step})));
}

TEST(RunOfBodies, GoesOnAsIfItHadNotStopped) {
  for (const char* method : {"solve.integrator=\"verlet\"", "solve.integrator=\"backward_euler\""}) {
    const Scene scene = parse_scene(blocks, {method, "solve.dt=2.5e-4"});
    const testing::SceneFolder folder;
    Progress whole;
    const std::string expected = files_of(simulate(scene, whole));
    const RestartChoice keep{
        .keep = [&](const Restart& left) { write_restart(folder.path() / restart_file, left); }};
    StopAfter stopped(3);
    ASSERT_EQ(simulate(scene, stopped, {}, {}, keep).status, Status::interrupted);
    Restart from = read_restart(folder.path());
    Progress rest;
    const SimulationResult result = simulate(scene, rest, {}, {}, {.from = &from, .keep = {}});
    EXPECT_EQ(files_of(result), expected) << method;
  }
}

TEST(RunOfBodies, OfBodiesFarApartIsThatOfEach) {
  const SimulationResult both = run({"body.1.origin=[5,0,0.1]", "solve.dt=2e-4"});
  const SimulationResult lower = run({"body.1.origin=[5,0,0.1]", "solve.dt=2e-4", "contact.bodies=false"});
  EXPECT_EQ(both.series.back().bodies.bodies[0].centre, lower.series.back().bodies.bodies[0].centre);
  EXPECT_EQ(both.series.back().bodies.contact->touches, 0U);
}

TEST(RunOfBodies, SaysWhereContactIsTooDeepOrTooSlow) {
  const Scene soft = parse_scene(blocks, {"contact.stiffness=0.003"});
  Progress progress;
  const std::vector<std::string> said = diagnostics_of(soft, simulate(soft, progress));
  EXPECT_THAT(said, ::testing::Contains(HasSubstr("deep in each other")));
  const Scene fast = parse_scene(blocks, {"body.1.start.velocity=[0,0,-80]", "body.1.origin=[0.02,0.03,0.5]",
                                          "solve.integrator=\"backward_euler\"", "solve.dt=0.01"});
  EXPECT_THAT(diagnostics_of(fast, simulate(fast, progress)),
              ::testing::Contains(HasSubstr("passed through another")));
}

/// Else they would be touched at places that they do not say.
TEST(RunOfBodies, RefusesImpulsesOnSurfacesOfMeshes) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / "mss_impulses_on_meshes";
  std::filesystem::create_directories(folder);
  write_obj(folder / "box.obj", box_mesh({0, 0, 0}, {1, 2, 3}));
  const std::string one = "[[body]]\nmesh = \"box.obj\"\ncells_across = 2\ncontact_on = \"surface\"\n";
  std::ofstream(folder / "two.toml")
      << "[material]\ndensity = 1000\nyoung = 1e6\npoisson = 0.3\n[contact]\nbodies = true\n"
      << one << "mesh_translation = [0, 0, 2]\n"
      << one << "[[obstacle]]\nshape = \"sphere\"\nradius = 1\ncentre = [0, 0, -5]\n";
  const auto complaint = [&](const std::vector<std::string>& overrides) -> std::string {
    try {
      check_solve(load_scene(folder / "two.toml", overrides));
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_THAT(complaint({}),
              HasSubstr("two.toml: contact: obstacle.0.contact = \"impulse\" touches particles"));
  EXPECT_EQ(complaint({"obstacle.0.contact=\"penalty\""}), "none");
  std::filesystem::remove_all(folder);
}

TEST(RunOfBodies, RefusesWhatTakesOneBody) {
  const auto complaint = [](const std::vector<std::string>& overrides) -> std::string {
    try {
      run(overrides);
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  };
  const std::string step = "solve.dt=0.01", implicit = "solve.integrator=\"backward_euler\"";
  for (const char* method : {"xpbd", "vbd", "shape_matching"})
    EXPECT_THAT(complaint({"solve.integrator=\"" + std::string(method) + "\"", step}),
                HasSubstr("is for one body that does not touch itself"));
  EXPECT_THAT(complaint({implicit, step, "solve.nonlinear_solver=\"lbfgs\""}), HasSubstr("nonlinear solver"));
  EXPECT_THAT(complaint({implicit, step, "solve.linear_solver=\"multigrid\""}), HasSubstr("linear solver"));
  EXPECT_THAT(complaint({"solve.sleep=1e-3"}), HasSubstr("sleep"));
  EXPECT_THAT(complaint({"material.model=\"modal\"", "solve.integrator=\"reduced\""}), HasSubstr("one body"));
  EXPECT_THAT(complaint({"solve.integrator=\"cvode_adams\"", "plane.0.contact=\"penalty\""}),
              HasSubstr("depends on where steps end"));
}

}  // namespace
}  // namespace mss

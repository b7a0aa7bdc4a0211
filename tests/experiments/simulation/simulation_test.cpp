// Simulations stop on the way, to be interrupted, without a change of what they compute.
#include "experiments/simulation/simulation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/scene/scene.hpp"
#include "tests/core/scene/scene_texts.hpp"

namespace mss {
namespace {

const std::string struck_cube = testing::cube_text("0.1") + R"([damping]
ratio = 0.1
[environment]
gravity = [0, 0, -9.81]
[start]
angular_velocity = [0, 0, 5]
[[strike]]
box = [[0, 0, 0], [0, 1, 1]]
at = 0.0123
impulse = [0.1, 0, 0]
[solve]
dt = 1e-4
duration = 0.09
)";
constexpr const char* plane = "plane=[{point=[0,0,-0.001],normal=[0,0,1]}]";

/// Every row by one advance.
void expect_same_without_stops(const Scene& scene, const SimulationResult& result) {
  const Body body(scene.body);
  SceneRun<double> run(scene, body);
  Work work;
  std::size_t row = 1;
  const auto rows = int(std::ceil(scene.solve.duration / scene.solve.every - 1e-9));
  for (int i = 1; i <= rows; ++i) {
    const double before = run.state().t;
    ASSERT_EQ(run.advance(std::min(double(i) * scene.solve.every, scene.solve.duration), work), Status::ok);
    if (run.state().t == before) continue;
    ASSERT_LT(row, result.series.size());
    EXPECT_EQ(run.state().t, result.series[row].t) << row;
    EXPECT_EQ(run.measure()->total(), result.series[row++].total());
  }
  EXPECT_EQ(row, result.series.size());
  EXPECT_EQ(work.steps, result.work.steps);
  EXPECT_EQ(work.force_evaluations, result.work.force_evaluations);
  for (std::size_t id = 0; id < result.particles.size(); ++id) {
    EXPECT_EQ(run.state().x.at(body.sites()[id]), result.particles[id].x) << id;
    EXPECT_EQ(run.state().v.at(body.sites()[id]), result.particles[id].v) << id;
  }
}

TEST(Simulation, ComputesTheSameWithAndWithoutStops) {
  for (const std::string method :
       {"verlet", "velocity_verlet", "semi_implicit_euler", "damped_verlet", "rk4", "pefrl",
        "backward_euler_linear", "implicit_midpoint", "xpbd", "vbd:5", "shape_matching"})
    for (const std::string every : {"0.09", "1.5e-4", "4.5e-4", "0.0105"})
      for (const bool falls : {false, true}) {
        std::vector<std::string> settings{"solve.integrator=\"" + method + "\"", "solve.every=" + every};
        if (method == "shape_matching") settings.emplace_back("damping.ratio=0");
        if (falls) settings.emplace_back(plane);
        const Scene scene = parse_scene(struck_cube, settings);
        SCOPED_TRACE(::testing::Message()
                     << method << ", every " << every << (falls ? ", above a plane" : ""));
        Progress progress;
        const SimulationResult result = simulate(scene, progress);
        ASSERT_EQ(result.status, Status::ok);
        expect_same_without_stops(scene, result);
      }
}

}  // namespace
}  // namespace mss

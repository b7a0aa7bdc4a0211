// Simulations stop on the way, to be interrupted, without a change of what they compute.
#include "experiments/simulation/simulation.hpp"

#include <gtest/gtest.h>

#include "core/scene.hpp"

namespace mss {
namespace {

constexpr const char* struck_cube = R"([body]
cells = [2, 2, 2]
cell_size = 0.1
[material]
density = 1000
young = 1e5
poisson = 0.3
[damping]
ratio = 0.1
[environment]
gravity = [0, 0, -9.81]
[start]
spin = [0, 0, 5]
[[plane]]
point = [0, 0, -0.01]
normal = [0, 0, 1]
[[strike]]
box = [[0, 0, 0], [0, 1, 1]]
at = 0.1234567
impulse = [0.1, 0, 0]
[solve]
dt = 1e-4
duration = 0.3
every = 0.3
)";

TEST(Simulation, ComputesTheSameWithAndWithoutStops) {
  for (const std::string method : {"verlet", "velocity_verlet", "semi_implicit_euler", "damped_verlet", "rk4",
                                   "pefrl", "backward_euler_linear", "implicit_midpoint", "xpbd", "vbd:5"}) {
    const Scene scene = parse_scene(struck_cube, {"solve.integrator=\"" + method + "\""});
    Progress progress;
    const SimulationResult result = simulate(scene, progress);
    ASSERT_EQ(result.status, Status::ok) << method;
    ASSERT_EQ(result.series.size(), 2U);
    const Body body(scene.body);
    SceneRun<double> run(scene, body);
    Work work;
    ASSERT_EQ(run.advance(scene.solve.duration, work), Status::ok);
    EXPECT_EQ(work.steps, result.work.steps) << method;
    EXPECT_EQ(run.state().t, result.simulated_seconds) << method;
    for (std::size_t id = 0; id < result.particles.size(); ++id) {
      EXPECT_EQ(run.state().x.at(body.sites()[id]), result.particles[id].x) << method;
      EXPECT_EQ(run.state().v.at(body.sites()[id]), result.particles[id].v) << method;
    }
  }
}

}  // namespace
}  // namespace mss

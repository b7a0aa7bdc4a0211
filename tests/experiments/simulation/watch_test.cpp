// What a run says of itself beside its status: energy from nowhere, particles behind planes, steps far from
// solved, restitution without effect.
#include <gtest/gtest.h>

#include <algorithm>

#include "experiments/harness/progress.hpp"
#include "experiments/simulation/diagnostics.hpp"
#include "experiments/simulation/simulation.hpp"

namespace mss {
namespace {

/// A block of 0.2 m that lies on a plane.
const std::string block = R"([body]
cells = [4, 4, 4]
cell_size = 0.05
[material]
density = 1000
young = 1e5
poisson = 0.3
[damping]
ratio = 0.1
[environment]
gravity = [0, 0, -9.81]
[[plane]]
point = [0, 0, 0]
normal = [0, 0, 1]
[solve]
dt = 0.0166666666666667
every = 0.0166666666666667
duration = 1
)";

struct Watched {
  Scene scene;
  SimulationResult result;

  std::string diagnostics() const {
    std::string all;
    for (const std::string& diagnostic : diagnostics_of(scene, result)) all += diagnostic + "\n";
    return all;
  }
  bool says(const std::string& words) const { return diagnostics().find(words) != std::string::npos; }
};

Watched run_watched(const Scene& scene) {
  Progress progress;
  return {scene, simulate(scene, progress)};
}
Watched run_block(const std::vector<std::string>& settings) {
  return run_watched(parse_scene(block, settings));
}
Watched run_shipped(const std::string& name, const std::vector<std::string>& settings) {
  return run_watched(load_scene(MSS_SOURCE_DIR "/experiments/scenes/" + name + ".toml", settings));
}

/// The largest total energy above the first, over the largest kinetic and stored one.
double raw_gain(const SimulationResult& result) {
  double largest = 0, at_play = 0;
  for (const Measures& row : result.series) {
    largest = std::max(largest, row.total());
    at_play = std::max(at_play, row.mechanical());
  }
  return (largest - result.series.front().total()) / at_play;
}

// Impulses on a body that nothing damps add energy in proportion to the step.
TEST(EnergyWatch, SaysHowMuchCameFromNowhere) {
  const std::vector<std::string> undamped{"damping.ratio=0", "plane.0.restitution=1", "plane.0.friction=0"};
  std::vector<std::string> fine = undamped;
  fine.emplace_back("solve.dt=1e-4");
  const Watched gains = run_shipped("fig5_2_bounce", undamped);
  ASSERT_TRUE(gains.result.gain);
  EXPECT_GT(gains.result.gain->gained, 0.2 * gains.result.gain->at_play);
  EXPECT_TRUE(gains.says("energy came from nowhere: at t = ")) << gains.diagnostics();
  EXPECT_TRUE(gains.says("give a shorter solve.dt")) << gains.diagnostics();
  EXPECT_EQ(gains.result.status, Status::ok);
  EXPECT_FALSE(run_shipped("fig5_2_bounce", fine).result.gain);
}

// One particle of 0.125 kg gets a speed, all of it in fast modes. What these store differs from their kinetic
// energy, as rows have it, by their step's share of the limit.
TEST(EnergyWatch, BearsTheSwingOfSymplecticMethodsAtTheSafeStep) {
  constexpr double supplied = 0.01 * 0.01 / (2 * 0.125);  // [J]
  for (const std::string method : {"verlet", "semi_implicit_euler", "velocity_verlet"}) {
    const Watched rings =
        run_block({"environment={}", "plane.0.point=[0,0,-9]", "damping={}", "solve.dt=safe",
                   "solve.every=1e-3", "solve.duration=0.2", "solve.integrator=" + method,
                   "strike=[{box=[[0.1,0.1,0.1],[0.1,0.1,0.1]],at=0,impulse=[0.01,0,0]}]"});
    double largest = 0;
    for (const Measures& row : rings.result.series) largest = std::max(largest, row.total());
    EXPECT_GT(largest, 1.06 * supplied) << method;
    EXPECT_FALSE(rings.result.gain) << method << rings.diagnostics();
  }
}

TEST(EnergyWatch, CountsStrikesAndWaitsForHolds) {
  const std::string strike = "strike=[{box=[[0,0,0],[1,1,1]],at=0.1,impulse=[8,0,0]}]";
  const Watched struck =
      run_block({"plane.0.point=[0,0,-9]", "environment={}", "solve.integrator=backward_euler", strike});
  EXPECT_GT(struck.result.series.back().kinetic, 3.9);
  EXPECT_FALSE(struck.result.gain) << struck.diagnostics();
  const Watched twisted = run_shipped("fig5_1_twist", {});
  EXPECT_GT(raw_gain(twisted.result), 0.5);  // what the hold did
  EXPECT_FALSE(twisted.result.gain) << twisted.diagnostics();
}

// A plane lifts what starts behind it, which is no energy from nowhere.
TEST(EnergyWatch, WaitsForWhatStartsBehindAPlane) {
  for (const std::string method : {"backward_euler", "backward_euler/lbfgs", "tr_bdf2"}) {
    const Watched lifted =
        run_block({"body.origin=[0,0,-0.03]", "material.young=1e6", "solve.integrator=" + method});
    EXPECT_GT(raw_gain(lifted.result), 1);
    EXPECT_FALSE(lifted.result.gain) << lifted.diagnostics();
  }
}

// What is held behind a plane stays there.
TEST(EnergyWatch, DoesNotWaitForWhatStaysBehindAPlane) {
  const Watched held =
      run_block({"hold=[{box=[[0,0,0],[0.2,0.2,0.05]]}]", "plane.0.point=[0,0,0.06]", "damping.ratio=0",
                 "solve.integrator=explicit_euler", "solve.dt=1e-4", "solve.duration=0.5"});
  EXPECT_TRUE(held.result.gain) << held.diagnostics();
}

TEST(PlaneWatch, SaysHowDeepAFallWent) {
  const std::vector<std::string> hard{"plane.0.contact=penalty", "start.velocity=[0,0,-40]",
                                      "body.origin=[0,0,0.06]",  "solve.dt=safe",
                                      "solve.every=1e-3",        "solve.duration=0.02"};
  const Watched fallen = run_block(hard);
  ASSERT_EQ(fallen.result.penetrations.size(), 1);
  const Penetration& found = fallen.result.penetrations[0];
  EXPECT_GT(found.depth, 0.1 * 0.05);
  EXPECT_LT(found.depth, 0.2);
  EXPECT_FALSE(found.ends_whole);
  EXPECT_TRUE(fallen.says("behind plane.0 at t = ")) << fallen.diagnostics();
  std::vector<std::string> soft = hard;
  soft[1] = "start.velocity=[0,0,-0.5]";
  EXPECT_TRUE(run_block(soft).result.penetrations.empty());
}

// The thesis's law leaves behind a plane what is there.
TEST(PlaneWatch, SaysThatABodyEndsBehindAPlane) {
  const Watched behind =
      run_block({"plane.0.contact=thesis", "plane.0.point=[0,0,0.21]", "solve.integrator=verlet",
                 "solve.dt=1e-3", "solve.duration=0.1", "solve.every=0.01"});
  ASSERT_EQ(behind.result.penetrations.size(), 1) << behind.diagnostics();
  EXPECT_TRUE(behind.result.penetrations[0].ends_whole);
  EXPECT_TRUE(behind.says("the whole body ends behind plane.0")) << behind.diagnostics();
}

TEST(PlaneWatch, LeavesOutWhatIsHeldAndWhatComesOut) {
  const Watched held = run_block({"hold=[{box=[[0,0,0],[0.2,0.2,0.05]]}]", "plane.0.point=[0,0,0.06]",
                                  "solve.integrator=backward_euler"});
  EXPECT_TRUE(held.result.penetrations.empty()) << held.diagnostics();
  const Watched pushed =
      run_block({"body.origin=[0,0,-0.01]", "solve.integrator=verlet", "solve.dt=safe", "solve.every=1e-3"});
  EXPECT_TRUE(pushed.result.penetrations.empty()) << pushed.diagnostics();
}

struct Few {
  std::string method, dt;
  bool suffice;
};

// One pass of XPBD a step lets this beam sag 15 times too far at 0.02 s, 1.18 times at 0.0002 s.
TEST(StepBalance, TellsFewPassesFromManyOnABeam) {
  for (const Few& few :
       {Few{"xpbd", "0.02", false}, Few{"xpbd", "0.001", false}, Few{"xpbd", "0.0002", false},
        Few{"vbd", "0.005", false}, Few{"xpbd:20", "0.001", true}, Few{"vbd:20", "0.001", true},
        Few{"backward_euler", "0.02", true}}) {
    const Watched beam = run_shipped(
        "cantilever", {"solve.integrator=" + few.method, "solve.dt=" + few.dt, "solve.duration=2"});
    EXPECT_EQ(beam.says("steps are not solved: forces are out of balance by "), !few.suffice)
        << few.method << " at " << few.dt << " s: " << beam.diagnostics();
    ASSERT_TRUE(beam.result.imbalance);
    if (few.method == "backward_euler") {
      EXPECT_LT(beam.result.imbalance->share, 1e-6);
    }
  }
}

// Where E dt^2 / (rho h^2) is beyond 11, 20 passes of XPBD leave a block that rests on a plane too low.
TEST(StepBalance, TellsFewPassesFromManyAtRest) {
  for (const Few& few : {Few{"xpbd:20", "1e6", false}, Few{"vbd:5", "1e7", false}, Few{"vbd:20", "1e6", true},
                         Few{"xpbd:100", "1e5", true}, Few{"backward_euler", "1e7", true}}) {
    const Watched rest = run_block({"solve.integrator=" + few.method, "material.young=" + few.dt});
    EXPECT_EQ(rest.says("steps are not solved"), !few.suffice)
        << few.method << " of " << few.dt << " Pa: " << rest.diagnostics();
  }
}

TEST(StepBalance, IsOfMethodsThatIterateTowardsBackwardEuler) {
  for (const std::string method : {"verlet", "tr_bdf2", "implicit_midpoint", "backward_euler_linear"})
    EXPECT_FALSE(run_block({"solve.integrator=" + method, "solve.duration=0.1"}).result.imbalance) << method;
}

TEST(Restitution, HasNoEffectInStepsThatDoNotResolveTheBody) {
  const std::vector<std::string> bouncing{"plane.0.restitution=0.7", "solve.duration=0.1",
                                          "solve.integrator=backward_euler"};
  const Watched frames = run_block(bouncing);
  EXPECT_TRUE(frames.says("plane.0.restitution = 0.7 has no effect: a step of 0.01667 s"))
      << frames.diagnostics();
  std::vector<std::string> fine = bouncing;
  fine.emplace_back("solve.dt=1e-4");
  EXPECT_FALSE(run_block(fine).says("has no effect"));
  std::vector<std::string> after_steps = bouncing;
  after_steps[2] = "solve.integrator=verlet";
  after_steps.emplace_back("solve.dt=safe");
  EXPECT_FALSE(run_block(after_steps).says("has no effect"));
}

TEST(Step, IsFarAboveWhatFollowsVibrations) {
  const std::vector<std::string> in_frames{"solve.integrator=backward_euler", "solve.duration=0.1"};
  EXPECT_FALSE(run_block(in_frames).says("slowest stretching"));  // .04 s
  std::vector<std::string> stiff = in_frames;
  stiff.emplace_back("material.young=1e7");
  const Watched watched = run_block(stiff);
  EXPECT_TRUE(watched.says("4.2 times the period of the body's slowest stretching, 0.004 s: backward_euler"))
      << watched.diagnostics();
  stiff.emplace_back("solve.dt=1e-3");
  EXPECT_FALSE(run_block(stiff).says("slowest stretching"));
}

TEST(Step, ThatIsSafeSmellsOfOtherUnits) {
  const auto warnings = [](std::vector<std::string> settings, double dt) {
    settings.emplace_back("solve.dt=safe");
    settings.emplace_back("solve.integrator=verlet");
    return warnings_of_step(parse_scene(block, settings), dt);
  };
  const std::vector<std::string> soft = warnings({"material.young=0.1"}, 0.3);
  ASSERT_EQ(soft.size(), 1U);
  EXPECT_NE(soft[0].find("megapascals"), std::string::npos);
  EXPECT_TRUE(warnings({}, 1e-3).empty());
}

}  // namespace
}  // namespace mss

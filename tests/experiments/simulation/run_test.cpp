// `mss run` from outside: what it writes, how it fails, and that bad scenes leave nothing behind.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>

#include "experiments/harness/json.hpp"
#include "experiments/harness/table.hpp"
#include "experiments/io/output.hpp"
#include "experiments/io/process.hpp"
#include "tests/core/scene/scene_texts.hpp"

namespace mss {
namespace {

namespace fs = std::filesystem;

/// A directory of this test's own, removed at its end.
class RunCommand : public ::testing::Test {
 protected:
  RunCommand() {
    fs::remove_all(root_);
    fs::create_directories(root_);
  }
  ~RunCommand() override { fs::remove_all(root_); }
  RunCommand(const RunCommand&) = delete;
  RunCommand& operator=(const RunCommand&) = delete;

  fs::path out() const { return root_ / "out"; }
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(root_ / name) << text;
    return root_ / name;
  }
  ProgramRun run(const fs::path& scene, std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{MSS_PROGRAM, "run", scene.string(), "--out", out().string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }
  Json summary() const { return Json::parse(read_file(out() / "summary.json")); }

 private:
  fs::path root_ =
      fs::path(::testing::TempDir()) /
      ("mss_run_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
};

const std::string cube = testing::cube_text("0.1") + R"([start]
angular_velocity = [0, 0, 5]
[solve]
integrator = "velocity_verlet"
dt = 1e-4
duration = 0.05
every = 0.01
)";

TEST_F(RunCommand, WritesForcesAndTorquesOfObstacles) {
  const std::string tables = R"([environment]
gravity = [0, 0, -9.81]
[[obstacle]]
shape = "box"
size = [1, 1, 0.2]
centre = [0.3, 0, -0.1]
[expect]
obstacle_0_z = { value = 78.48, within = 30 }
)";
  const ProgramRun done = run(write("cube.toml", cube + tables));
  ASSERT_EQ(done.exit_status, 0) << done.output;
  const std::string header = read_file(out() / "series.csv").substr(0, 1000);
  EXPECT_NE(header.find(",obstacle_0_x,obstacle_0_y,obstacle_0_z,obstacle_0_torque_x,obstacle_0_torque_y,"
                        "obstacle_0_torque_z\n"),
            std::string::npos)
      << header;
}

// Overdamped and spinning fast: symmetric tangents leave out how dampers turn.
TEST_F(RunCommand, AStalledNewtonReachesTheSummary) {
  const ProgramRun result = run(write("cube.toml", cube),
                                {"--set", "solve.integrator=implicit_midpoint", "--set", "solve.dt=0.02",
                                 "--set", "damping.ratio=20", "--set", "start.angular_velocity=[0,0,300]"});
  EXPECT_EQ(result.exit_status, 3) << result.output;
  EXPECT_EQ(summary()["status"], "newton_stalled");
  EXPECT_EQ(summary()["steps"], 0);
  EXPECT_TRUE(fs::exists(out() / "series.csv"));
}

TEST_F(RunCommand, WritesSeriesParticlesAndSummary) {
  const ProgramRun result = run(write("cube.toml", cube));
  ASSERT_EQ(result.exit_status, 0) << result.output;
  const auto series = parse_csv(read_file(out() / "series.csv"));
  ASSERT_EQ(series.size(), 1U + 6);
  EXPECT_EQ(series[0],
            (std::vector<std::string>{"t", "kinetic", "elastic", "volume_energy", "external_potential",
                                      "total", "volume_ratio", "volume_ratio_paper", "momentum_x",
                                      "momentum_y", "momentum_z", "angular_momentum_x", "angular_momentum_y",
                                      "angular_momentum_z", "max_speed", "max_stretch", "min_jacobian"}));
  EXPECT_EQ(series[6][0], "0.05");
  const auto particles = parse_csv(read_file(out() / "particles.csv"));
  ASSERT_EQ(particles.size(), 1U + 27);
  EXPECT_EQ(particles[0], (std::vector<std::string>{"id", "rest_x", "rest_y", "rest_z", "x", "y", "z", "vx",
                                                    "vy", "vz", "mass"}));
  double mass = 0;
  for (std::size_t row = 1; row < particles.size(); ++row) mass += std::stod(particles[row][10]);
  EXPECT_NEAR(mass, 8, 1e-12);
  const Json s = summary();
  EXPECT_EQ(s["status"], "ok");
  EXPECT_EQ(s["steps"], 500);
  EXPECT_GE(s["threads_working"], 1);
  EXPECT_LE(s["threads_working"], s["threads"]);
  EXPECT_EQ(s["integrator"], "velocity_verlet");
  EXPECT_EQ(s["simulated_seconds"], 0.05);
  EXPECT_EQ(s["work"]["force_evaluations"], 501);
  EXPECT_EQ(s["final"]["t"], 0.05);
  EXPECT_TRUE(s["provenance"].contains("commit"));
  EXPECT_EQ(s["configuration"]["body"]["cell_size"], 0.1);
}

TEST_F(RunCommand, WritesForcesOfHoldsAndPlanes) {
  const std::string acting = cube + R"([environment]
gravity = [0, 0, -9.81]
[[plane]]
contact = "penalty"
point = [0, 0, 0]
normal = [0, 0, 1]
[[hold]]
box = [[0, 0, 0], [0, 0, 0]]
[[plane]]
point = [0, 0, 0]
normal = [0, 0, 1]
[expect]
plane_1_z = { value = 0, within = 1e9 }
)";
  ASSERT_EQ(run(write("cube.toml", acting)).exit_status, 0);
  const auto series = parse_csv(read_file(out() / "series.csv"));
  ASSERT_EQ(series[0].size(), 17U + 9);
  EXPECT_EQ(std::vector<std::string>(series[0].begin() + 17, series[0].end()),
            (std::vector<std::string>{"hold_0_x", "hold_0_y", "hold_0_z", "plane_0_x", "plane_0_y",
                                      "plane_0_z", "plane_1_x", "plane_1_y", "plane_1_z"}));
  EXPECT_EQ(series[1][25], "0");  // the mean over no time
  EXPECT_GT(std::stod(series[6][25]), 0);
  EXPECT_EQ(summary()["final"]["plane_1_z"], std::stod(series[6][25]));
}

TEST_F(RunCommand, ResultsDoNotDependOnThreads) {
  const fs::path scene = write("cube.toml", cube);
  ASSERT_EQ(run(scene, {"--set", "solve.threads=1"}).exit_status, 0);
  const std::string one = read_file(out() / "particles.csv");
  ASSERT_EQ(run(scene, {"--set", "solve.threads=3"}).exit_status, 0);
  EXPECT_EQ(one, read_file(out() / "particles.csv"));
}

TEST_F(RunCommand, DivergenceIsAResultWithItsRows) {
  const ProgramRun result = run(
      write("cube.toml", cube),
      {"--set", "solve.integrator=explicit_euler", "--set", "solve.dt=1e-2", "--set", "solve.duration=9"});
  EXPECT_EQ(result.exit_status, 3) << result.output;
  EXPECT_EQ(summary()["status"], "non_finite");
  const std::string series = read_file(out() / "series.csv");
  EXPECT_GT(parse_csv(series).size(), 2U);
  EXPECT_LT(parse_csv(series).size(), 900U);
  for (const std::string& text : {series, read_file(out() / "particles.csv")}) {
    EXPECT_EQ(text.find("nan"), std::string::npos);
    EXPECT_EQ(text.find("inf"), std::string::npos);
  }
}

TEST_F(RunCommand, SaysWhatTheStepHasToDoWithADivergence) {
  const fs::path scene = write("cube.toml", cube);
  const ProgramRun longer =
      run(scene, {"--set", "solve.dt=0.05", "--set", "solve.every=0.05", "--set", "solve.duration=20"});
  EXPECT_EQ(longer.exit_status, 3);
  EXPECT_NE(longer.output.find("the step of 0.05 s is longer than the "), std::string::npos) << longer.output;
  EXPECT_LT(summary()["stable_dt"], 0.05);
  EXPECT_EQ(summary()["warnings"].size(), 1U);
  const ProgramRun unstable =
      run(scene, {"--set", "solve.integrator=explicit_euler", "--set", "solve.dt=0.05", "--set",
                  "solve.duration=20", "--set", "damping.ratio=0"});
  EXPECT_NE(unstable.output.find("no step of explicit_euler is sure to be stable"), std::string::npos)
      << unstable.output;
}

TEST_F(RunCommand, SaysWhatHasNoEffect) {
  const ProgramRun result =
      run(write("cube.toml", cube),
          {"--set", "solve.local_steps=true", "--set", "solve.every=1e-5", "--set", "solve.duration=1e-3",
           "--set", "strike=[{box=[[0,0,0],[1,1,1]],at=7,impulse=[1,0,0]}]", "--set",
           "plane=[{point=[0,0,-1],normal=[0,0,-1]}]", "--set", "refine=[{box=[[0,0,0],[0.2,0.2,0.2]]}]"});
  EXPECT_EQ(result.exit_status, 0) << result.output;
  for (const char* sentence :
       {"strike.0.at = 7 s is after the end: solve.duration = 0.001 s",
        "plane.0: the whole body starts behind it",
        "solve.every = 1e-05 s is less than the step of 0.0001 s: there is a row a step",
        "solve.local_steps saves nothing here"})
    EXPECT_NE(result.output.find(sentence), std::string::npos) << sentence << "\n" << result.output;
}

TEST_F(RunCommand, SaysThatHoldsLeaveABodyFreeToMove) {
  const ProgramRun result = run(write("cube.toml", cube), {"--set", "solve.integrator=static", "--set",
                                                           "environment.gravity=[0,9.81,-9.81]", "--set",
                                                           "hold=[{box=[[0,0,0],[1,1,0]],axes=\"z\"}]"});
  EXPECT_EQ(result.exit_status, 3) << result.output;
  EXPECT_NE(result.output.find("the holds leave 3 of the body's 6 rigid motions free"), std::string::npos)
      << result.output;
}

/// Runs a program for so many seconds of processor time.
constexpr const char* interrupt_after = MSS_SOURCE_DIR "/tests/experiments/interrupt_after.sh";

// A row of 10^10 steps ends with the signal, and leaves the state until then.
TEST_F(RunCommand, IsInterruptedWithinARow) {
  const fs::path scene = write("cube.toml", cube);
  for (const std::string method : {"velocity_verlet", "backward_euler_linear"}) {
    const ProgramRun result = run_program({interrupt_after, "1", MSS_PROGRAM, "run", scene.string(), "--out",
                                           out().string(), "--set", "solve.duration=1e6", "--set",
                                           "solve.every=1e6", "--set", "solve.integrator=" + method});
    EXPECT_EQ(summary()["status"], "interrupted") << method << result.output;
    EXPECT_EQ(parse_csv(read_file(out() / "series.csv")).size(), 3U) << method;
    EXPECT_GT(summary()["final"]["t"], 0) << method;
    EXPECT_EQ(summary()["final"]["t"], summary()["simulated_seconds"]) << method;
    fs::remove_all(out());
  }
}

TEST_F(RunCommand, GoesOnFromAnother) {
  const fs::path scene = write("cube.toml", cube);
  const auto files = [&] { return read_file(out() / "series.csv") + read_file(out() / "particles.csv"); };
  const auto kept = [&](const std::string& name) { return out().parent_path() / name; };
  ASSERT_EQ(run(scene).exit_status, 0);
  const std::string whole = files();
  const Json work = summary()["work"];
  EXPECT_TRUE(summary()["continued"].is_null());
  ASSERT_EQ(run(scene, {"--set", "solve.duration=0.0223"}).exit_status, 0);
  fs::copy(out(), kept("first"));
  for (const fs::path& from : {out(), kept("first")}) {
    const ProgramRun result = run(scene, {"--from", from.string()});
    ASSERT_EQ(result.exit_status, 0) << result.output;
    EXPECT_NE(result.output.find("it went on from 0.02 s; all is as in one run, bit for bit"),
              std::string::npos)
        << result.output;
    EXPECT_EQ(files(), whole);
    EXPECT_EQ(summary()["work"], work);
    EXPECT_EQ(summary()["continued"].size(), 1U);
    EXPECT_EQ(summary()["continued"][0]["exact"], true);
    fs::remove_all(out());
  }
}

// Within a row, of which there is no other.
TEST_F(RunCommand, GoesOnFromWhereItWasInterrupted) {
  const fs::path scene = write("cube.toml", cube);
  const auto interrupted =
      run_program({interrupt_after, "1", MSS_PROGRAM, "run", scene.string(), "--out", out().string(), "--set",
                   "solve.duration=1e6", "--set", "solve.every=1e6"});
  ASSERT_EQ(interrupted.exit_status, 130) << interrupted.output;
  const double t = summary()["simulated_seconds"];
  const std::vector<std::string> longer{"--set", "solve.every=1e6", "--set",
                                        "solve.duration=" + std::to_string(1.1 * t)};
  std::vector<std::string> arguments = longer;
  arguments.insert(arguments.end(), {"--from", out().string()});
  const ProgramRun second = run(scene, arguments);
  ASSERT_EQ(second.exit_status, 0) << second.output;
  const std::string parts = read_file(out() / "series.csv") + read_file(out() / "particles.csv");
  EXPECT_EQ(summary()["continued"][0]["from_time"], t);
  ASSERT_EQ(run(scene, longer).exit_status, 0);
  EXPECT_EQ(read_file(out() / "series.csv") + read_file(out() / "particles.csv"), parts);
}

TEST_F(RunCommand, GoesOnFromNothingElse) {
  const fs::path scene = write("cube.toml", cube);
  const fs::path first = out().parent_path() / "first";
  const auto expect_refused = [&](std::vector<std::string> more, const std::string& words) {
    more.insert(more.end(), {"--from", first.string()});
    const ProgramRun result = run(scene, more);
    EXPECT_EQ(result.exit_status, 2) << result.output;
    EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), 1) << result.output;
    EXPECT_NE(result.output.find(words), std::string::npos) << result.output;
    EXPECT_FALSE(fs::exists(out()));
  };
  expect_refused({}, "there is no such folder");
  fs::create_directory(first);
  expect_refused({}, "it has no restart.bin");
  ASSERT_EQ(run(scene).exit_status, 0);
  fs::remove(first);
  fs::rename(out(), first);
  expect_refused({}, "asks for no more");
  expect_refused({"--set", "solve.duration=1", "--set", "solve.dt=2e-4"},
                 "solve.dt = 0.0002, and the run had");
  expect_refused({"--set", "solve.duration=1", "--vtk", "5"}, "--vtk writes frames from the beginning");
  expect_refused({"--set", "solve.duration=1", "--dry-run"}, "--dry-run is of a whole run");
  std::ofstream(first / "restart.bin", std::ios::app) << "more";
  expect_refused({"--set", "solve.duration=1"}, "it has been changed or cut short");
}

/// Its top falls through its bottom, which is held.
TEST_F(RunCommand, SaysThatABodyEndsFolded) {
  const ProgramRun fallen = run(write("cube.toml", cube),
                                {"--set", "material.young=1", "--set", "environment.gravity=[0,0,-9.81]",
                                 "--set", "hold=[{box=[[0,0,0],[1,1,0]]}]", "--set", "solve.duration=0.3"});
  EXPECT_EQ(fallen.exit_status, 0) << fallen.output;
  EXPECT_LT(summary()["final"]["min_jacobian"], 0);
  EXPECT_NE(fallen.output.find("the body ends folded: "), std::string::npos) << fallen.output;
}

/// Its cells could be paired, but those of a voxel file are the coarsest.
TEST_F(RunCommand, SaysWhichRefinementAnExtrapolationNeeds) {
  write("block.txt", "##\n##\n\n##\n##\n");
  const fs::path scene = write("block.toml",
                               "[body]\nvoxels = 'block.txt'\ncell_size = 0.1\n"
                               "[material]\ndensity = 1000\nyoung = 1e6\npoisson = 0.3\n"
                               "[environment]\ngravity = [0, 0, -9.81]\n"
                               "[[hold]]\nbox = [[0, 0, 0], [1, 1, 0]]\n[solve]\nintegrator = 'static'\n");
  const ProgramRun once = run(scene);
  EXPECT_NE(once.output.find("body.refine is 1; with twice that"), std::string::npos) << once.output;
  const ProgramRun twice = run(scene, {"--set", "body.refine=2"});
  EXPECT_EQ(twice.output.find("no extrapolation"), std::string::npos) << twice.output;
}

TEST_F(RunCommand, SaysThatNothingHoldsABodyThatFindsNoRest) {
  const ProgramRun adrift = run(write("cube.toml", cube), {"--set", "solve.integrator=static", "--set",
                                                           "environment.gravity=[0,0,-9.81]"});
  EXPECT_EQ(adrift.exit_status, 3) << adrift.output;
  EXPECT_NE(adrift.output.find("nothing holds the body in place"), std::string::npos) << adrift.output;
  const ProgramRun on_legs = run("soft_table", {"--set", "solve.integrator=static"});
  EXPECT_EQ(on_legs.exit_status, 3) << on_legs.output;
  EXPECT_NE(on_legs.output.find("nothing holds the body but planes"), std::string::npos) << on_legs.output;
}

/// A hundredth of its weight at 0.02 s: 8 kg get 0.8 N s, which shows as momentum.
TEST_F(RunCommand, StrikesAreGivenOnceUnderEveryKindOfMethod) {
  for (const char* method : {"velocity_verlet", "backward_euler", "cvode_adams"}) {
    const ProgramRun result = run(write("cube.toml", cube),
                                  {"--set", "strike=[{box=[[0,0,0],[1,1,0]],at=0.02,impulse=[0.8,0,-0.4]}]",
                                   "--set", std::string("solve.integrator=") + method});
    ASSERT_EQ(result.exit_status, 0) << result.output;
    const auto series = parse_csv(read_file(out() / "series.csv"));
    EXPECT_NEAR(std::stod(series[2][8]), 0, 1e-6) << method;  // t = 0.01
    EXPECT_NEAR(std::stod(series[5][8]), 0.8, 1e-6) << method;
    EXPECT_NEAR(std::stod(series[6][10]), -0.4, 1e-6) << method;
  }
}

TEST_F(RunCommand, ReportsTimeSavedAndErrorOfSleep) {
  const ProgramRun result = run("soft_blocks");
  ASSERT_EQ(result.exit_status, 0) << result.output;
  EXPECT_NE(result.output.find("% of the body slept"), std::string::npos) << result.output;
  const Json sleep = summary()["sleep"];
  EXPECT_GT(sleep["share"], 0.3);
  EXPECT_LT(sleep["share"], 0.9);
  EXPECT_LT(sleep["most_apart"], 1e-3);
  EXPECT_LT(sleep["apart_at_end"], 1e-3);
  EXPECT_GT(sleep["apart_at_end"], 0);
  EXPECT_GT(sleep["seconds_per_step_asleep"], 0);
  EXPECT_GT(sleep["seconds_per_step_awake"], 0);
  ASSERT_EQ(run("soft_blocks", {"--set", "solve.sleep=0"}).exit_status, 0);
  EXPECT_TRUE(summary()["sleep"].is_null());
}

TEST_F(RunCommand, SleepIsForExplicitMethodsOfSprings) {
  for (const char* setting :
       {"solve.integrator=backward_euler", "solve.integrator=cvode_bdf", "material.model=corotational"}) {
    const ProgramRun result = run(write("cube.toml", cube), {"--set", "solve.sleep=1e-3", "--set", setting});
    EXPECT_EQ(result.exit_status, 2) << setting;
    EXPECT_NE(result.output.find("solve: sleep is for"), std::string::npos) << result.output;
    EXPECT_FALSE(fs::exists(out()));
  }
}

TEST_F(RunCommand, TakesVariantsOfMethods) {
  const fs::path scene = write("cube.toml", cube);
  ASSERT_EQ(run(scene, {"--set", "solve.integrator=vbd:3", "--set", "solve.dt=0.01"}).exit_status, 0);
  const std::string once = read_file(out() / "series.csv");
  ASSERT_EQ(
      run(scene, {"--set", "solve.integrator=vbd", "--set", "solve.iterations=3", "--set", "solve.dt=0.01"})
          .exit_status,
      0);
  EXPECT_EQ(read_file(out() / "series.csv"), once);
  const ProgramRun both = run(scene, {"--set", "solve.integrator=vbd:3", "--set", "solve.iterations=2"});
  EXPECT_EQ(both.exit_status, 2);
  EXPECT_NE(both.output.find("give one of them"), std::string::npos) << both.output;
}

TEST_F(RunCommand, SafeStepIsStable) {
  ASSERT_EQ(
      run(write("cube.toml", cube), {"--set", "solve.dt=safe", "--set", "solve.duration=2"}).exit_status, 0);
  EXPECT_GT(summary()["dt"], 1e-4);
  EXPECT_LT(summary()["final"]["max_stretch"], 0.5);
}

constexpr const char* cantilever = R"([body]
cells = [16, 4, 4]
cell_size = 0.25
[material]
density = 1000
young = 1e5
poisson = 0.3
face_share = 1
[environment]
gravity = [0, 0, 0]
[[hold]]
box = [[0, 0, 0], [0, 1, 1]]
[[load]]
box = [[4, 0, 0], [4, 1, 1]]
force = [0, 0, -1]
[solve]
integrator = "static"
[expect]
displacement = { box = [[4, 0, 0], [4, 1, 1]], value = [0, 0, -2.64e-3], within = 2e-4 }
)";

// The limit is 2.6413e-3 m (CalculiX, extrapolated).
TEST_F(RunCommand, CorrectsQuantitiesAtRest) {
  const ProgramRun done = run(write("tip.toml", cantilever));
  ASSERT_EQ(done.exit_status, 0) << done.output;
  const Json estimates = summary()["estimates"];
  EXPECT_EQ(estimates["none"], "");
  EXPECT_EQ(estimates["no_richardson"], "");
  std::map<std::string, Json> of;
  for (const Json& value : estimates["values"]) of[value["quantity"]] = value;
  ASSERT_EQ(of.size(), 3);  // what is nonlinear along x is negligible
  const Json tip = of["displacement 0 z"], reaction = of["reaction of hold 0 z"],
             energy = of["stored energy"];
  EXPECT_NEAR(tip["value"].get<double>() / -2.6413e-3, 1 - 0.0615, 1e-3);
  EXPECT_NEAR(tip["corrected"].get<double>() / -2.6413e-3, 1 - 0.0094, 1e-3);
  EXPECT_NEAR(tip["richardson"].get<double>() / -2.6413e-3, 1 - 0.0186, 1e-3);
  EXPECT_DOUBLE_EQ(tip["value"].get<double>() + tip["error_estimate"].get<double>(), tip["corrected"]);
  EXPECT_TRUE(tip["doubts"].empty());
  EXPECT_NEAR(reaction["value"], 1, 1e-9);
  EXPECT_NEAR(reaction["error_estimate"], 0, 1e-9);
  EXPECT_NEAR(energy["corrected"].get<double>() / (2.6413e-3 / 2), 1 - 0.0094, 1e-3);
  EXPECT_NE(done.output.find("displacement 0 z -0.0024786 m, corrected by -0.00014 (5.6 %) to -0.0026164"),
            std::string::npos)
      << done.output;
}

constexpr const char* pressed = R"([body]
cells = [4, 4, 4]
cell_size = 0.25
refinement = "auto"
refinement_levels = 2
[material]
density = 20
young = 1e5
poisson = 0.3
[[hold]]
box = [[0, 0, 0], [1, 1, 0]]
[[load]]
box = [[0.5, 0.5, 1], [0.5, 0.5, 1]]
force = [0, 0, -100]
[solve]
integrator = "static"
duration = 0.01
[expect]
displacement = { box = [[0.5, 0.5, 1], [0.5, 0.5, 1]], value = [0, 0, -0.01], within = 1 }
)";

// Pressed in the middle of its top, it has smaller cells there, and yields more; so it does in motion.
TEST_F(RunCommand, ChoosesWhereCellsAreSmaller) {
  const fs::path scene = write("pressed.toml", pressed);
  ASSERT_EQ(run(scene, {"--set", "expect={}"}).exit_status, 0);
  const Json levels = summary()["levels"];
  const double refined = summary()["final"]["elastic"].get<double>();
  ASSERT_EQ(levels.size(), 3);
  EXPECT_EQ(levels[2]["cell_size"], 0.0625);
  EXPECT_EQ(levels[0]["cells"].get<int>() + levels[1]["cells"].get<int>() / 8.0 +
                levels[2]["cells"].get<int>() / 64.0,
            64);
  EXPECT_LT(levels[2]["cells"].get<int>(), 512);
  EXPECT_NE(summary()["estimates"]["none"].get<std::string>().find("one size"), std::string::npos);

  const ProgramRun goal = run(scene, {"--set", "body.refinement_goal=\"displacement\""});
  ASSERT_EQ(goal.exit_status, 0) << goal.output;
  EXPECT_NE(goal.output.find(" cells of 0.0625 m; "), std::string::npos) << goal.output;
  EXPECT_EQ(summary()["levels"], levels);  // the displacement under the only load

  ASSERT_EQ(run(scene, {"--set", "solve.integrator=\"verlet\""}).exit_status, 0);
  EXPECT_EQ(summary()["levels"], levels);

  const fs::path plain =
      write("plain.toml", std::string(pressed).replace(std::string(pressed).find("refinement ="), 42, ""));
  ASSERT_EQ(run(plain).exit_status, 0);
  EXPECT_GT(refined, 1.2 * summary()["final"]["elastic"].get<double>());
}

TEST_F(RunCommand, SaysWhyNoCellsCanBeChosen) {
  const fs::path scene = write("pressed.toml", pressed);
  const ProgramRun loose = run(scene, {"--set", "hold.0.axes=\"z\""});
  EXPECT_EQ(loose.exit_status, 2);
  EXPECT_NE(loose.output.find("holds do not keep the body in place"), std::string::npos) << loose.output;
  EXPECT_EQ(run(scene, {"--set", "load.0.force=[0, 0, 0]"}).exit_status, 2);
}

// The bar of 1 x 0.25 x 0.25 m, held at faces of its mesh, bears its weight there and nothing else.
TEST_F(RunCommand, ReactionsAreThoseOfHoldsAtFacesToo) {
  const fs::path scenes = fs::path(MSS_SOURCE_DIR) / "experiments" / "scenes";
  ASSERT_EQ(run(scenes / "mesh_bar.toml", {"--set", "solve.integrator=static"}).exit_status, 0);
  const Json values = summary()["estimates"]["values"];
  std::map<std::string, double> of;
  for (const Json& value : values) of[value["quantity"]] = value["value"];
  ASSERT_EQ(of.size(), 2);  // along x and y they are negligible
  EXPECT_NEAR(of["reaction of hold 0 z"], 62.5 * 9.81, 1e-3 * 62.5 * 9.81);
}

TEST_F(RunCommand, SaysWhyThereIsNoEstimate) {
  const fs::path scene = write("tip.toml", cantilever);
  ASSERT_EQ(run(scene, {"--set", "body.sharing=\"uniform\""}).exit_status, 0);
  EXPECT_NE(summary()["estimates"]["none"].get<std::string>().find("weight"), std::string::npos);
  ASSERT_EQ(run(scene, {"--set", "material.model=\"linear\""}).exit_status, 0);
  EXPECT_NE(summary()["estimates"]["none"].get<std::string>().find("springs"), std::string::npos);
  ASSERT_EQ(run(scene, {"--set", "body.cells=[16,4,3]", "--set", "expect={}"}).exit_status, 0);
  EXPECT_NE(summary()["estimates"]["no_richardson"].get<std::string>().find("twice"), std::string::npos);
  ASSERT_EQ(run(write("moving.toml", cube)).exit_status, 0);
  EXPECT_TRUE(summary()["estimates"].is_null());
}

/// What it stores is 0 or rounding, of which no share is an error.
TEST_F(RunCommand, EstimatesNothingOfABodyThatNothingDeforms) {
  const fs::path scene = write("tip.toml", cantilever);
  const ProgramRun done = run(
      scene, {"--set", "load.0.force=[0, 0, 0]", "--set", "body.cell_size=0.1", "--set", "expect={}", "--set",
              "hold.0.box=[[0, 0, 0], [0, 0.4, 0.4]]", "--set", "load.0.box=[[1.6, 0, 0], [1.6, 0.4, 0.4]]"});
  ASSERT_EQ(done.exit_status, 0) << done.output;
  EXPECT_TRUE(summary()["estimates"]["values"].empty());
  EXPECT_NE(done.output.find("no error estimate: nothing deforms the body"), std::string::npos)
      << done.output;
  ASSERT_EQ(run(scene, {"--set", "load.0.force=[0, 0, -1e-7]"}).exit_status, 0);
  EXPECT_EQ(summary()["estimates"]["values"].size(), 3);
}

TEST_F(RunCommand, AStepThatTheMethodChoosesIsNull) {
  const fs::path scene = write("cube.toml", cube);
  ASSERT_EQ(run(scene, {"--set", "solve.integrator=cvode_adams", "--set", "solve.dt=safe"}).exit_status, 0);
  EXPECT_TRUE(summary()["dt"].is_null());
  ASSERT_EQ(run(write("tip.toml", cantilever)).exit_status, 0);
  EXPECT_TRUE(summary()["dt"].is_null());
  ASSERT_EQ(run(scene).exit_status, 0);
  EXPECT_GT(summary()["dt"], 0);
}

TEST_F(RunCommand, InterruptKeepsRows) {
  const fs::path scene = write("cube.toml", cube);
  const ProgramRun result = run_program({interrupt_after, "1", MSS_PROGRAM, "run", scene.string(), "--out",
                                         out().string(), "--set", "solve.duration=1e5"});
  EXPECT_EQ(result.exit_status, 130) << result.output;
  EXPECT_EQ(summary()["status"], "interrupted");
  EXPECT_GT(parse_csv(read_file(out() / "series.csv")).size(), 2U);
}

/// What becomes of a scene that comes with the program.
TEST_F(RunCommand, TheThesissCubeComesToRest) {
  const fs::path scenes = fs::path(MSS_SOURCE_DIR) / "experiments" / "scenes";
  ASSERT_EQ(run(scenes / "fig5_2_bounce.toml").exit_status, 0);
  const auto series = parse_csv(read_file(out() / "series.csv"));
  double peak = 0;
  for (std::size_t row = 1; row < series.size(); ++row) peak = std::max(peak, std::stod(series[row][1]));
  EXPECT_LT(summary()["final"]["kinetic"], 1e-6 * peak);
  EXPECT_LT(summary()["final"]["max_stretch"], 0.01);
}

/// Largest memory that any program run so far has held [MB].
double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  return double(usage.ru_maxrss) / 1024;
}

// 300,000 steps, of which the last 280,000 are at rest; and as many undamped ones, which never are. What
// leaked in each would be 9.6 MB at least: 32 bytes are the smallest piece of memory there is.
TEST_F(RunCommand, ManyStepsNeitherLeakNorDrift) {
  const fs::path scene = fs::path(MSS_SOURCE_DIR) / "experiments" / "scenes" / "fig5_2_bounce.toml";
  const std::string duration = MSS_SANITIZED ? "30" : "300";
  ASSERT_EQ(run(scene, {"--set", "solve.duration=1"}).exit_status, 0);
  const double before = peak_memory();
  for (const std::string damping : {"0.3", "0"}) {
    ASSERT_EQ(run(scene, {"--set", "solve.duration=" + duration, "--set", "solve.every=1", "--set",
                          "solve.threads=1", "--set", "damping.ratio=" + damping})
                  .exit_status,
              0);
    const auto series = parse_csv(read_file(out() / "series.csv"));
    ASSERT_GE(series.size(), 30U);
    for (std::size_t row = 21; row < series.size(); ++row)
      EXPECT_NEAR(std::stod(series[row][6]), std::stod(series[21][6]), damping == "0" ? 2e-3 : 1e-9) << row;
  }
  if (!MSS_SANITIZED) {
    EXPECT_LT(peak_memory() - before, 4);
  }
}

TEST_F(RunCommand, AHardLandingFoldsCells) {
  const fs::path scenes = fs::path(MSS_SOURCE_DIR) / "experiments" / "scenes";
  ASSERT_EQ(run(scenes / "fig5_4_landing.toml").exit_status, 0);
  EXPECT_LT(summary()["final"]["min_jacobian"], -0.5);
  ASSERT_EQ(run(scenes / "fig5_4_landing.toml", {"--set", "start.velocity=[-14,-14,-14]"}).exit_status, 0);
  EXPECT_GT(summary()["final"]["min_jacobian"], 0.5);  // a softer one does not
  ASSERT_EQ(run(scenes / "fig5_4_landing.toml",
                {"--set", "start.velocity=[-30,-30,-30]", "--set", "material.fold_guard=20"})
                .exit_status,
            0);
  EXPECT_LT(summary()["final"]["max_stretch"], 1e-6);  // with the guard it lands harder and recovers
  EXPECT_GT(summary()["final"]["min_jacobian"], 0.999);
}

TEST_F(RunCommand, TheFoldGuardDoesNotChangeABitWhereNothingFolds) {
  const fs::path scenes = fs::path(MSS_SOURCE_DIR) / "experiments" / "scenes";
  for (const char* scene : {"cantilever.toml", "fig5_2_bounce.toml", "free_cube.toml"}) {
    ASSERT_EQ(run(scenes / scene, {"--set", "solve.duration=0.5"}).exit_status, 0);
    const std::string without = read_file(out() / "particles.csv");
    ASSERT_EQ(
        run(scenes / scene, {"--set", "solve.duration=0.5", "--set", "material.fold_guard=20"}).exit_status,
        0);
    EXPECT_EQ(without, read_file(out() / "particles.csv")) << scene;
  }
}

TEST_F(RunCommand, JellySlidesAndTablesStand) {
  const fs::path scenes = fs::path(MSS_SOURCE_DIR) / "experiments" / "scenes";
  ASSERT_EQ(run(scenes / "jelly_slope.toml").exit_status, 0);
  EXPECT_LT(summary()["final"]["max_speed"], 0.01);
  EXPECT_LT(summary()["final"]["external_potential"].get<double>(), 0);  // it is down on the level ground
  ASSERT_EQ(run(scenes / "soft_table.toml").exit_status, 0);
  EXPECT_LT(summary()["final"]["max_speed"], 0.05);
  EXPECT_NEAR(summary()["final"]["volume_ratio"].get<double>(), 1, 0.02);
}

/// Bad input from outside: status 2, one line that names the file and what to do, and no output.
TEST_F(RunCommand, BadScenesLeaveNothing) {
  const auto with = [](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  const std::string good = cube;
  write("ragged.txt", "##\n#\n");
  const std::vector<std::pair<std::string, std::string>> cases{
      {"[body\n", "TOML"},
      {good + "[wheels]\n", "wheels"},
      {with(good, "density = 1000", "densty = 1000"), "density"},
      {with(good, "density = 1000", "density = \"heavy\""), "material.density"},
      {with(good, "density = 1000", "density = -5"), "material.density"},
      {with(good, "density = 1000", "density = nan"), "material.density"},
      {with(good, "density = 1000", "density = inf"), "material.density"},
      {with(good, "poisson = 0.3", "poisson = 0.5"), "material.poisson"},
      {with(good, "young = 1e5", "young = 0"), "material.young"},
      {with(good, "young = 1e5\n", ""), "young"},
      {with(good, "dt = 1e-4", "dt = 0"), "solve.dt"},
      {with(good, "dt = 1e-4", "dt = 1"), "solve.dt"},
      {with(good, "duration = 0.05", "duration = -1"), "solve.duration"},
      {with(good, "cells = [2, 2, 2]", "cells = [0, 0, 0]"), "body.cells"},
      {with(good, "cells = [2, 2, 2]", "cells = [2, 2]"), "body.cells"},
      {with(good, "cells = [2, 2, 2]", "voxels = \"ragged.txt\""), "ragged.txt"},
      {with(good, "cells = [2, 2, 2]", "voxels = \"none.txt\""), "none.txt"},
      {with(good, "cell_size = 0.1", "cell_size = 0"), "body.cell_size"},
      {with(good, "velocity_verlet", "velocity_verle"), "velocity_verlet"},
      {with(good, "velocity_verlet\"\ndt = 1e-4", "explicit_euler\"\ndt = \"safe\""), "explicit_euler"},
      {with(good, "velocity_verlet\"\ndt = 1e-4", "tr_bdf2\"\ndt = \"safe\""), "any step"},
      {with(good, "velocity_verlet\"", "cvode_bdf\"\nprecision = \"single\""), "double precision only"},
      {with(good, "velocity_verlet\"", "backward_euler\"\nlinear_solver = \"cholmid\""), "'cholmod'"},
      {with(good, "velocity_verlet\"", "backward_euler\"\nnonlinear_solver = \"lbfg\""), "'lbfgs'"},
      {with(good, "density = 1000", "density = 1000\nmodel = \"corotated\""), "'corotational'"},
      {with(with(good, "density = 1000", "density = 1000\nmodel = \"linear\""), "dt = 1e-4",
            "dt = 1e-4\nprecision = \"single\""),
       "double precision only"},
      {with(with(with(good, "density = 1000", "density = 1000\nmodel = \"linear\""), "young = 1e5\n", ""),
            "poisson = 0.3", "springs = { edge = 1, face = 1, body = 1 }"),
       "material.young"},
      {good + "[[hold]]\nbox = [[5, 5, 5], [6, 6, 6]]\n", "hold"},
      {good + "[[hold]]\nbox = [[1, 0, 0], [0, 1, 1]]\n", "box"},
      {good + "[[load]]\nbox = [[5, 5, 5], [6, 6, 6]]\nforce = [0, 0, 1]\n", "load"},
      {good + "[damping]\nratio = -1\n", "damping.ratio"},
      {good + "[[plane]]\npoint = [0, 0, -1]\n", "plane.0.normal"},
      {with(good, "velocity_verlet\"", "cvode_bdf\"") + "[[plane]]\npoint = [0, 0, -1]\nnormal = [0, 0, 1]\n",
       "contact = \"impulse\" acts in fixed steps, and cvode_bdf has none"},
      {with(good, "velocity_verlet\"", "static\"") +
           "[[plane]]\npoint = [0, 0, -1]\nnormal = [0, 0, 1]\ncontact = \"thesis\"\n",
       "static takes none; give contact = \"impulse\" on particles"}};
  for (const auto& [text, named] : cases) {
    const ProgramRun result = run(write("bad.toml", text));
    EXPECT_EQ(result.exit_status, 2) << text << result.output;
    EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), 1) << result.output;
    EXPECT_NE(result.output.find(named), std::string::npos) << result.output;
    EXPECT_NE(result.output.find("bad"), std::string::npos)
        << result.output;  // the file, or the scene's name
    EXPECT_FALSE(fs::exists(out())) << text;
  }
  const ProgramRun missing = run("nowhere.toml");
  EXPECT_EQ(missing.exit_status, 2);
  EXPECT_NE(missing.output.find("nowhere.toml"), std::string::npos);
  EXPECT_FALSE(fs::exists(out()));
}

}  // namespace
}  // namespace mss

// Runs that go on from others: what they compute is what one run would have, whatever the method keeps.
#include "experiments/simulation/restart.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "core/base/error.hpp"
#include "experiments/io/output.hpp"
#include "experiments/simulation/result_files.hpp"
#include "experiments/simulation/simulation.hpp"
#include "integrators/linear/linear_solver.hpp"
#include "integrators/nonlinear/implicit_stage.hpp"
#include "tests/core/scene/scene_texts.hpp"
#include "tests/experiments/stop_after.hpp"

namespace mss {
namespace {

/// A beam whose held end moves, that falls onto a plane, is pulled and is struck: before, at and after the
/// third of the run.
const std::string beam = R"([body]
cells = [3, 2, 2]
cell_size = 0.1
[material]
density = 1000
young = 1e5
poisson = 0.3
[damping]
ratio = 0.1
[environment]
gravity = [0, 0, -9.81]
[[hold]]
box = [[0, 0, 0], [0, 0.2, 0.2]]
path = [[0, 0, 0, 0], [0.012, 0, 0.01, 0], [0.05, 0.01, 0.01, 0]]
[[load]]
box = [[0.3, 0, 0], [0.3, 0.2, 0.2]]
force = [0, 4, 0]
history = [[0, 0], [0.02, 1]]
[[strike]]
box = [[0.3, 0, 0], [0.3, 0.2, 0.2]]
at = 0.0042
impulse = [0, 0.1, -0.2]
[[strike]]
box = [[0.3, 0, 0], [0.3, 0.2, 0.2]]
at = 0.01
impulse = [0.1, 0, 0]
[[strike]]
box = [[0.3, 0, 0], [0.3, 0.2, 0.2]]
at = 0.0212
impulse = [0, -0.1, 0.1]
[[plane]]
point = [0, 0, -0.0002]
normal = [0, 0, 1]
friction = 0.5
[solve]
dt = 5e-4
duration = 0.03
every = 0.0025
threads = 1
)";

/// After steps without a collision nothing makes a method forget its history.
const std::string beam_in_the_air =
    beam.substr(0, beam.find("[[plane]]")) + beam.substr(beam.find("[solve]"));

using Settings = std::vector<std::string>;

Settings with(Settings settings, const Settings& more) {
  settings.insert(settings.end(), more.begin(), more.end());
  return settings;
}

/// What methods need to drive it.
Settings settings_for(const IntegratorInfo& method, const std::string& text = beam) {
  Settings settings{"solve.integrator=\"" + method.name + "\""};
  const bool has_plane = text == beam;
  if (has_plane && method.collisions == Collisions::never)
    settings.emplace_back("plane.0.contact=\"penalty\"");
  if (!method.has_modulus) settings.emplace_back("damping.ratio=0");
  if (method.stepping == Stepping::equilibrium) settings.emplace_back("solve.every=0.01");
  return settings;
}

std::string files_of(const SimulationResult& result) {
  std::ostringstream particles;
  write_particles(particles, result.particles);
  return series_table(result.series).csv() + particles.str();
}

struct Ended {
  SimulationResult result;
  Restart left;
};

/// What is left goes through a file.
Ended run(const Scene& scene, Progress&& progress = {}, Restart* from = nullptr) {
  const testing::SceneFolder folder;
  Ended ended;
  if (from) check_restart(*from, scene, folder.path());
  ended.result = simulate(scene, progress, {}, {}, {.from = from, .keep = [&](const Restart& left) {
                                                      write_restart(folder.path() / restart_file, left);
                                                    }});
  ended.left = read_restart(folder.path());
  return ended;
}

void expect_same(const SimulationResult& whole, const SimulationResult& parts) {
  ASSERT_EQ(whole.status, Status::ok);
  ASSERT_EQ(parts.status, Status::ok);
  EXPECT_EQ(files_of(whole), files_of(parts));
  EXPECT_EQ(whole.work.steps, parts.work.steps);
  EXPECT_EQ(whole.work.force_evaluations, parts.work.force_evaluations);
  EXPECT_EQ(whole.work.factorisations, parts.work.factorisations);
  EXPECT_EQ(whole.work.linear_solves, parts.work.linear_solves);
  ASSERT_EQ(whole.gain.has_value(), parts.gain.has_value());
  if (whole.gain) {
    EXPECT_EQ(whole.gain->gained, parts.gain->gained);
  }
  ASSERT_EQ(whole.penetrations.size(), parts.penetrations.size());
  for (std::size_t i = 0; i < whole.penetrations.size(); ++i)
    EXPECT_EQ(whole.penetrations[i].depth, parts.penetrations[i].depth);
}

/// At a row, between rows because the run is shorter, and because it is interrupted.
void expect_goes_on(const Settings& settings, const std::string& text = beam) {
  const Scene scene = parse_scene(text, settings);
  const Ended whole = run(scene);
  for (const char* third : {"0.01", "0.0113"}) {
    SCOPED_TRACE(::testing::PrintToString(settings) + " from " + third);
    Ended first = run(parse_scene(text, with(settings, {std::string("solve.duration=") + third})));
    ASSERT_EQ(first.result.status, Status::ok);
    Ended second = run(scene, {}, &first.left);
    expect_same(whole.result, second.result);
    ASSERT_EQ(second.result.continued.size(), 1U);
    EXPECT_TRUE(second.result.continued[0].exact);
  }
}

void expect_goes_on_interrupted(const Settings& settings) {
  SCOPED_TRACE(::testing::PrintToString(settings) + " interrupted");
  const Scene scene = parse_scene(beam, with(settings, {"solve.every=0.06", "solve.duration=0.08"}));
  const Ended whole = run(scene);
  Ended part = run(scene, StopAfter(1));
  ASSERT_EQ(part.result.status, Status::interrupted);
  EXPECT_LT(part.left.t, 0.059);
  part = run(scene, StopAfter(2), &part.left);  // and once more
  if (part.result.status == Status::interrupted) part = run(scene, {}, &part.left);
  expect_same(whole.result, part.result);
}

TEST(Restart, IsExactForEveryMethodThatSaysSo) {
  for (const IntegratorInfo& method : integrators()) {
    if (!method.exact_restart || method.stepping == Stepping::reduced) continue;
    expect_goes_on(settings_for(method));
    expect_goes_on(settings_for(method, beam_in_the_air), beam_in_the_air);
    if (method.make_single) expect_goes_on(with(settings_for(method), {"solve.precision=\"single\""}));
    if (method.stepping == Stepping::fixed) expect_goes_on_interrupted(settings_for(method));
  }
}

TEST(Restart, IsExactWithEverySolver) {
  for (const LinearSolverInfo& solver : linear_solvers())
    expect_goes_on({"solve.integrator=\"generalized_alpha\"", "solve.linear_solver=\"" + solver.name + "\""});
  for (const NonlinearSolverInfo& solver : nonlinear_solvers())
    for (const std::string method : {"backward_euler", "tr_bdf2", "static"})
      expect_goes_on(
          with(settings_for(find_integrator(method)), {"solve.nonlinear_solver=\"" + solver.name + "\""}));
  for (const char* method : {"xpbd:5", "vbd:5", "backward_euler/lbfgs:5"})
    expect_goes_on({"solve.integrator=\"" + std::string(method) + "\""});
  expect_goes_on({"solve.integrator=\"vbd:5\"", "solve.chebyshev_radius=0.5"});
}

TEST(Restart, IsExactWhereLawsOfContactDiffer) {
  for (const std::string law : {"penalty", "thesis"})
    for (const std::string method : {"verlet", "velocity_verlet", "rk4"})
      expect_goes_on({"plane.0.contact=\"" + law + "\"", "solve.integrator=\"" + method + "\""});
  expect_goes_on({"plane.0.contact=\"penalty\"", "solve.integrator=\"backward_euler\""});
}

TEST(Restart, IsExactForOtherModelsAndCells) {
  expect_goes_on({"material.model=\"corotational\"", "solve.integrator=\"backward_euler\""});
  expect_goes_on({"material.model=\"mollemans\"", "solve.integrator=\"velocity_verlet\""});
}

// Steps that do not divide the rows' time end beside rows, and half a step rounds up or down.
TEST(Restart, IsExactWhereRowsAreBetweenSteps) {
  for (const char* every : {"0.0027", "0.00125", "2e-4"})
    for (const std::string method : {"velocity_verlet", "backward_euler"})
      expect_goes_on({std::string("solve.every=") + every, "solve.integrator=\"" + method + "\""});
  const std::string cube = testing::cube_text("0.1") + R"([start]
angular_velocity = [0, 0, 5]
[solve]
dt = 5e-4
duration = 0.02775
every = 0.00925  # 18.5 steps
)";
  const Ended whole = run(parse_scene(cube));
  for (int steps = 1; steps < 37; ++steps) {
    SCOPED_TRACE(steps);
    const std::string duration = "solve.duration=" + std::to_string(steps * 5e-4);
    Ended first = run(parse_scene(cube, {duration}));
    expect_same(whole.result, run(parse_scene(cube), {}, &first.left).result);
  }
}

// Of steps that are taken at once t is counted together: here in rows of 37 steps, whose ends are not set
// right.
TEST(Restart, IsExactWhereStepsAreTakenTogether) {
  const std::string cube = testing::cube_text("0.1") + R"([start]
angular_velocity = [0, 0, 5]
[[hold]]
box = [[0, 0, 0], [0, 0.2, 0.2]]
velocity = [0.01, 0, 0]
[solve]
dt = 5.123456789e-4
duration = 0.08
every = 0.0191
)";
  for (const char* method : {"semi_implicit_euler", "velocity_verlet", "pefrl", "xpbd", "backward_euler"}) {
    const Settings settings{"solve.integrator=\"" + std::string(method) + "\""};
    const Ended whole = run(parse_scene(cube, settings));
    for (int steps = 5; steps < 150; steps += 7) {
      SCOPED_TRACE(::testing::Message() << method << " " << steps);
      const std::string duration = "solve.duration=" + std::to_string(steps * 5.123456789e-4);
      Ended first = run(parse_scene(cube, with(settings, {duration})));
      expect_same(whole.result, run(parse_scene(cube, settings), {}, &first.left).result);
    }
  }
}

// A fall onto a soft plane by a method that is not stable, with a strike that supplies part of its energy.
TEST(Restart, KeepsWhatARunWatches) {
  const std::string fall = testing::cube_text("0.1") + R"([environment]
gravity = [0, 0, -9.81]
[start]
velocity = [0, 0, -4]
[[strike]]
box = [[0, 0, 0], [0.2, 0.2, 0.2]]
at = 0.01
impulse = [20, 0, 0]
[[plane]]
point = [0, 0, -0.02]
normal = [0, 0, 1]
contact = "penalty"
[solve]
integrator = "explicit_euler"
dt = 1e-3
duration = 0.06
every = 0.01
)";
  const Scene scene = parse_scene(fall);
  const Ended whole = run(scene);
  EXPECT_TRUE(whole.result.gain);
  EXPECT_EQ(whole.result.penetrations.size(), 1U);
  for (const char* duration : {"0.02", "0.025", "0.04", "0.05"}) {
    Ended first = run(parse_scene(fall, {std::string("solve.duration=") + duration}));
    expect_same(whole.result, run(scene, {}, &first.left).result);
  }
}

/// Whether what a scene of its own computes is the same with an interruption at a report, and after it.
void expect_same_interrupted(const std::string& text, int reports) {
  const Scene scene = parse_scene(text);
  const Ended whole = run(scene);
  Ended first = run(scene, StopAfter(reports));
  ASSERT_EQ(first.result.status, Status::interrupted);
  Ended second = run(scene, {}, &first.left);
  expect_same(whole.result, second.result);
  ASSERT_EQ(whole.result.sleep.has_value(), second.result.sleep.has_value());
  if (!whole.result.sleep) return;
  EXPECT_EQ(whole.result.sleep->share, second.result.sleep->share);
  EXPECT_EQ(whole.result.sleep->largest_deviation, second.result.sleep->largest_deviation);
}

TEST(Restart, KeepsWhatSleeps) {
  const std::string block = R"([body]
cells = [2, 2, 8]
cell_size = 0.1
[material]
density = 1000
young = 2e5
poisson = 0.3
[damping]
ratio = 0.5
[environment]
gravity = [0, 0, -1]
[[plane]]
point = [0, 0, 0]
normal = [0, 0, 1]
[[strike]]
box = [[0, 0, 0.8], [0.2, 0.2, 0.8]]
at = 1.21
impulse = [0.5, 0, 0]
[solve]
integrator = "velocity_verlet"
dt = 2e-3
duration = 1.6
every = 0.1
sleep = 0.01
sleep_after = 0.2
)";
  for (const int reports : {5, 11, 12, 14}) expect_same_interrupted(block, reports);
}

TEST(Restart, KeepsCellsOfSeveralSizes) {
  const std::string refined = R"([body]
cells = [4, 2, 2]
cell_size = 0.1
[material]
density = 1000
young = 1e5
poisson = 0.3
[[refine]]
box = [[0.2, 0, 0], [0.4, 0.2, 0.2]]
[environment]
gravity = [0, 0, -9.81]
[[plane]]
point = [0, 0, -0.001]
normal = [0, 0, 1]
[solve]
duration = 0.06
every = 0.01
)";
  for (const char* method :
       {"\nintegrator = \"verlet\"\nlocal_steps = true\n", "\nintegrator = \"damped_verlet\"\n",
        "\nintegrator = \"backward_euler\"\ndt = 1e-3\n",
        "\nintegrator = \"backward_euler/lbfgs:2\"\ndt = 1e-3\n"})
    expect_same_interrupted(refined + method, 3);
}

TEST(Restart, IsWithinToleranceForAdaptiveMethods) {
  constexpr double h = 0.1;
  for (const IntegratorInfo& method : integrators()) {
    if (method.exact_restart) continue;
    SCOPED_TRACE(method.name);
    EXPECT_EQ(method.stepping, Stepping::adaptive);
    const Scene scene = parse_scene(beam, settings_for(method));
    const Ended whole = run(scene);
    Ended first = run(parse_scene(beam, with(settings_for(method), {"solve.duration=0.0113"})));
    EXPECT_NEAR(first.left.t, 0.01, 1e-12);  // the part of a row is computed again
    Ended second = run(scene, {}, &first.left);
    EXPECT_FALSE(second.result.continued.at(0).exact);
    ASSERT_EQ(whole.result.series.size(), second.result.series.size());
    double apart = 0;
    for (std::size_t id = 0; id < whole.result.particles.size(); ++id)
      apart = std::max(apart, (whole.result.particles[id].x - second.result.particles[id].x).norm());
    EXPECT_LT(apart, 100 * scene.solve.tolerance * h);
    RecordProperty(method.name, std::to_string(apart / (scene.solve.tolerance * h)));
  }
}

TEST(Restart, IsLeftWhileARunIsUnderWay) {
  const Scene scene = parse_scene(beam);
  Progress progress;
  std::vector<Restart> left;
  const SimulationResult whole =
      simulate(scene, progress, {}, {},
               {.keep = [&](const Restart& restart) { left.push_back(restart); }, .seconds_between = 0});
  ASSERT_EQ(left.size(), whole.series.size() - 1);
  for (const std::size_t i : {std::size_t(1), left.size() - 2})
    expect_same(whole, simulate(scene, progress, {}, {}, {.from = &left[i]}));
}

TEST(Restart, CountsWhatItWentOnFrom) {
  const Scene scene = parse_scene(beam);
  Ended first = run(parse_scene(beam, {"solve.duration=0.005"}));
  Ended second = run(parse_scene(beam, {"solve.duration=0.01"}), {}, &first.left);
  const Ended third = run(scene, {}, &second.left);
  ASSERT_EQ(third.result.continued.size(), 2U);
  EXPECT_EQ(third.result.continued[0].t, 0.005);
  EXPECT_EQ(third.result.continued[1].t, 0.01);
  EXPECT_GE(third.result.wall_seconds, second.result.wall_seconds);
}

std::string refusal(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing is refused";
}

std::string refusal(const Restart& left, const Settings& settings) {
  return refusal([&] { check_restart(left, parse_scene(beam, settings), "DIR"); });
}

void expect_says(const std::string& sentence, const std::string& words) {
  EXPECT_NE(sentence.find(words), std::string::npos) << sentence;
}

TEST(Restart, RefusesAnotherScene) {
  Ended first = run(parse_scene(beam, {"solve.duration=0.01"}));
  const Restart& left = first.left;
  expect_says(refusal(left, {"material.young=2e5"}), "material.young = 200000.0, and the run had 100000.0");
  expect_says(refusal(left, {"solve.dt=4e-4"}), "solve.dt = 0.0004, and the run had 0.0005");
  expect_says(refusal(left, {"solve.integrator=\"rk4\""}),
              "solve.integrator = \"rk4\", and the run had \"verlet\"");
  expect_says(refusal(left, {"solve.precision=\"single\""}), "solve.precision = \"single\"");
  expect_says(refusal(left, {"solve.every=0.001"}), "solve.every");
  expect_says(refusal(left, {"strike.2.at=0.02"}), "strike.2.at = 0.02, and the run had 0.0212");
  expect_says(refusal(left, {"body.cells=[3,2,3]"}), "body.cells.2 = 3, and the run had 2");
  expect_says(refusal(left, {"solve.duration=0.01"}), "that run is at 0.01 s, and solve.duration = 0.01 s");
  expect_says(refusal(left, {"solve.duration=0.005"}), "give a longer one");
  EXPECT_EQ(refusal(left, {"solve.threads=2"}), "nothing is refused");
  first.left.status = Status::non_finite;
  expect_says(refusal(left, {}), "that run ended with non_finite at 0.01 s");
}

TEST(Restart, RefusesAnotherBodyOfThatName) {
  const testing::SceneFolder folder;
  const auto scene = folder.write("scene.toml", R"([body]
voxels = "cells.txt"
cell_size = 0.1
[material]
density = 1000
young = 1e5
poisson = 0.3
[solve]
duration = 0.02
)");
  folder.write("cells.txt", "##\n#.\n");
  Ended first = run(load_scene(scene, {"solve.duration=0.01"}));
  folder.write("cells.txt", "##\n.#\n");
  expect_says(refusal([&] { run(load_scene(scene), {}, &first.left); }), "its cells are not those");
}

TEST(Restart, RefusesWhatIsNotWhole) {
  const testing::SceneFolder folder;
  const auto file = folder.path() / restart_file;
  const auto sentence = [&] { return refusal([&] { read_restart(folder.path()); }); };
  expect_says(refusal([&] { read_restart(folder.path() / "nowhere"); }), "there is no such folder");
  expect_says(sentence(), "it has no restart.bin");
  write_restart(file, run(parse_scene(beam, {"solve.duration=0.01"})).left);
  const std::string text = read_file(file);
  EXPECT_EQ(sentence(), "nothing is refused");
  const auto expect_refused = [&](const std::string& changed, const std::string& words) {
    write_atomically(file, changed);
    expect_says(sentence(), words);
  };
  expect_refused(text.substr(0, text.size() - 1), "changed or cut short");
  expect_refused(text.substr(0, 20), "changed or cut short");
  expect_refused(text + "x", "changed or cut short");
  std::string flipped = text;
  flipped[text.size() - 100] ^= 1;
  expect_refused(flipped, "changed or cut short");
  const std::size_t t = text.find("\"t\":");
  ASSERT_NE(t, std::string::npos);
  std::string later = text;
  const std::size_t digit = later.find_first_of("123456789", t);
  later[digit] = later[digit] == '9' ? '8' : '9';
  expect_refused(later, "changed or cut short");
  expect_refused("", "another version of mss");
  expect_refused(testing::replaced(text, "mss restart 2", "mss restart 3"), "another version of mss");
  Restart other = run(parse_scene(beam, {"solve.duration=0.01"})).left;
  other.record.resize(other.record.size() - 8);  // of a program that keeps less
  expect_says(refusal([&] { run(parse_scene(beam), {}, &other); }), "which kept other things");
}

TEST(Restart, IsNoneOfARunThatFailed) {
  const Scene scene = parse_scene(
      beam, {"solve.dt=0.05", "solve.duration=50", "solve.every=1", "plane.0.contact=\"penalty\""});
  const Ended failed = run(scene);
  ASSERT_EQ(failed.result.status, Status::non_finite);
  EXPECT_TRUE(failed.left.record.empty());
  expect_says(refusal([&] { check_restart(failed.left, scene, "DIR"); }), "ended with non_finite");
}

}  // namespace
}  // namespace mss

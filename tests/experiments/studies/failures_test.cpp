// `mss stability failures`: the safe step is stable, and what should fail does, with the right outcome.
#include "experiments/studies/failures/failures.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "experiments/simulation/model.hpp"
#include "tests/experiments/stop_after.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::failures {
namespace {

FailureRun try_one(const std::string& scene, double severity, const std::string& integrator,
                   bool guarded = false) {
  const auto& all = failure_scenes();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const FailureScene& s) { return s.name == scene; });
  EXPECT_NE(found, all.end()) << scene;
  StressCase stress_case = unloaded_cube();
  found->set(stress_case, severity);
  if (guarded) stress_case.body.fold_guard = default_fold_guard;
  return try_scene(stress_case, find_integrator(integrator));
}

TEST(Failures, RandomScenesAreStableAtTheSafeStep) {
  int with_plane = 0, held = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const RandomScene scene = random_scene(seed);
    with_plane += scene.environment.planes.empty() ? 0 : 1;
    held += scene.environment.holds.empty() ? 0 : 1;
    const FailureRun run = try_scene(scene);
    EXPECT_EQ(run.outcome, Outcome::stable) << seed << ", " << scene.integrator;
    EXPECT_GT(run.dt, 0);
  }
  EXPECT_GT(with_plane, 15);
  EXPECT_GT(held, 8);
}

TEST(Failures, HaveTheRightOutcome) {
  EXPECT_EQ(try_one("stretch", 1.2, "verlet").outcome, Outcome::stable);
  EXPECT_EQ(try_one("spin", 10, "verlet").outcome, Outcome::blows_up);
  EXPECT_EQ(try_one("spin", 10, "cvode_bdf").outcome, Outcome::too_many_steps);
  EXPECT_EQ(try_one("stretch", 4, "tr_bdf2").outcome, Outcome::stalls);
  EXPECT_EQ(try_one("drop", 1000, "velocity_verlet").outcome, Outcome::folds);
  EXPECT_EQ(try_one("drop", 1000, "velocity_verlet", true).outcome, Outcome::stable);
}

TEST(Failures, AMethodWithoutAStepForABodyRefuses) {
  EXPECT_EQ(try_one("stretch", 1.2, "xpbd").outcome, Outcome::stable);
  EXPECT_EQ(try_one("stretch", 1.2, "xpbd", true).outcome, Outcome::refused);
  EXPECT_EQ(try_one("negative_volume", 0.1, "vbd:5").outcome, Outcome::refused);
}

// Across a spring of no length stiffness has no bound; implicit methods must be stable nevertheless.
TEST(Failures, SpringsOfNoLengthAreStable) {
  for (const IntegratorInfo& method : integrators()) {
    if (method.stepping == Stepping::equilibrium || !method.has_modulus) continue;
    EXPECT_EQ(try_one("merged", 1, method.name).outcome, Outcome::stable) << method.name;
  }
}

TEST(Failures, VaryingStepsCoverTheSameTime) {
  const FailureRun even = try_one("stretch", 1.2, "verlet"), varying = try_one("jump", 10, "verlet");
  EXPECT_EQ(varying.outcome, Outcome::stable);
  EXPECT_EQ(even.dt, varying.dt);
  EXPECT_NEAR(varying.seconds / even.seconds, 1, 0.01);
  // Of each pair of steps the second is a tenth as long.
  EXPECT_NEAR(double(varying.steps) / double(even.steps), 2 / 1.1, 0.02);
}

FailureConfig drops() {
  FailureConfig config = failure_config({.quick = true, .integrators = {"verlet", "backward_euler_linear"}});
  std::erase_if(config.scenes, [](const FailureScene& scene) { return scene.name != "drop"; });
  config.random_scenes = 5;
  return config;
}

TEST(Failures, AreTheSameHoweverTheyAreSplit) {
  const FailureConfig config = drops();
  const auto run = [&](int processes) {
    Journal journal;
    Progress progress;
    return measure_failures(config, processes, journal, progress);
  };
  const FailureTables one = run(1), four = run(4);
  EXPECT_EQ(one.rows.size(), 2U * 2 * 2);
  EXPECT_EQ(one.random.size(), 5U);
  EXPECT_EQ(one.rows.csv(), four.rows.csv());
  EXPECT_EQ(one.random.csv(), four.random.csv());
}

TEST(Failures, DrawTheSameFromTheirFiles) {
  for (const int reports : {3, 1000}) {  // interrupted, and not
    Journal journal;
    StopAfter progress(reports);
    FailureTables tables = measure_failures(drops(), 2, journal, progress);
    EXPECT_EQ(tables.status, reports == 3 ? Status::interrupted : Status::ok);
    expect_same_drawings(find_experiment("failures"), failure_files(std::move(tables)));
  }
}

}  // namespace
}  // namespace mss::studies::failures

// `mss stability failures`: the safe step is, and what should fail does, by name.
#include "experiments/studies/failures/failures.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "experiments/simulation/model.hpp"

namespace mss::studies::failures {
namespace {

FailureRun try_one(const std::string& scene, double severity, const std::string& integrator,
                   bool guarded = false) {
  const auto& all = failure_scenes();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const FailureScene& s) { return s.name == scene; });
  EXPECT_NE(found, all.end()) << scene;
  Hardship hardship = at_ease();
  found->set(hardship, severity);
  if (guarded) hardship.body.fold_guard = usual_fold_guard;
  return try_scene(hardship, find_integrator(integrator));
}

TEST(Failures, RandomScenesHoldAtTheSafeStep) {
  int with_plane = 0, held = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const RandomScene scene = random_scene(seed);
    with_plane += scene.environment.planes.empty() ? 0 : 1;
    held += scene.environment.holds.empty() ? 0 : 1;
    const FailureRun run = try_scene(scene);
    EXPECT_EQ(run.fate, Fate::holds) << seed << ", " << scene.integrator;
    EXPECT_GT(run.dt, 0);
  }
  EXPECT_GT(with_plane, 15);
  EXPECT_GT(held, 8);
}

TEST(Failures, AreNamed) {
  EXPECT_EQ(try_one("stretch", 1.2, "verlet").fate, Fate::holds);
  EXPECT_EQ(try_one("spin", 10, "verlet").fate, Fate::blows_up);
  EXPECT_EQ(try_one("spin", 10, "cvode_bdf").fate, Fate::too_many_steps);
  EXPECT_EQ(try_one("stretch", 4, "tr_bdf2").fate, Fate::stalls);
  EXPECT_EQ(try_one("drop", 1000, "velocity_verlet").fate, Fate::folds);
  EXPECT_EQ(try_one("drop", 1000, "velocity_verlet", true).fate, Fate::holds);
}

// Across a spring of no length stiffness has no bound; implicit methods must live with that.
TEST(Failures, SpringsOfNoLengthAreNoTrouble) {
  for (const IntegratorInfo& method : integrators()) {
    if (method.stepping == Stepping::equilibrium) continue;
    EXPECT_EQ(try_one("merged", 1, method.name).fate, Fate::holds) << method.name;
  }
}

TEST(Failures, StepsThatJumpTakeTheirTime) {
  const FailureRun even = try_one("stretch", 1.2, "verlet"), jumping = try_one("jump", 10, "verlet");
  EXPECT_EQ(jumping.fate, Fate::holds);
  EXPECT_EQ(even.dt, jumping.dt);
  EXPECT_NEAR(jumping.seconds / even.seconds, 1, 0.01);
  // Of each pair of steps the second is a tenth as long.
  EXPECT_NEAR(double(jumping.steps) / double(even.steps), 2 / 1.1, 0.02);
}

TEST(Failures, AreTheSameHoweverTheyAreSplit) {
  FailureConfig config = failure_config({.quick = true, .integrators = {"verlet", "backward_euler_linear"}});
  std::erase_if(config.scenes, [](const FailureScene& scene) { return scene.name != "drop"; });
  config.random_scenes = 5;
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

}  // namespace
}  // namespace mss::studies::failures

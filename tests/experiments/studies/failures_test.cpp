// `mss stability failures`: the safe step is stable, and what should fail does, with the right outcome.
#include "experiments/studies/failures/failures.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/experiments/stop_after.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::failures {
namespace {

constexpr Variant guarded{.guarded = true, .guarded_step = true};

FailureRun try_one(const std::string& scene, double severity, const std::string& integrator,
                   Variant variant = {}) {
  const auto& all = failure_scenes();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const FailureScene& s) { return s.name == scene; });
  EXPECT_NE(found, all.end()) << scene;
  StressCase stress_case = unloaded_cube();
  found->set(stress_case, severity);
  return try_scene(stress_case, find_integrator(integrator), variant);
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
  EXPECT_EQ(try_one("drop", 1000, "velocity_verlet", guarded).outcome, Outcome::stable);
}

// A body takes the guarded body's step without its guard.
TEST(Failures, CompareTheGuardAtOneStep) {
  for (const char* method : {"verlet", "backward_euler", "explicit_euler"}) {
    const FailureRun plain = try_one("stretch", 1.2, method),
                     plain_shorter = try_one("stretch", 1.2, method, {.guarded_step = true}),
                     with_guard = try_one("stretch", 1.2, method, guarded);
    EXPECT_EQ(plain_shorter.dt, with_guard.dt) << method;
    EXPECT_LE(plain_shorter.dt, plain.dt) << method;
    EXPECT_NEAR(plain_shorter.extremes.min_jacobian, with_guard.extremes.min_jacobian, 1e-9)
        << method << ": in so small a deformation the guard does not act";
  }
  EXPECT_LT(try_one("stretch", 1.2, "verlet", guarded).dt, 0.5 * try_one("stretch", 1.2, "verlet").dt);
  const FailureRun plain = try_one("compression", 0.3, "verlet", {.guarded_step = true}),
                   with_guard = try_one("compression", 0.3, "verlet", guarded);
  EXPECT_GT(with_guard.extremes.initial_energy, 1.1 * plain.extremes.initial_energy);
}

TEST(Failures, UndampedExplicitEulerBlowsUpAtAnyStep) {
  for (const Variant variant : variants)
    EXPECT_EQ(try_one("damping", 0, "explicit_euler", variant).outcome, Outcome::blows_up);
  EXPECT_EQ(try_one("damping", 0, "velocity_verlet").outcome, Outcome::stable);
}

// Energy above the initial one counts, though the body's damping dissipates it again.
TEST(Failures, AGainOfEnergyIsOne) {
  const FailureRun merged = try_one("merged", 1, "generalized_alpha");
  EXPECT_EQ(merged.outcome, Outcome::gains_energy);
  EXPECT_GT(merged.extremes.max_energy, 1.05 * merged.extremes.initial_energy);
  const FailureRun stable = try_one("stretch", 1.2, "verlet");
  EXPECT_LE(stable.extremes.max_energy, 1.05 * stable.extremes.initial_energy);
}

// What would fall through the ground is refused.
TEST(Failures, EveryDropTouchesTheGround) {
  int refused = 0;
  for (const IntegratorInfo& method : integrators()) {
    if (!method.moves_particles() || !method.has_modulus) continue;
    const FailureRun run = try_one("drop", 0.1, method.name);
    refused += run.outcome == Outcome::refused ? 1 : 0;
    if (run.outcome == Outcome::refused)
      EXPECT_EQ(method.collisions, Collisions::never) << method.name;
    else
      EXPECT_EQ(run.touched, 1) << method.name;
  }
  EXPECT_GT(refused, 0);
}

// What is behind the ground, or has not been above it, is not stable, whatever its energy says.
TEST(Failures, NoDropThatCountsAsStableIsBehindTheGround) {
  int stable = 0, deformed = 0;
  for (const IntegratorInfo& method : integrators()) {
    if (!method.moves_particles() || !method.has_modulus) continue;
    for (const double height : {0.1, 10.0}) {
      const FailureRun run = try_one("drop", height, method.name);
      if (run.status() != "stable") continue;
      ++stable;
      EXPECT_LE(run.depth, 1e-6 / 3) << method.name;
      EXPECT_GT(run.height, 0.1) << method.name;
      deformed += run.extremes.min_jacobian < 0.99 ? 1 : 0;
    }
  }
  EXPECT_GT(stable, 20);
  EXPECT_GT(deformed, stable / 2);  // what falls through nothing stays as it is
}

// A plane that acts too late: the cube begins behind it and is only pushed out.
TEST(Failures, WhatIsBehindThePlaneIsNotStable) {
  StressCase low = unloaded_cube();
  low.body.origin = -0.4 * Vec3::UnitZ();
  low.velocity = 10 * Vec3::UnitX();  // beside its energy what pushes it out is little
  low.environment.planes = {{.point = Vec3::Zero(), .normal = Vec3::UnitZ()}};
  const FailureRun run = try_scene(low, find_integrator("verlet"));
  EXPECT_GT(run.depth, 0.1);
  EXPECT_EQ(run.outcome, Outcome::stable);
  EXPECT_EQ(run.status(), "behind_plane");
}

// The same outcome in every case that has been a reason to doubt the counts, to the last step.
TEST(Failures, MethodsThatAreNotCountedRepeatOthers) {
  int replicas = 0;
  for (const IntegratorInfo& method : integrators()) {
    const std::string& other = method.variant_of;
    if (other.empty()) continue;
    ++replicas;
    for (const auto& [scene, severity] : {std::pair{"stretch", 1.5}, {"spin", 1.0}, {"compression", 0.5}}) {
      const FailureRun a = try_one(scene, severity, method.name), b = try_one(scene, severity, other);
      EXPECT_EQ(a.status(), b.status()) << method.name << ", " << scene;
      EXPECT_NEAR(a.extremes.final_jacobian, b.extremes.final_jacobian, 0.02) << method.name << ", " << scene;
    }
  }
  EXPECT_EQ(replicas, 3);
  EXPECT_EQ(failure_statuses().size(), outcome_labels().size());
}

TEST(Failures, ADropGainsNone) {
  for (const Variant variant : variants)
    EXPECT_EQ(try_one("drop", 0.1, "backward_euler", variant).outcome, Outcome::stable);
}

TEST(Failures, AMethodWithoutAStepForABodyRefuses) {
  EXPECT_EQ(try_one("stretch", 1.2, "xpbd").outcome, Outcome::stable);
  EXPECT_EQ(try_one("stretch", 1.2, "xpbd", guarded).outcome, Outcome::refused);
  EXPECT_EQ(try_one("negative_volume", 0.1, "vbd:5").outcome, Outcome::refused);
}

// Across a spring of no length stiffness has no bound; implicit methods must not fail nevertheless.
TEST(Failures, SpringsOfNoLengthAreStable) {
  for (const IntegratorInfo& method : integrators()) {
    if (!method.moves_particles() || !method.has_modulus) continue;
    const Outcome outcome = try_one("merged", 1, method.name).outcome;
    if (method.name == "generalized_alpha")
      EXPECT_EQ(outcome, Outcome::gains_energy);  // its high frequencies overshoot at long steps
    else
      EXPECT_EQ(outcome, Outcome::stable) << method.name;
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

TEST(Failures, LeaveOutTheSlowestMethodAndOtherNamesOfOthersUnlessNamed) {
  const std::vector<std::string> all = failure_config({}).integrators;
  const auto runs = [&](const char* name) { return std::count(all.begin(), all.end(), name) == 1; };
  for (const char* left_out : {"arkode_dirk", "verlet", "cvode_bdf_klu", "cvode_bdf_gmres"})
    EXPECT_FALSE(runs(left_out)) << left_out;
  for (const char* kept : {"semi_implicit_euler", "cvode_bdf", "arkode_erk", "backward_euler"})
    EXPECT_TRUE(runs(kept)) << kept;
  const std::vector<std::string> named{"verlet", "arkode_dirk"};
  EXPECT_EQ(failure_config({.integrators = named}).integrators, named);
}

FailureConfig drops() {
  FailureConfig config = failure_config({.quick = true, .integrators = {"verlet", "backward_euler_linear"}});
  std::erase_if(config.scenes, [](const FailureScene& scene) { return scene.name != "drop"; });
  config.random_scenes = 5;
  return config;
}

TEST(Failures, NameTheLeastJacobianAndTheLast) {
  FailureConfig config = failure_config({.quick = true, .integrators = {"verlet"}});
  std::erase_if(config.scenes, [](const FailureScene& scene) { return scene.name != "inside_out"; });
  config.random_scenes = 0;
  Journal journal;
  Progress progress;
  const Table rows = measure_failures(config, 2, journal, progress).rows;
  int recovered = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows.text(r, "status") == "blows_up") continue;
    EXPECT_LE(rows.number(r, "min_jacobian"), rows.number(r, "final_jacobian"));
    recovered += rows.number(r, "min_jacobian") < 0 && rows.number(r, "final_jacobian") > 0 ? 1 : 0;
  }
  EXPECT_GT(recovered, 0);
}

TEST(Failures, AreTheSameHoweverTheyAreSplit) {
  const FailureConfig config = drops();
  const auto run = [&](int processes) {
    Journal journal;
    Progress progress;
    return measure_failures(config, processes, journal, progress);
  };
  const FailureTables one = run(1), four = run(4);
  EXPECT_EQ(one.rows.size(), 2U * 3 * 2);
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
    const std::vector<NamedTable> files = failure_files(std::move(tables));
    expect_same_drawings(find_experiment("failures"), files);
    for (const NamedChart& drawn : find_experiment("failures").draw(files).charts)
      for (const ChartSeries& series : drawn.chart.series)
        for (const ChartPoint& point : series.points) EXPECT_LE(point.x, 100);
  }
}

}  // namespace
}  // namespace mss::studies::failures

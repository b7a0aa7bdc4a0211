// `mss frames`: families approach what they should, rows say what failed, charts come from tables.
#include "experiments/studies/frames/frames.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/explicit_steps.hpp"
#include "experiments/simulation/model.hpp"
#include "experiments/studies/frames/total.hpp"
#include "tests/read_back.hpp"

namespace mss::studies::frames {
namespace {

FramesConfig small_config() {
  FramesConfig config = frames_config({.quick = true});
  config.scenes = {{.name = "tiny", .cells = 2, .young = 1e5}};
  config.frames = 6;
  return config;
}

TEST(Frames, MoreIterationsComeNearerToConvergedBackwardEuler) {
  FramesConfig config = small_config();
  config.families = {{.integrator = "backward_euler"},
                     {.integrator = "backward_euler", .nonlinear = "projective", .iterations = {1, 10, 100}},
                     {.integrator = "backward_euler", .nonlinear = "lbfgs", .iterations = {1, 5, 30}}};
  Progress progress;
  const Table rows = measure_frames(config, progress).rows;
  EXPECT_EQ(rows.where("method", "backward_euler").number(0, "distance"), 0);
  for (const char* method : {"backward_euler/projective", "backward_euler/lbfgs"}) {
    const Table family = rows.where("method", method);
    ASSERT_EQ(family.size(), 3U);
    EXPECT_GT(family.number(0, "distance"), 10 * family.number(1, "distance"));
    EXPECT_LT(family.number(2, "distance"), 1e-6);
    EXPECT_NEAR(family.number(2, "error"), rows.where("method", "backward_euler").number(0, "error"), 1e-6);
  }
}

TEST(Frames, ExplicitMethodsFollowTheTrueMotion) {
  FramesConfig config = small_config();
  config.families.clear();
  Progress progress;
  const Table rows = measure_frames(config, progress).rows;
  ASSERT_GT(rows.size(), 0U);
  double fastest = INFINITY;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    EXPECT_EQ(rows.text(r, "kind"), "explicit");
    EXPECT_LT(rows.number(r, "error"), 0.25);
    fastest = std::min(fastest, rows.number(r, "over_explicit"));
  }
  EXPECT_EQ(fastest, 1);
}

TEST(Frames, ShapeMatchingIsFittedToTheRestOfSprings) {
  FramesConfig config = small_config();
  config.scenes = {{.name = "hanging", .cells = 4, .young = 3e4, .damping_ratio = 0.5}};
  config.families = {{.integrator = "shape_matching", .steps = {1, 4}}};
  Progress progress;
  const FrameTables tables = measure_frames(config, progress);
  ASSERT_EQ(tables.fits.size(), 2U);
  for (std::size_t r = 0; r < 2; ++r) {
    EXPECT_EQ(tables.fits.text(r, "status"), "ok");
    EXPECT_GT(tables.fits.number(r, "deflection"), 0.01);
    EXPECT_NEAR(tables.fits.number(r, "deflection_with_alpha_1") / tables.fits.number(r, "alpha"),
                tables.fits.number(r, "deflection"), 1e-12);
  }
  EXPECT_NEAR(tables.fits.number(0, "alpha") / tables.fits.number(1, "alpha"), 16, 1e-9);
}

TEST(Frames, SummariesNameTheCheapestAndWhatIsNotReached) {
  Table rows({{"scene"},
              {"method"},
              {"kind"},
              {"iterations"},
              {"steps_per_frame"},
              {"seconds"},
              {"over_explicit"},
              {"over_explicit_q1"},
              {"over_explicit_q3"},
              {"error"},
              {"distance"},
              {"status"}});
  const auto add = [&](const char* method, int iterations, double seconds, double error, double distance) {
    rows.add({"one", method, iterations > 0 ? "family" : "explicit", iterations, 1, seconds, seconds, seconds,
              seconds, error, distance, "ok"});
  };
  add("verlet", 0, 1, 0.015, 0.3);
  add("backward_euler/lbfgs", 1, 0.2, 0.2, 0.5);
  add("backward_euler/lbfgs", 2, 0.3, 0.08, 0.05);
  add("backward_euler/lbfgs", 5, 0.4, 0.07, 0.02);
  const Table summary = frames_summary(rows);
  ASSERT_EQ(summary.size(), 4U);  // 10, 5, 2 and 1 percent
  EXPECT_EQ(summary.text(0, "method"), "backward_euler/lbfgs");
  EXPECT_EQ(summary.number(0, "iterations"), 2);
  EXPECT_EQ(summary.text(1, "method"), "verlet");
  EXPECT_EQ(summary.text(3, "status"), "no method tried reaches it");
  const Table iterations = frames_iterations(rows);
  ASSERT_EQ(iterations.size(), 1U);
  EXPECT_EQ(iterations.number(0, "iterations_to_10_percent"), 2);
  EXPECT_EQ(iterations.text(0, "status"), "not within 1 percent");
  EXPECT_EQ(iterations.number(0, "lowest_distance"), 0.02);
}

TEST(Frames, FindRestToTheirTolerance) {
  RestConfig config = rest_config({.quick = true});
  config.scenes = {{.name = "cube_2", .cells = 2}};
  Progress progress;
  const Table rows = measure_rest(config, progress);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    EXPECT_EQ(rows.text(r, "status"), "ok");
    if (rows.number(r, "tolerance") <= 1e-6) {
      EXPECT_LT(rows.number(r, "error"), 1e-3) << rows.text(r, "method");
    }
  }
  const std::vector<NamedTable> tables{{"frames", measure_frames(small_config(), progress).rows},
                                       {"frames_rest", rows}};
  expect_same_drawings(find_experiment("frames"), tables);
}

TotalConfig small_totals() {
  TotalConfig config = total_config({.quick = true});
  config.problems = {{"held_box", 1e6, 0.1, {2, 4}, 8}};
  config.families = {{.integrator = "backward_euler", .nonlinear = "lbfgs", .iterations = {5}},
                     {.integrator = "xpbd", .iterations = {1}, .steps = {1, 16}}};
  config.most_seconds = 3600;
  return config;
}

/// Errors of space and time are sides of a triangle of motions; a motion that is accurate in time has the
/// error of its cells, and that falls as these do.
TEST(FrameTotals, AreOfSpaceAndTimeTogether) {
  Progress progress;
  const TotalTables tables = measure_totals(small_totals(), progress);
  ASSERT_EQ(tables.cells.size(), 3U);
  EXPECT_EQ(tables.cells.number(0, "places"), 27);  // the particles of the coarsest
  EXPECT_EQ(tables.cells.number(2, "error_space"), 0);
  const double coarse = tables.cells.number(0, "error_space"), fine = tables.cells.number(1, "error_space");
  EXPECT_GT(coarse, 2 * fine);
  int accurate = 0;
  for (std::size_t r = 0; r < tables.rows.size(); ++r) {
    ASSERT_EQ(tables.rows.text(r, "status"), "ok");
    const double space = tables.rows.number(r, "cells") == 2 ? coarse : fine,
                 time = tables.rows.number(r, "error_time"), total = tables.rows.number(r, "error_total");
    EXPECT_LE(total, space + time + 1e-12);
    EXPECT_GE(total, std::abs(space - time) - 1e-12);
    if (time > 0.1 * space) continue;
    ++accurate;
    EXPECT_NEAR(total / space, 1, 0.1);
  }
  EXPECT_GT(accurate, 2);
}

/// A scene that does not do what it is meant to has rows that say so, and no runs.
TEST(FrameTotals, WithoutAReferenceSayWhy) {
  TotalConfig config = small_totals();
  config.problems = {{"ball", 1e6, 0.1, {4}, 8}};
  config.frames = 1;  // it has hardly come to the ground
  Progress progress;
  const TotalTables tables = measure_totals(config, progress);
  EXPECT_EQ(tables.rows.size(), 0U);
  ASSERT_EQ(tables.cells.size(), 2U);
  EXPECT_EQ(tables.cells.text(0, "status"), "the body has not touched the ground");
}

TEST(FrameTotals, ShowTheBestOfAllCells) {
  Table rows({{"seconds"}, {"error_total"}, {"status"}});
  rows.add({3.0, 0.1, std::string("ok")});
  rows.add({1.0, 0.5, std::string("ok")});
  rows.add({2.0, 0.6, std::string("ok")});    // slower and worse
  rows.add({4.0, 0.099, std::string("ok")});  // hardly better
  rows.add({0.5, no_value, std::string("non_finite")});
  EXPECT_EQ(best_totals(rows), (std::vector<std::size_t>{1, 0}));
}

TEST(FrameTotals, AreDrawnFromTheirFiles) {
  Progress progress;
  const TotalTables totals = measure_totals(small_totals(), progress);
  const std::vector<NamedChart> charts = total_charts(totals.rows, totals.cells);
  ASSERT_EQ(charts.size(), 1U);
  EXPECT_EQ(charts[0].name, "frames_total_held_box_1e06");
  EXPECT_EQ(charts[0].chart.lines.size(), 2U);  // what cells of either size leave
  EXPECT_EQ(charts[0].chart.series.size(), 2 * totals.rows.distinct("method").size());
  RestConfig rest = rest_config({.quick = true});
  rest.scenes = {{.name = "cube_2", .cells = 2}};
  std::vector<NamedTable> tables{{"frames", measure_frames(small_config(), progress).rows},
                                 {"frames_rest", measure_rest(rest, progress)}};
  for (NamedTable& table : total_files(totals)) tables.push_back(std::move(table));
  expect_same_drawings(find_experiment("frames"), tables);
}

TEST(ExplicitSteps, AreTheFewestSafeOnes) {
  const Body body(unit_cube({.young = 1e5, .poisson = 0.3}, 1000, 2, 0));
  const auto system = make_system<double>(spring_model, body, {}, 1);
  const double duration = 1.0 / 60;
  const IntegratorInfo& verlet = find_integrator("verlet");
  const ExplicitSteps all = explicit_steps(verlet, system->spectral_bound(), duration),
                      half = explicit_steps(verlet, system->spectral_bound(), duration, 0.5);
  const double safe = safe_share * stable_step(verlet, system->spectral_bound());
  EXPECT_LE(all.dt, safe);
  EXPECT_GT(duration / double(all.steps - 1), safe);
  EXPECT_GE(half.steps, 2 * all.steps - 1);
  for (const ExplicitSteps& choice : cheapest_explicit_steps(*system, system->undeformed_state(), duration)) {
    EXPECT_EQ(choice.info->stepping, Stepping::fixed);
    EXPECT_NEAR(double(choice.steps) * choice.dt, duration, 1e-15);
  }
}

}  // namespace
}  // namespace mss::studies::frames

// `mss validate contact`, bodies that touch each other or themselves: the study sees what holds and what does
// not.
#include "experiments/studies/contact/robustness.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/bodies/contact_surface.hpp"
#include "core/mesh/shapes.hpp"
#include "core/scene/scene.hpp"
#include "experiments/studies/contact/crossings.hpp"
#include "experiments/studies/contact/pile.hpp"
#include "experiments/studies/contact/touching_methods.hpp"

namespace mss::studies::contact {
namespace {

TEST(Crossings, ASegmentGoesThroughATriangleOrPassesIt) {
  const std::array<Vec3, 3> triangle{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  EXPECT_TRUE(goes_through(Vec3(0.2, 0.2, -1), Vec3(0.3, 0.2, 1), triangle));
  EXPECT_TRUE(goes_through(Vec3(0.3, 0.2, 1), Vec3(0.2, 0.2, -1), triangle));
  EXPECT_FALSE(goes_through(Vec3(0.2, 0.2, 0.1), Vec3(0.3, 0.2, 1), triangle));
  EXPECT_FALSE(goes_through(Vec3(0.8, 0.8, -1), Vec3(0.8, 0.8, 1), triangle));
}

/// Two boxes in one mesh, one above the other.
TEST(Crossings, AreCountedOnlyBeyondTheInsetAndTheNeighbours) {
  TriangleMesh mesh = box_mesh(Vec3::Zero(), Vec3::Ones());
  const TriangleMesh above = box_mesh(Vec3(0.2, 0.2, 1.5), Vec3(0.8, 0.7, 2.5));
  const int first = int(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), above.vertices.begin(), above.vertices.end());
  for (const auto& [a, b, c] : above.triangles) mesh.triangles.push_back({a + first, b + first, c + first});
  std::vector<Vec3> now = mesh.vertices;
  EXPECT_EQ(crossings(mesh, now, 0.1, 0), 0U);
  for (std::size_t v = std::size_t(first); v < now.size(); ++v) now[v][2] -= 0.6;
  EXPECT_GT(crossings(mesh, now, 0.1, 0), 0U);
  EXPECT_EQ(crossings(mesh, now, 0.1, 0.2), 0U);
  EXPECT_EQ(crossings(mesh, now, 10, 0), 0U);
}

TEST(Robustness, AStackOfThreeStaysAndSinksByLessThanAHundredth) {
  Table rows = empty_pile();
  add_pile_run({"three", "backward_euler", 1e6, 1, 3}, rows);
  EXPECT_EQ(rows.text(0, "status"), "ok") << rows.csv();
  EXPECT_NEAR(rows.number(0, "depth"), 0.0034, 0.0003);
  add_pile_run({"three", "backward_euler", 1e5, 1, 1}, rows);
  EXPECT_GT(rows.number(1, "depth"), 0.02);
  EXPECT_NE(rows.text(1, "status"), "ok");
}

TEST(Robustness, ABlockOnABlockSticksBelowTheFrictionAngleAndSlidesAbove) {
  Table rows = empty_incline();
  add_incline_run({"verlet", 0.45}, rows);
  add_incline_run({"verlet", 0.55}, rows);
  for (std::size_t r = 0; r < 2; ++r) EXPECT_EQ(rows.text(r, "status"), "ok") << rows.csv();
  EXPECT_LT(std::abs(rows.number(0, "slid")), 1e-3);
  EXPECT_GT(rows.number(1, "slid"), 0.04);
}

/// A frame's step takes particles along the cylinder: planes turn with them.
TEST(Robustness, ARopeOnACylinderHasEulersTensions) {
  Table rows = empty_capstan();
  for (const char* method : {"verlet", "backward_euler"})
    for (const double friction : {0.0, 0.3}) add_capstan_run({method, 32, friction}, rows);
  ASSERT_EQ(rows.size(), 8U);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    EXPECT_EQ(rows.text(r, "status"), "ok") << rows.csv();
    EXPECT_LT(std::abs(rows.number(r, "error")), 0.02) << rows.csv();
  }
}

TEST(Robustness, AnArchGoesThroughItselfWithoutContactOnly) {
  Table rows = empty_self_contact();
  for (const bool touches : {true, false}) add_self_contact_run({"arch", "verlet", touches}, rows);
  EXPECT_EQ(rows.text(0, "status"), "ok") << rows.csv();
  EXPECT_GT(rows.number(0, "touches"), 4);
  EXPECT_EQ(rows.text(1, "status"), "crosses") << rows.csv();
  EXPECT_GT(rows.number(1, "crossings"), 10);
}

TEST(Robustness, ADropHasTheSameBitsForAnyNumberOfThreads) {
  Table rows = empty_drop();
  for (const int threads : {1, 2}) add_drop_run({5, "verlet", threads, 0.1}, rows);
  EXPECT_EQ(rows.text(0, "bits"), rows.text(1, "bits"));
  EXPECT_EQ(rows.text(0, "status"), "ok") << rows.csv();
}

TEST(Robustness, RandomScenesAreScenesAndJudged) {
  Table rows = empty_random();
  for (const std::uint64_t seed : {2U, 16U}) add_random_scene(seed, rows);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    EXPECT_EQ(rows.text(r, "status"), "ok") << rows.csv();
    EXPECT_LT(rows.number(r, "momentum"), 1e-9);
  }
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    const Scene scene = parse_scene(random_scene(seed));
    EXPECT_GE(scene.others.size(), 1U);
    EXPECT_LE(scene.others.size(), 4U);
  }
}

TEST(Robustness, RefusedIsARow) {
  Table rows = empty_pile();
  add_pile_run({"three", "vbd", 1e6, 1}, rows);
  EXPECT_EQ(rows.text(0, "status"), "refused");
  EXPECT_NE(rows.text(0, "reason").find("vbd"), std::string::npos);
  for (const std::string& method : touching_methods({})) EXPECT_NE(method, "vbd");
}

TEST(Robustness, ExplicitMethodsOfHighOrderRunWhereTheyAreNamed) {
  const std::vector<std::string> usual = touching_methods({}), named = touching_methods({"srkn8", "pefrl"});
  EXPECT_EQ(std::count(usual.begin(), usual.end(), "rk4"), 1);
  for (const char* method : {"pefrl", "srkn6", "srkn8"})
    EXPECT_EQ(std::count(usual.begin(), usual.end(), method), 0) << method;
  EXPECT_EQ(named, (std::vector<std::string>{"srkn8", "pefrl"}));
}

TEST(Robustness, PilesAreOfOneExplicitMethodUnlessOthersAreNamed) {
  std::set<std::string> usual;
  std::set<double> moduli;
  for (const PileRun& run : pile_config({}).piles) {
    if (!find_integrator(run.integrator).limit) continue;
    usual.insert(run.integrator);
    moduli.insert(run.young);
  }
  EXPECT_EQ(usual, std::set<std::string>{"verlet"});
  EXPECT_EQ(moduli, (std::set<double>{1e5, 1e6}));
  const std::vector<PileRun> named = pile_config({.integrators = {"rk4"}}).piles;
  EXPECT_FALSE(named.empty());
  for (const PileRun& run : named) EXPECT_EQ(run.integrator, "rk4");
}

}  // namespace
}  // namespace mss::studies::contact

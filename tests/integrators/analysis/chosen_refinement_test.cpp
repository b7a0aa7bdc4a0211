// Which cells are chosen to be smaller by the equilibrium at rest, and what that gains.
#include "integrators/analysis/chosen_refinement.hpp"

#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "core/refinement/refined_system.hpp"
#include "integrators/statics/linear_response.hpp"

namespace mss {
namespace {

BodyConfig block(int n) {
  BodyConfig config{.voxels = VoxelGrid::box(n, n, n), .cell_size = 1.0 / n};
  config.fill({.young = 1e5, .poisson = 0.3}, 0.5);
  return config;
}

const Box base{{0, 0, 0}, {1, 1, 0}}, corner{{1, 1, 1}, {1, 1, 1}}, other_corner{{0, 0, 1}, {0, 0, 1}};

Environment pulled_at_a_corner() {
  return {.holds = {{.box = base}}, .loads = {{.box = corner, .force = {1, 0, 0}}}};
}

/// Of the particle at the corner.
double displacement_of(const RefinedBody& body) {
  RefinedSystem<double> system(body, pulled_at_a_corner());
  Work work;
  const LinearResponse r = linear_response(system, {}, work);
  EXPECT_EQ(r.status, Status::ok);
  return r.displacement.at(select(body.levels(), corner).back())[0];
}

TEST(ChosenRefinement, IsWhereALoadConcentratesStress) {
  const RefinementMap map = choose_refinement(block(4), pulled_at_a_corner(), {.levels = 2});
  EXPECT_EQ(map.depth(), 2);
  EXPECT_TRUE(map.is_split(0, {3, 3, 3}));
  EXPECT_TRUE(map.is_split(1, {7, 7, 7}));
  EXPECT_FALSE(map.is_split(0, {0, 0, 3}));
  EXPECT_LT(map.split_cells(0).size(), 16U);
}

// In cells of one size it takes eight times the particles.
TEST(ChosenRefinement, ApproachesSmallCellsWithFewParticles) {
  const RefinedBody coarse(block(4), {}), fine(block(8), {}),
      chosen(block(4), choose_refinement(block(4), pulled_at_a_corner(), {.levels = 1}));
  EXPECT_LT(chosen.sites().size(), fine.sites().size() / 3);
  const double there = displacement_of(chosen), before = displacement_of(coarse),
               after = displacement_of(fine);
  EXPECT_GT((there - before) / (after - before), 0.8);
}

TEST(ChosenRefinement, IsForAGoalWhereThatHasAnotherDualSolution) {
  const RefinementMap map =
      choose_refinement(block(4), pulled_at_a_corner(), {.levels = 1, .box = other_corner});
  EXPECT_TRUE(map.is_split(0, {0, 0, 3}));
}

TEST(ChosenRefinement, IsOfMovingHoldsToo) {
  Environment moved{.holds = {{.box = base}, {.box = corner, .velocity = {1, 0, 0}}}};
  EXPECT_TRUE(choose_refinement(block(4), moved, {.time = 0.1}).is_split(0, {3, 3, 3}));
  EXPECT_THROW(choose_refinement(block(4), moved, {.time = 0}), InputError);  // nothing has moved
}

TEST(ChosenRefinement, NeedsHoldsThatKeepTheBodyInPlace) {
  Environment loose = pulled_at_a_corner();
  loose.holds[0].box = {{0, 0, 0}, {1, 0, 0}};  // a hinge
  EXPECT_THROW(choose_refinement(block(2), loose, {}), InputError);
  loose.holds.clear();
  EXPECT_THROW(choose_refinement(block(2), loose, {}), InputError);
}

}  // namespace
}  // namespace mss

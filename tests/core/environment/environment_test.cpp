// Boundary conditions and loads that depend on time.
#include "core/environment/environment.hpp"

#include <gtest/gtest.h>

#include "core/base/piecewise_linear.hpp"

namespace mss::testing {
namespace {

TEST(PiecewiseLinear, IsLinearBetweenPointsAndConstantOutside) {
  const PiecewiseLinear<double> f{{{1, 2}, {3, 6}, {4, 0}}};
  EXPECT_EQ(f.at(0), 2);
  EXPECT_EQ(f.at(1), 2);
  EXPECT_EQ(f.at(2), 4);
  EXPECT_EQ(f.at(3), 6);
  EXPECT_EQ(f.at(3.5), 3);
  EXPECT_EQ(f.at(9), 0);
  EXPECT_EQ(f.slope(0.5), 0);
  EXPECT_EQ(f.slope(1), 2);
  EXPECT_EQ(f.slope(3), -6);  // of the later piece
  EXPECT_EQ(f.slope(4), 0);
  EXPECT_TRUE(f.changes(3.9));
  EXPECT_FALSE(f.changes(4));
  EXPECT_FALSE((PiecewiseLinear<double>{{{0, 1}}}.changes(-1)));
}

TEST(Hold, FollowsItsPathBesideWhatElseMovesIt) {
  Hold hold;
  hold.velocity = Vec3(1, 0, 0);
  hold.displacement = Vec3(0, 0, 3);
  hold.path.points = {{0, Vec3::Zero()}, {2, Vec3(0, 4, 0)}};
  const Prescribed p = prescribed_motion(hold, Vec3(1, 1, 1), 1);
  EXPECT_EQ(p.position, Vec3(2, 3, 4));
  EXPECT_EQ(p.velocity, Vec3(1, 2, 0));
  EXPECT_EQ(prescribed_motion(hold, Vec3(1, 1, 1), 2).velocity, Vec3(1, 0, 0));
  hold.velocity.setZero();
  EXPECT_TRUE(hold.moves(1.9));
  EXPECT_FALSE(hold.moves(2));
  hold.turn = Turn{.rate = 2};
  const Vec3 arm = prescribed_motion(hold, Vec3(1, 0, 0), 0.5).position - Vec3(0, 1, 3);
  EXPECT_LT((prescribed_acceleration(hold, Vec3(1, 0, 0), 0.5) + 4 * arm).norm(), 1e-12);
}

}  // namespace
}  // namespace mss::testing

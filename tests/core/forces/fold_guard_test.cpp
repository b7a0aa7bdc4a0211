#include "core/forces/fold_guard.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

namespace mss {
namespace {

constexpr double stiffness = 3, size = 0.2, shortest = guarded_length(size);

/// Edges at corners of every kind: hardly strained, tangled, flat and inverted ones.
Eigen::Matrix3d random_edges(std::mt19937_64& random, double amplitude) {
  std::uniform_real_distribution<> share(-amplitude, amplitude);
  Eigen::Matrix3d edges = Eigen::Matrix3d::Identity();
  for (double& e : edges.reshaped()) e += share(random);
  return size * edges;
}

double energy(const Eigen::Matrix3d& edges) { return GuardedCorner(stiffness, shortest, edges).energy(); }

TEST(FoldGuard, IsZeroUntilAStretchIsShort) {
  for (const double least : {0.69, 0.7, 0.71, 5.0}) {
    const Eigen::Matrix3d edges = size * Eigen::Vector3d(1, 1.5, least).asDiagonal();
    if (least < 0.7) {
      EXPECT_NEAR(energy(edges), 0.5 * stiffness * std::pow(0.01 * size, 2), 1e-15);
    } else {
      EXPECT_LE(energy(edges), least > 0.7 ? 0 : 1e-30);  // at 0.7 it depends on rounding
    }
  }
}

TEST(FoldGuard, ActsOnInvertedCorners) {
  const Eigen::Matrix3d turned = Eigen::AngleAxisd(1.2, Eigen::Vector3d(1, 2, 3).normalized()).matrix();
  const Eigen::Matrix3d mirrored = size * turned * Eigen::Vector3d(1, -1, 1).asDiagonal();
  EXPECT_LT(energy(size * turned), 1e-30);
  EXPECT_NEAR(energy(mirrored), 0.5 * stiffness * std::pow(1.7 * size, 2), 1e-12);
}

// Its bound needs a determinant only; no corner that has energy may be beyond it.
TEST(FoldGuard, ActsWithinItsBound) {
  std::mt19937_64 random(1);
  int acting = 0, spared = 0;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Matrix3d edges = random_edges(random, 0.1 + 1.5 * i / 20000);
    const bool may = GuardedCorner::may_act(shortest, edges);
    ASSERT_TRUE(may || energy(edges) == 0) << edges;
    ++(energy(edges) > 0 ? acting : spared);
  }
  EXPECT_GT(acting, 5000);
  EXPECT_GT(spared, 5000);
  EXPECT_FALSE(GuardedCorner::may_act(shortest, Eigen::Matrix3d::Constant(std::nan(""))));
  EXPECT_FALSE(GuardedCorner::may_act(shortest, Eigen::Matrix3d::Constant(HUGE_VAL)));
  EXPECT_TRUE(GuardedCorner::may_act(shortest, Eigen::Matrix3d::Zero()));
}

TEST(FoldGuard, PullsAsItsEnergyFalls) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Matrix3d edges = random_edges(random, 1.2), change = random_edges(random, 1);
    const double step = 1e-6,
                 slope = (energy(edges + step * change) - energy(edges - step * change)) / (2 * step);
    const Eigen::Matrix3d pull = GuardedCorner(stiffness, shortest, edges).pull();
    EXPECT_NEAR(slope, -pull.cwiseProduct(change).sum(), 1e-7 * stiffness * size * size) << edges;
  }
}

// The force grows no faster than its stiffness, however far a corner is inverted.
TEST(FoldGuard, IsNoStifferThanItsStiffness) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Matrix3d edges = random_edges(random, 3), change = random_edges(random, 1);
    const GuardedCorner corner(stiffness, shortest, edges);
    const auto work = [&](Tangent kind) {
      return -corner.pull_change(change, kind).cwiseProduct(change).sum() / change.squaredNorm();
    };
    EXPECT_GE(work(Tangent::projected), -1e-12);
    EXPECT_LE(work(Tangent::projected), stiffness * (1 + 1e-12));
    EXPECT_LE(work(Tangent::elastic), work(Tangent::projected) + 1e-12);
  }
}

}  // namespace
}  // namespace mss

// The eye of a window and the colours it shows.
#include "experiments/view/camera.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "experiments/view/colour_map.hpp"

namespace mss::view {
namespace {

const Viewport screen{300, 0, 900, 600};

Camera fitted() {
  Camera camera;
  camera.fit(Vec3(1, 2, 3), Vec3(3, 3, 4), screen);
  return camera;
}

TEST(Camera, SeesAllOfABoxAndItsMiddleInTheMiddle) {
  for (const Viewport& view : {screen, Viewport{0, 0, 300, 900}}) {
    Camera camera;
    camera.fit(Vec3(1, 2, 3), Vec3(3, 3, 4), view);
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 point((corner & 1) != 0 ? 3 : 1, (corner & 2) != 0 ? 3 : 2, (corner & 4) != 0 ? 4 : 3);
      const Eigen::Vector2d seen = camera.project(point, view);
      EXPECT_TRUE(view.contains(seen[0], seen[1])) << seen.transpose();
    }
    const Eigen::Vector2d middle = camera.project(Vec3(2, 2.5, 3.5), view);
    EXPECT_NEAR(middle[0], view.x + view.width / 2, 1e-9);
    EXPECT_NEAR(middle[1], view.y + view.height / 2, 1e-9);
  }
}

TEST(Camera, GoesAsNearAsLeavesAMargin) {
  const std::vector<Vec3> bar{{1, 2, 3}, {3, 2, 3}, {1, 2.2, 3.2}, {3, 2.2, 3.2}},
      far_corner{{1, 2, 3}, {1.1, 2.1, 3.1}, {3, 3, 4}};
  for (const Viewport& view : {screen, Viewport{0, 0, 300, 900}})
    for (const std::vector<Vec3>& points : {bar, far_corner}) {
      Camera camera;
      camera.fit(Vec3(1, 2, 3), Vec3(3, 3, 4), view);
      camera.fill(points, view);
      Eigen::Vector2d lower(1e9, 1e9), upper = -lower;
      for (const Vec3& point : points) {
        lower = lower.cwiseMin(camera.project(point, view));
        upper = upper.cwiseMax(camera.project(point, view));
      }
      EXPECT_NEAR((lower[0] + upper[0]) / 2, view.x + view.width / 2, 0.01 * view.width);
      EXPECT_NEAR((lower[1] + upper[1]) / 2, view.y + view.height / 2, 0.01 * view.height);
      EXPECT_NEAR(std::max((upper[0] - lower[0]) / view.width, (upper[1] - lower[1]) / view.height), 0.85,
                  0.01);
    }
}

TEST(Camera, StaysOutsideOfABodySeenEndOn) {
  Camera camera;
  const Vec3 end = Vec3(std::cos(0.4) * std::cos(-1.0), std::cos(0.4) * std::sin(-1.0), std::sin(0.4));
  camera.fit(-end.cwiseAbs(), end.cwiseAbs(), screen);
  camera.fill(std::vector<Vec3>{-end, end}, screen);
  EXPECT_GT((camera.eye() - end).dot(-camera.forward()), 0);
}

TEST(Camera, RaysGoThroughWhatIsSeenThere) {
  Camera camera = fitted();
  camera.orbit(120, -40);
  camera.pan(30, 50, screen);
  camera.zoom(2);
  for (const Vec3& point : {Vec3(1, 2, 3), Vec3(2.5, 2, 4), Vec3(3, 3, 3.3)}) {
    const Eigen::Vector2d seen = camera.project(point, screen);
    const Ray ray = camera.ray(seen[0], seen[1], screen);
    const Vec3 to_point = point - ray.origin;
    EXPECT_NEAR((to_point - to_point.dot(ray.direction) * ray.direction).norm(), 0, 1e-9);
    EXPECT_GT(to_point.dot(ray.direction), 0);
    EXPECT_NEAR(ray.direction.norm(), 1, 1e-12);
  }
}

TEST(Camera, FollowsTheMouse) {
  Camera camera = fitted();
  const Vec3 target = camera.target();
  const Eigen::Vector2d before = camera.project(target, screen);
  camera.pan(25, -10, screen);
  const Eigen::Vector2d after = camera.project(target, screen);
  EXPECT_NEAR(after[0] - before[0], 25, 1e-6);
  EXPECT_NEAR(after[1] - before[1], -10, 1e-6);

  Camera turned = fitted();
  const Vec3 nearest = turned.target() + 0.1 * (turned.eye() - turned.target());
  const double x = turned.project(nearest + Vec3(0, 0, 0), screen)[0];
  turned.orbit(30, 0);
  EXPECT_GT(turned.project(nearest, screen)[0], x);  // what is in front goes with the mouse
  const double distance = turned.distance();
  turned.zoom(1);
  EXPECT_NEAR(turned.distance(), 0.9 * distance, 1e-12);
  const Vec3 level = turned.forward();
  turned.orbit(0, 1e4);
  EXPECT_GT(level.head<2>().dot(turned.forward().head<2>()), 0);  // never over the top
}

double grey(const Colour& c) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; }

TEST(ColourMap, RisesInGreyByEvenSteps) {
  double before = grey(map_colour(0));
  for (int i = 1; i <= 100; ++i) {
    const double now = grey(map_colour(i / 100.0));
    EXPECT_GT(now, before) << i;
    EXPECT_LT(now - before, 0.02) << i;
    before = now;
  }
  EXPECT_LT(grey(map_colour(0)), 0.1);
  EXPECT_GT(before, 0.8);
}

TEST(ColourMap, KeepsToItsEnds) {
  EXPECT_EQ(map_colour(-3), map_colour(0));
  EXPECT_EQ(map_colour(7), map_colour(1));
  EXPECT_EQ(map_colour(0), (Colour{0.267004F, 0.004874F, 0.329415F}));
  EXPECT_EQ(map_colour(1), (Colour{0.993248F, 0.906157F, 0.143936F}));
  EXPECT_NEAR(map_colour(128.0 / 255)[1], 0.566949, 1.0 / 255);  // viridis between the colours kept
  const Colour nothing = map_colour(std::nan(""));
  EXPECT_EQ(nothing[0], nothing[1]);
}

TEST(ValueRange, IsRoundAndHoldsWhatItMust) {
  const ValueRange range = round_range(0, 0.379, 0.01);
  EXPECT_EQ(range.low, 0);
  EXPECT_NEAR(range.high, 0.4, 1e-12);
  EXPECT_NEAR(range.step, 0.1, 1e-12);
  EXPECT_EQ(range.ticks().size(), 5U);
  int ranges = 0;
  for (double high = 1e-7; high < 1e7; high *= 1.7)
    for (const double low : {-0.3 * high, 0.0, 0.9 * high}) {
      const ValueRange r = round_range(low, high, 1e-9);
      EXPECT_LE(r.low, low + 1e-6 * r.step);
      EXPECT_GE(r.high, high - 1e-6 * r.step);
      EXPECT_GE(r.ticks().size(), 4U);
      EXPECT_LE(r.ticks().size(), 9U);
      ++ranges;
    }
  EXPECT_GT(ranges, 150);
}

TEST(ValueRange, OfOneValueIsAsWideAsItMustBe) {
  const ValueRange range = round_range(1, 1, 0.01);
  EXPECT_LT(range.low, 1);
  EXPECT_GT(range.high, 1);
  EXPECT_NEAR(range.share(1), 0.5, 1e-6);
  EXPECT_GE(range.high - range.low, 0.01 - 1e-12);
}

}  // namespace
}  // namespace mss::view

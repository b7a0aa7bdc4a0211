#include "core/mesh/triangle_tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/mesh/shapes.hpp"

namespace mss {
namespace {

Vec3 random_point(std::mt19937& random) {
  std::uniform_real_distribution<double> any(-1.5, 1.5);
  return {any(random), any(random), any(random)};
}

TEST(NearestPoint, IsTheNearestOfAFineGridOfTheTriangle) {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const std::array<Vec3, 3> corners{random_point(random), random_point(random), random_point(random)};
    const Vec3 point = random_point(random);
    const NearestPoint nearest = nearest_point(point, corners);
    const auto& [a, b, c] = nearest.weights;
    EXPECT_LT((a * corners[0] + b * corners[1] + c * corners[2] - nearest.at).norm(), 1e-14);
    EXPECT_NEAR(a + b + c, 1, 1e-14);
    EXPECT_GE(std::min({a, b, c}), -1e-15);
    constexpr int parts = 40;
    for (int u = 0; u <= parts; ++u)
      for (int v = 0; u + v <= parts; ++v) {
        const Vec3 other = corners[0] + double(u) / parts * (corners[1] - corners[0]) +
                           double(v) / parts * (corners[2] - corners[0]);
        EXPECT_GE((other - point).norm(), (nearest.at - point).norm() - 1e-12);
      }
  }
}

TEST(TriangleTree, FindsWhatASearchThroughAllTrianglesFinds) {
  TriangleMesh mesh = icosphere(1, 6);
  TriangleTree tree(mesh);
  std::mt19937 random(2);
  for (int moved = 0; moved < 2; ++moved) {
    for (int i = 0; i < 200; ++i) {
      const Vec3 point = random_point(random);
      std::vector<std::size_t> near;
      tree.for_each_near(point, 0.2, [&](std::size_t t) { near.push_back(t); });
      double least = 1e9;
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const double distance = (nearest_point(point, mesh.corners(t)).at - point).norm();
        least = std::min(least, distance);
        if (distance < 0.2) {
          EXPECT_TRUE(std::find(near.begin(), near.end(), t) != near.end());
        }
      }
      const std::size_t nearest = tree.nearest(point, mesh.vertices);
      EXPECT_EQ((nearest_point(point, mesh.corners(nearest)).at - point).norm(), least);
    }
    for (Vec3& x : mesh.vertices) x = Vec3(x[0] + 0.3 * x[1], 0.5 * x[1], x[2] - x[0] * x[0]);
    tree.fit(mesh.vertices);
  }
}

}  // namespace
}  // namespace mss

// Facts about triangle meshes, and the shapes that tests and scenes are made of.
#include "core/mesh/triangle_mesh.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "core/mesh/shapes.hpp"
#include "core/mesh/winding.hpp"

namespace mss {
namespace {

TEST(TriangleMesh, ShapesAreClosedAndHaveTheirVolume) {
  const double pi = std::numbers::pi;
  const TriangleMesh sphere = icosphere(2, 40);
  EXPECT_EQ(sphere.triangles.size(), 20U * 40 * 40);
  EXPECT_EQ(sphere.vertices.size(), sphere.triangles.size() / 2 + 2);  // Euler
  // flat triangles miss what goes with the square of their edges
  const auto missing = [&](const TriangleMesh& mesh) { return 1 - enclosed_volume(mesh) / (4 * pi / 3 * 8); };
  const auto uncovered = [&](const TriangleMesh& mesh) { return 1 - surface_area(mesh) / (4 * pi * 4); };
  EXPECT_NEAR(missing(icosphere(2, 20)) / missing(sphere), 4, 0.01);
  EXPECT_NEAR(uncovered(icosphere(2, 20)) / uncovered(sphere), 4, 0.01);
  EXPECT_NEAR(missing(sphere), 3.5e-4, 1e-5);
  const TriangleMesh ring = torus(3, 1, 200, 100);
  EXPECT_EQ(ring.vertices.size(), ring.triangles.size() / 2);
  EXPECT_NEAR(enclosed_volume(ring) / (2 * pi * pi * 3), 1 - 0.00082, 2e-5);
  const TriangleMesh box = box_mesh({1, 2, 3}, {2, 4, 6});
  EXPECT_NEAR(enclosed_volume(box), 6, 1e-14);
  EXPECT_NEAR(surface_area(box), 22, 1e-14);
  for (const TriangleMesh& mesh : {sphere, ring, box}) {
    EXPECT_TRUE(open_edges(mesh).empty());
    EXPECT_EQ(shells(mesh), 1U);
    EXPECT_EQ(zero_faces(mesh), 0U);
    EXPECT_NEAR(enclosed_volume(turned_inside_out(mesh)), -enclosed_volume(mesh), 1e-9);
  }
}

TEST(TriangleMesh, OpeningsAreFoundAndClosed) {
  TriangleMesh mesh = box_mesh({0, 0, 0}, {1, 1, 1});
  mesh.triangles.resize(10);  // without the two at z = 1
  const std::vector<OpenEdge> edges = open_edges(mesh);
  ASSERT_EQ(edges.size(), 4U);
  std::set<int> from;
  for (const OpenEdge& edge : edges) {
    from.insert(edge.from);
    EXPECT_GE(edge.from, 4);
    EXPECT_GE(edge.to, 4);
  }
  EXPECT_EQ(from.size(), 4U);
  const TriangleMesh whole = closed(mesh, edges);
  EXPECT_EQ(whole.triangles.size(), 14U);
  EXPECT_TRUE(open_edges(whole).empty());
  EXPECT_NEAR(enclosed_volume(whole), 1, 1e-14);
}

TEST(TriangleMesh, ATurnedFaceCountsTwice) {
  TriangleMesh mesh = icosphere(1, 4);
  std::swap(mesh.triangles[7][0], mesh.triangles[7][1]);
  const std::vector<OpenEdge> edges = open_edges(mesh);
  EXPECT_EQ(edges.size(), 6U);
  const TriangleMesh whole = closed(mesh, edges);
  EXPECT_TRUE(open_edges(whole).empty());
  EXPECT_NEAR(enclosed_volume(whole), enclosed_volume(icosphere(1, 4)), 1e-12);
}

TEST(TriangleMesh, CountsShellsAndFacesWithoutArea) {
  TriangleMesh mesh = joined(icosphere(1, 3), torus(5, 1, 12, 8));
  EXPECT_EQ(shells(mesh), 2U);
  mesh.vertices.push_back((mesh.vertices[0] + mesh.vertices[1]) / 2);
  mesh.triangles.push_back({0, 1, int(mesh.vertices.size()) - 1});  // on a line
  mesh.triangles.push_back({2, 2, 3});
  EXPECT_EQ(zero_faces(mesh), 2U);
  EXPECT_EQ(shells(mesh), 2U);
  EXPECT_EQ(open_edges(mesh).size(), 3U);
}

TEST(TriangleMesh, MergesWhatIsIdenticalOnly) {
  const TriangleMesh mesh{
      {{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {-0.0, 1, 0}, {1, 1e-300, 0}},
      {{1, 2, 3}, {4, 6, 5}}};
  const TriangleMesh merged = merge_identical(mesh);
  EXPECT_EQ(merged.vertices.size(), 4U);
  EXPECT_EQ(merged.triangles, (std::vector<std::array<int, 3>>{{0, 1, 2}, {1, 3, 2}}));
  EXPECT_EQ(merged.vertices[3].y(), 1e-300);
}

TEST(TriangleMesh, IsPlaced) {
  TriangleMesh mesh{{{1, 0, 0}, {0, 0, 3}}, {}};
  place(mesh, {.scale = 2, .axis = {0, 0, 5}, .degrees = 90, .translation = {0, 0, 1}});
  EXPECT_LT((mesh.vertices[0] - Vec3(0, 2, 1)).norm(), 1e-15);
  EXPECT_LT((mesh.vertices[1] - Vec3(0, 0, 7)).norm(), 1e-15);
}

TEST(Winding, SolidAngleOfAnOctant) {
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  EXPECT_NEAR(solid_angle(x, 2 * y, 3 * z), std::numbers::pi / 2, 1e-15);
  EXPECT_NEAR(solid_angle(y, x, z), -std::numbers::pi / 2, 1e-15);
  // more than half of all directions: three points just behind the origin's plane
  EXPECT_NEAR(solid_angle(x - 1e-6 * z, -x + y - 1e-6 * z, -x - y - 1e-6 * z), -2 * std::numbers::pi, 1e-4);
}

TEST(Winding, TheTreeAgreesWithTheSum) {
  TriangleMesh mesh = torus(3, 1, 40, 20);
  mesh.triangles.resize(mesh.triangles.size() * 2 / 3);
  const WindingTree tree(mesh);
  const WindingTree of_pieces(mesh, 0, 0.1);
  double largest = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 point(5 * std::sin(0.1 * i), 5 * std::cos(0.37 * i), 2 * std::sin(1.3 * i));
    double sum = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto [a, b, c] = mesh.corners(t);
      sum += solid_angle(a - point, b - point, c - point) / (4 * std::numbers::pi);
    }
    largest = std::max(largest, std::abs(tree.at(point).winding - sum));
    EXPECT_NEAR(of_pieces.at(point).winding, sum, 0.02);
    const auto [winding, change] = tree.at(point, 0.05);
    const double beside = tree.at(point + Vec3(0.03, -0.04, 0)).winding;
    EXPECT_LE(std::abs(beside - winding), change + 0.005) << i;
  }
  EXPECT_LT(largest, 0.02);
  EXPECT_GT(largest, 1e-6);  // there are clusters
}

TEST(TriangleMesh, DistanceIsThatOfThePlaneAnEdgeOrACorner) {
  const std::array<Vec3, 3> corners{Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 2, 0)};
  EXPECT_DOUBLE_EQ(distance({0.5, 0.5, -3}, corners), 3);
  EXPECT_DOUBLE_EQ(distance({1, -4, 3}, corners), 5);
  EXPECT_DOUBLE_EQ(distance({2, 2, 0}, corners), std::sqrt(2));
  EXPECT_DOUBLE_EQ(distance({-3, -4, 12}, corners), 13);
  EXPECT_DOUBLE_EQ(distance({5, 0, 4}, {Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(1, 0, 0)}), 5);  // without area
}

}  // namespace
}  // namespace mss

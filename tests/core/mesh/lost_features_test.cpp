// What is too thin for cells is named: where it is, how thick, and how much of the volume.
#include "core/mesh/lost_features.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/mesh/mesh_fill.hpp"
#include "core/mesh/shapes.hpp"

namespace mss {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A plate of 1 x 1 x .2 m with a fin on it, from `low` to `high` along x and up to z = .7.
TriangleMesh finned_plate(double low, double high) {
  const double profile[8][2]{{0, 0},      {1, 0},     {1, 0.2},   {high, 0.2},
                             {high, 0.7}, {low, 0.7}, {low, 0.2}, {0, 0.2}};
  TriangleMesh mesh;
  for (const double y : {0.0, 1.0})
    for (const auto& [x, z] : profile) mesh.vertices.emplace_back(x, y, z);
  for (const auto& [a, b, c] : {std::array{0, 1, 2}, {0, 2, 3}, {0, 3, 6}, {0, 6, 7}, {3, 4, 5}, {3, 5, 6}}) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a + 8, c + 8, b + 8});
  }
  for (int i = 0; i < 8; ++i) {
    const int next = (i + 1) % 8;
    mesh.triangles.push_back({i, i + 8, next + 8});
    mesh.triangles.push_back({i, next + 8, next});
  }
  return mesh;
}

/// A cylinder around the z axis.
TriangleMesh rod(double radius, double low, double high) {
  constexpr int n = 24;
  TriangleMesh mesh;
  for (const double z : {low, high}) {
    for (int i = 0; i < n; ++i)
      mesh.vertices.emplace_back(radius * std::cos(2 * M_PI * i / n), radius * std::sin(2 * M_PI * i / n), z);
    mesh.vertices.emplace_back(0, 0, z);
  }
  for (int i = 0; i < n; ++i) {
    const int next = (i + 1) % n, up = n + 1;
    mesh.triangles.push_back({i, next, next + up});
    mesh.triangles.push_back({i, next + up, i + up});
    mesh.triangles.push_back({n, next, i});
    mesh.triangles.push_back({n + up, i + up, next + up});
  }
  return mesh;
}

std::string all_notes(const MeshReport& report) {
  std::string all;
  for (const std::string& note : report.notes()) all += note + "; ";
  return all;
}

TEST(LostFeatures, AFinThinnerThanTheSamples) {
  const TriangleMesh mesh = finned_plate(0.49, 0.51);
  ASSERT_TRUE(open_edges(mesh).empty());
  const MeshReport report = fill_mesh(mesh, {.cell_size = 0.1}).reports.at(0);
  ASSERT_EQ(report.lost.size(), 1U);
  const LostFeature& fin = report.lost[0];
  EXPECT_LT((fin.box.lower - Vec3(0.49, 0, 0.2)).norm(), 1e-9) << fin.box.lower.transpose();
  EXPECT_LT((fin.box.upper - Vec3(0.51, 1, 0.7)).norm(), 1e-9) << fin.box.upper.transpose();
  EXPECT_NEAR(fin.volume, 0.01, 1e-9);
  EXPECT_NEAR(fin.thickness(), 0.02, 0.002);
  EXPECT_NEAR(report.true_centre.z(), 0.0245 / 0.21, 1e-12);
  EXPECT_LT(report.filled_centre.z(), 0.107);
  const std::string notes = all_notes(report);
  EXPECT_THAT(notes,
              HasSubstr("cells of 0.1 m miss its part from (0.49, 0, 0.2) to (0.51, 1, 0.7) m, about 0.019 m "
                        "thick: 0.01 m^3, 4.8 percent"));
  EXPECT_THAT(notes, HasSubstr("that of the mesh (0.5, 0.5, 0.1167) m"));
  EXPECT_THAT(notes, HasSubstr("cells of at most 0.077 m would have it"));
  EXPECT_TRUE(fill_mesh(mesh, {.cell_size = 0.077}).reports.at(0).lost.empty());
}

TEST(LostFeatures, WhatSamplesMeetIsNotLost) {
  // the same fin where samples are, thicker ones, and bodies without thin parts
  const std::pair<TriangleMesh, double> meshes[]{{finned_plate(0.5275, 0.5475), 0.1},
                                                 {finned_plate(0.48, 0.52), 0.1},
                                                 {icosphere(0.5, 20), 0.2},
                                                 {icosphere(0.5, 20), 0.07},
                                                 {torus(0.35, 0.15, 40, 20), 0.1},
                                                 {box_mesh({0, 0, 0}, {1.01, 0.33, 0.2}), 0.1},
                                                 {rod(0.1, 0, 1), 0.1}};
  for (const auto& [mesh, h] : meshes)
    for (const double offset : {0.0, 0.01, 0.3, 0.49, 0.77}) {
      if (offset != 0 && mesh.vertices.size() == 16) continue;  // fins elsewhere
      TriangleMesh turned = mesh;
      if (offset > 0.3) place(turned, {.axis = {1, 2, 3}, .degrees = 100 * offset});
      const MeshReport report =
          fill_mesh(turned, {.cell_size = h, .offset = Vec3::Constant(offset)}).reports.at(0);
      EXPECT_THAT(report.lost, ElementsAre()) << all_notes(report) << h << " " << offset;
    }
}

TEST(LostFeatures, OfOtherShapes) {
  const TriangleMesh block = box_mesh({-0.5, -0.5, 0}, {0.5, 0.5, 0.5});
  // shells of their own, which touch the block: a wire, a sheet that leans, a needle, a ball, far from each
  // other
  TriangleMesh wire = rod(0.01, 0.5, 1.5), sheet = box_mesh({0.5, -0.4, 0.218}, {1.5, 0.4, 0.228}),
               ball = icosphere(0.01, 3);
  place(wire, {.translation = {0.12, 0.05, 0}});
  place(ball, {.translation = {-1, 0.02, 0.22}});
  const std::tuple<const char*, TriangleMesh, double> features[]{{"wire", wire, enclosed_volume(wire)},
                                                                 {"sheet", sheet, enclosed_volume(sheet)},
                                                                 {"ball", ball, enclosed_volume(ball)}};
  for (const auto& [name, feature, volume] : features) {
    const MeshReport report = fill_mesh(joined(block, feature), {.cell_size = 0.1}).reports.at(0);
    ASSERT_EQ(report.lost.size(), 1U) << name;
    const Box box = bounding_box(feature), &found = report.lost[0].box;
    // all of it, but for what lies within half a cell of the block
    EXPECT_LT((found.lower - box.lower).cwiseAbs().maxCoeff(), 0.1) << name;
    EXPECT_LT((found.upper - box.upper).cwiseAbs().maxCoeff(), 1e-9) << name;
    EXPECT_NEAR(report.lost[0].volume, volume, 0.11 * volume) << name;
  }
  const MeshReport all =
      fill_mesh(joined(joined(block, wire), joined(sheet, ball)), {.cell_size = 0.1}).reports.at(0);
  EXPECT_EQ(all.lost.size(), 3U);
  EXPECT_GT(all.lost[0].volume, all.lost[1].volume);
}

TEST(LostFeatures, VolumeIsExactInCellsOfAnyPlacement) {
  // a fin that leans, in cells that lie anyhow: what the cells do not have adds up
  for (const double degrees : {0.0, 7.0, 20.0}) {
    TriangleMesh mesh = joined(box_mesh({0, 0, 0}, {1, 1, 0.3}), box_mesh({0.4, 0.1, 0.3}, {0.404, 0.9, 1}));
    place(mesh, {.axis = {0, 0, 1}, .degrees = degrees, .translation = {0.013, 0.02, 5}});
    const MeshReport report = fill_mesh(mesh, {.cell_size = 0.1}).reports.at(0);
    double lost = 0;
    for (const LostFeature& feature : report.lost) lost += feature.volume;
    constexpr double fin = 0.004 * 0.8 * 0.7;
    EXPECT_LE(lost, fin * (1 + 1e-9)) << degrees;
    EXPECT_GE(lost, degrees == 0 ? 0.9 * fin : 0) << degrees;
  }
}

TEST(LostFeatures, InAStaircaseAreThinnerThanACell) {
  const MeshReport report =
      fill_mesh(finned_plate(0.47, 0.53), {.cell_size = 0.1, .mode = FillMode::staircase}).reports.at(0);
  ASSERT_EQ(report.lost.size(), 1U);
  EXPECT_NEAR(report.lost[0].volume, 0.03, 1e-9);
  EXPECT_THAT(all_notes(report), HasSubstr("cells of at most 0.054 m would have it"));
}

}  // namespace
}  // namespace mss

// Seams that programs leave are welded, and triangles turned the same way, where that has a meaning.
#include "core/mesh/mesh_repair.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "core/base/error.hpp"
#include "core/mesh/mesh_fill.hpp"
#include "core/mesh/read_mesh.hpp"
#include "core/mesh/shapes.hpp"
#include "tests/core/mesh/mesh_files.hpp"
#include "tests/core/scene/scene_texts.hpp"

namespace mss {
namespace {

using ::testing::HasSubstr;

/// Every triangle with vertices of its own, moved by at most `distance` along each axis.
TriangleMesh unjoined(const TriangleMesh& mesh, double distance) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<> u(-distance, distance);
  TriangleMesh apart;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const Vec3& x : mesh.corners(t)) {
      const double dx = u(rng), dy = u(rng);
      apart.vertices.push_back(x + Vec3(dx, dy, u(rng)));
    }
    const auto n = int(apart.vertices.size());
    apart.triangles.push_back({n - 3, n - 2, n - 1});
  }
  return apart;
}

/// Triangles whose middle is on one side of a plane have vertices of their own, moved away from it.
TriangleMesh halved(const TriangleMesh& mesh, const Vec3& gap) {
  TriangleMesh result = mesh;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.corners(t);
    if ((a + b + c).dot(gap) <= 0) continue;
    for (int& v : result.triangles[t]) {
      result.vertices.push_back(mesh.vertices[std::size_t(v)] + gap);
      v = int(result.vertices.size()) - 1;
    }
  }
  return merge_identical(result);
}

TEST(MeshRepair, WeldsSeams) {
  const TriangleMesh sphere = icosphere(0.5, 8), ring = torus(0.35, 0.15, 24, 12);
  const TriangleMesh cube = box_mesh({0, 0, 0}, {1, 1, 1});
  TriangleMesh large = icosphere(500, 6);
  for (Vec3& x : large.vertices) x += Vec3(4e5, 5e6, 100);
  const std::tuple<const char*, TriangleMesh, TriangleMesh> meshes[]{
      {"cube", cube, unjoined(cube, 1e-7)},
      {"sphere of loose triangles", sphere, unjoined(sphere, 1e-6)},
      {"sphere of two halves", sphere, halved(sphere, {0, 0, 1e-6})},
      {"torus of two halves", ring, halved(ring, {-3e-6, 2e-6, 1e-6})},
      {"far away", large, unjoined(large, 1e-3)}};
  for (const auto& [name, sound, torn] : meshes) {
    EXPECT_FALSE(open_edges(torn).empty()) << name;
    TriangleMesh mesh = torn;
    EXPECT_EQ(weld_seams(mesh), torn.vertices.size() - sound.vertices.size()) << name;
    EXPECT_EQ(mesh.vertices.size(), sound.vertices.size()) << name;
    EXPECT_TRUE(open_edges(mesh).empty()) << name;
    EXPECT_NEAR(enclosed_volume(mesh), enclosed_volume(sound), 1e-4 * enclosed_volume(sound)) << name;
  }
}

TEST(MeshRepair, LeavesWhatIsNoSeam) {
  const TriangleMesh sphere = icosphere(0.5, 8);
  TriangleMesh holed = sphere;
  holed.triangles.resize(holed.triangles.size() - 5);
  TriangleMesh fine = icosphere(1e-6, 3);  // on a body of 1 m, a dot below the tolerance, but watertight
  for (const TriangleMesh& sound : {sphere, holed, halved(sphere, {0, 0, 1e-3}), joined(sphere, fine),
                                    TriangleMesh{}, box_mesh({0, 0, 0}, {0, 0, 0})}) {
    TriangleMesh mesh = sound;
    EXPECT_EQ(weld_seams(mesh), 0U);
    EXPECT_EQ(turn_alike(mesh), 0U);
    EXPECT_EQ(mesh.vertices, sound.vertices);
    EXPECT_EQ(mesh.triangles, sound.triangles);
  }
}

/// Turns about a share of the triangles, and returns how many.
std::size_t turn_some(TriangleMesh& mesh, double share) {
  std::mt19937 rng(2);
  std::size_t turned = 0;
  for (auto& t : mesh.triangles)
    if (std::uniform_real_distribution<>(0, 1)(rng) < share) {
      std::swap(t[0], t[1]);
      ++turned;
    }
  return turned;
}

TEST(MeshRepair, TurnsTrianglesTheSameWay) {
  const TriangleMesh sphere = icosphere(1, 8), hollow = joined(sphere, turned_inside_out(icosphere(0.5, 4)));
  const TriangleMesh two = joined(sphere, box_mesh({3, 0, 0}, {4, 1, 1}));
  for (const TriangleMesh& sound :
       {sphere, torus(0.7, 0.25, 24, 12), box_mesh({0, 0, 0}, {1, 2, 3}), hollow, two})
    for (const double share : {0.02, 0.25, 0.4}) {
      TriangleMesh mesh = sound;
      const std::size_t turned = turn_some(mesh, share);
      EXPECT_EQ(turn_alike(mesh), turned);
      EXPECT_TRUE(open_edges(mesh).empty());
      EXPECT_EQ(inconsistent_edges(mesh), 0U);
      EXPECT_DOUBLE_EQ(enclosed_volume(mesh), enclosed_volume(sound));
    }
  TriangleMesh most = sphere;  // then the sphere is inside out, which fill_mesh() mends
  const std::size_t turned = turn_some(most, 0.9);
  EXPECT_EQ(turn_alike(most), most.triangles.size() - turned);
  EXPECT_NEAR(enclosed_volume(most), -enclosed_volume(sphere), 1e-12);
}

/// A closed surface that crosses itself and has one side: a figure of eight that makes half a turn on its way
/// around a ring.
TriangleMesh klein_bottle(int around, int across) {
  TriangleMesh mesh;
  const auto at = [&](int i, int j) {  // (around, j) is (0, -j)
    return i < around ? i * across + (j + across) % across : (across - j) % across;
  };
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double u = 2 * std::numbers::pi * i / around;
      const double w = 2 * std::numbers::pi * j / across;
      const double r = 2 + std::cos(u / 2) * std::sin(w) - std::sin(u / 2) * std::sin(2 * w);
      mesh.vertices.emplace_back(r * std::cos(u), r * std::sin(u),
                                 std::sin(u / 2) * std::sin(w) + std::cos(u / 2) * std::sin(2 * w));
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

TEST(MeshRepair, ASurfaceOfOneSideIsNamed) {
  TriangleMesh bottle = klein_bottle(24, 16);
  EXPECT_GT(inconsistent_edges(bottle), 0U);
  EXPECT_EQ(turn_alike(bottle), 0U);
  try {
    const MeshFill fill = fill_mesh(bottle, {.cell_size = 0.2});
    ADD_FAILURE() << ::testing::PrintToString(fill.reports.at(0).notes());
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("triangles are turned inconsistently"));
  }
}

/// The kilograms of a file's body at 1000 kg/m^3 in ten cells, and what is said.
std::pair<double, std::string> body_of(const testing::SceneFolder& folder, const std::string& content) {
  const MeshOfFile read = read_mesh(folder.write("a.obj", content));
  const MeshFill fill = fill_meshes({{.mesh = read.mesh, .repairs = read.repairs}}, {.cell_size = 0.1});
  std::string notes;
  for (const std::string& note : fill.reports.at(0).notes()) notes += note + "; ";
  return {1000 * fill.reports[0].filled_volume, notes};
}

TEST(MeshRepair, MakesBodiesAndSaysHow) {
  const testing::SceneFolder folder;
  const TriangleMesh cube = box_mesh({0, 0, 0}, {1, 1, 1});
  TriangleMesh turned = cube;
  std::swap(turned.triangles[3][0], turned.triangles[3][1]);
  TriangleMesh both = unjoined(turned, 1e-7);
  EXPECT_THAT(body_of(folder, testing::obj(unjoined(cube, 1e-7))).second,
              HasSubstr("28 of its vertices at open edges were joined with others, nearer than 1e-05"));
  EXPECT_NEAR(body_of(folder, testing::obj(unjoined(cube, 1e-7))).first, 1000, 1e-3);
  EXPECT_THAT(body_of(folder, testing::obj(turned)).second,
              HasSubstr("1 of its 12 triangles faced the other way"));
  EXPECT_NEAR(body_of(folder, testing::obj(turned)).first, 1000, 1e-3);
  EXPECT_NEAR(body_of(folder, testing::obj(both)).first, 1000, 1e-3);
  EXPECT_THAT(body_of(folder, testing::obj(both)).second, HasSubstr("1 of its 12"));
}

}  // namespace
}  // namespace mss

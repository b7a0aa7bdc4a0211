// The surface that is drawn: closed, outward, and around exactly the body's volume.
#include "experiments/view/surface_mesh.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <set>

#include "core/measures/measures.hpp"
#include "tests/experiments/view/motion.hpp"
#include "tests/random_bodies.hpp"

namespace mss::view {
namespace {

Vec3 point_of(const std::array<float, 3>& p) { return {p[0], p[1], p[2]}; }

/// Faces between a cell and no cell, counted otherwise.
std::size_t boundary_faces(const VoxelGrid& voxels) {
  std::size_t touching = 0;
  for (int k = 0; k < voxels.nz(); ++k)
    for (int j = 0; j < voxels.ny(); ++j)
      for (int i = 0; i < voxels.nx(); ++i)
        if (voxels.at(i, j, k))
          touching += std::size_t(voxels.at(i + 1, j, k)) + voxels.at(i, j + 1, k) + voxels.at(i, j, k + 1);
  return 6 * voxels.count() - 2 * touching;
}

TEST(SurfaceMesh, HasTheFacesBetweenCellsAndNone) {
  constexpr std::size_t per_face = 12;  // four triangles of three vertices
  const Body box(testing::test_config(VoxelGrid::box(3, 4, 5)));
  EXPECT_EQ(SurfaceMesh(box).triangles().size(), per_face * 2 * (12 + 15 + 20));
  for (const auto& shape : testing::test_shapes()) {
    const SurfaceMesh mesh(Body(testing::test_config(shape.voxels)));
    EXPECT_EQ(mesh.triangles().size(), per_face * boundary_faces(shape.voxels)) << shape.name;
  }
}

// Every side of a triangle is met by another one that runs the other way.
TEST(SurfaceMesh, IsClosed) {
  for (const auto& shape : testing::test_shapes()) {
    const SurfaceMesh mesh(Body(testing::test_config(shape.voxels)));
    std::map<std::pair<std::array<float, 3>, std::array<float, 3>>, int> balance;
    for (std::size_t i = 0; i < mesh.triangles().size(); ++i) {
      const auto& a = mesh.vertices()[mesh.triangles()[i]].position;
      const auto& b = mesh.vertices()[mesh.triangles()[i % 3 == 2 ? i - 2 : i + 1]].position;
      ++balance[{a, b}];
      --balance[{b, a}];
    }
    EXPECT_GT(balance.size(), 0U);
    for (const auto& [side, count] : balance) EXPECT_EQ(count, 0) << shape.name;
  }
}

TEST(SurfaceMesh, EnclosesTheVolumeOfTheCellsHoweverTheyAreWarped) {
  for (const auto& shape : testing::test_shapes()) {
    const Body body(testing::test_config(shape.voxels));
    const SpringSystem<double> system(body, {});
    State<double> state = system.rest_state();
    SurfaceMesh mesh(body);
    const double at_rest = double(body.cell_count()) * body.cell_volume();
    EXPECT_NEAR(mesh.volume() / at_rest, 1, 1e-5) << shape.name;
    testing::randomise(body, state, 0.3, 0, 5);
    mesh.update(state.x, std::vector<float>(mesh.sites().size(), 0.0F));
    const double ratio = measure(system, state).volume_ratio;
    EXPECT_GT(std::abs(ratio - 1), 1e-4) << shape.name;
    EXPECT_NEAR(mesh.volume() / at_rest, ratio, 2e-5) << shape.name;  // vertices are in single precision
  }
}

TEST(SurfaceMesh, NormalsAreUnitAndOutward) {
  const Body body(testing::test_config(VoxelGrid::box(3, 2, 2)));
  const SurfaceMesh mesh(body);
  const Vec3 middle = body.config().origin + 0.2 * Vec3(1.5, 1, 1), half = 0.2 * Vec3(1.5, 1, 1);
  std::set<int> seen;
  for (const SurfaceVertex& vertex : mesh.vertices()) {
    const Vec3 n = point_of(vertex.normal), from_middle = point_of(vertex.position) - middle;
    Eigen::Index axis = 0;
    EXPECT_NEAR(n.cwiseAbs().maxCoeff(&axis), 1, 1e-6);
    EXPECT_NEAR(n.norm(), 1, 1e-6);
    EXPECT_NEAR(n.dot(from_middle), half[axis], 1e-6);  // sharp edges: each side has its own
    seen.insert(int(2 * axis) + (n[axis] > 0 ? 1 : 0));
  }
  EXPECT_EQ(seen.size(), 6U);
}

TEST(SurfaceMesh, CarriesValuesToCornersAndTheirMeanToCentres) {
  const Body body(testing::test_config(VoxelGrid::box(1, 1, 1)));
  SurfaceMesh mesh(body);
  ASSERT_EQ(mesh.sites(), body.sites());
  Field<double> x(body.lattice().size);
  std::vector<float> values;
  for (const std::ptrdiff_t site : mesh.sites()) {
    x.set(site, body.rest_position(site));
    values.push_back(float(body.rest_position(site).sum()));
  }
  mesh.update(x, values);
  for (const SurfaceVertex& vertex : mesh.vertices())
    EXPECT_NEAR(vertex.value, point_of(vertex.position).sum(), 1e-5);
}

TEST(SurfaceMesh, MarksEdgesOfCells) {
  const Body body(testing::test_config(VoxelGrid::box(3, 2, 2)));
  const SurfaceMesh mesh(body);
  const auto cells = [&](std::size_t i) {
    const auto& [u, w] = mesh.vertices()[mesh.triangles()[i]].cells;
    return Eigen::Vector2d(u, w);
  };
  for (std::size_t i = 0; i < mesh.triangles().size(); i += 3) {  // two corners and the middle of a face
    const Eigen::Vector2d side = cells(i + 1) - cells(i), middle = cells(i + 2);
    EXPECT_EQ(cells(i), cells(i).array().round().matrix());
    EXPECT_EQ(side.norm(), 1);
    EXPECT_EQ(middle, (middle.array().floor() + 0.5).matrix());
    EXPECT_EQ((middle - cells(i)).squaredNorm(), 0.5);
  }
}

BodyConfig thin_body(int nx, int ny, int nz) {
  return {.voxels = VoxelGrid::box(nx, ny, nz),
          .cell_size = 0.2,
          .thickness = 0.03,
          .density = 900,
          .springs = {.edge = 120, .face = nx * ny + ny * nz + nz * nx > 0 ? 80.0 : 0.0}};
}

/// Sheets and ropes are drawn closed, and as thick as they are; bent too.
TEST(SurfaceMesh, DrawsSheetsAndRopesAsThickAsTheyAre) {
  for (const auto& [nx, ny, nz] :
       std::vector<std::array<int, 3>>{{4, 3, 0}, {5, 0, 2}, {0, 3, 3}, {6, 0, 0}, {0, 5, 0}, {0, 0, 4}}) {
    const Body body(thin_body(nx, ny, nz));
    SurfaceMesh mesh(body);
    EXPECT_NEAR(mesh.volume() / body.volume(), 1, 1e-5);
    EXPECT_EQ(mesh.sites().size(), body.particle_count());
    Field<double> x(body.lattice().size);
    for (const std::ptrdiff_t site : body.sites()) {  // turned about an axis that is none of the lattice's
      const Eigen::AngleAxisd turn(1.2, Vec3(1, 2, -1).normalized());
      x.set(site, turn * body.rest_position(site));
    }
    mesh.update(x, std::vector<float>(mesh.sites().size(), 0.0F));
    EXPECT_NEAR(mesh.volume() / body.volume(), 1, 1e-5);
    for (const SurfaceVertex& vertex : mesh.vertices()) {
      EXPECT_NEAR(point_of(vertex.normal).norm(), 1, 1e-5);
      double nearest = 1;
      for (const std::ptrdiff_t site : body.sites())
        nearest = std::min(nearest, (x.at(site) - point_of(vertex.position)).norm());
      EXPECT_LT(nearest, 0.15);
    }
  }
}

TEST(SurfaceMesh, IsHitWhereItIs) {
  const Body body(testing::test_config(VoxelGrid::box(2, 2, 2)));
  const SurfaceMesh mesh(body);
  const Vec3 origin = body.config().origin, up = Vec3::UnitZ();
  const auto hit = mesh.hit({origin + Vec3(0.31, 0.35, 5), -up});
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->distance, 5 - 0.4, 1e-6);
  EXPECT_NEAR((body.rest_position(hit->site) - (origin + Vec3(0.4, 0.4, 0.4))).norm(), 0, 1e-12);
  EXPECT_FALSE(mesh.hit({origin + Vec3(0.5, 0.3, 5), -up}));  // past it
  EXPECT_FALSE(mesh.hit({origin + Vec3(0.3, 0.3, 5), up}));   // behind
}

TEST(SurfaceMesh, SaysHowParticlesMoveIt) {
  const Body body(testing::test_config(VoxelGrid::box(3, 2, 2)));
  SurfaceMesh mesh(body);
  Field<double> x(body.lattice().size);
  for (const std::ptrdiff_t site : body.sites()) {  // bent: faces are not flat
    const Vec3 at = body.rest_position(site);
    x.set(site, at + 0.3 * Vec3(at[1] * at[2], at[0] * at[2], at[0] * at[0]));
  }
  std::vector<float> values;
  for (const std::ptrdiff_t site : mesh.sites()) values.push_back(float(x.at(site).sum()));
  mesh.update(x, values);
  testing::expect_motion_is_that_of_update(mesh, x, values);
  EXPECT_FALSE(SurfaceMesh(Body(thin_body(4, 3, 0))).motion());  // its thickness is none of its particles'
}

}  // namespace
}  // namespace mss::view

// The mesh of a body as it is drawn: where its cells carry it, with their particles' values.
#include "experiments/view/true_surface.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/mesh/mesh_fill.hpp"
#include "core/mesh/shapes.hpp"
#include "tests/experiments/view/motion.hpp"

namespace mss::view {
namespace {

Vec3 as_vector(const std::array<float, 3>& p) { return {p[0], p[1], p[2]}; }

Body body_of(const TriangleMesh& mesh, double cell_size) {
  MeshFill fill = fill_mesh(mesh, {.cell_size = cell_size});
  return Body({.voxels = fill.voxels,
               .contents = fill.contents,
               .content_of = fill.content_of,
               .cell_size = fill.cell_size,
               .origin = fill.origin,
               .springs = {.edge = 100, .face = 50, .body = 100}});
}

/// The particles after an affine map, and the sum of their coordinates there as their values.
void move(TrueSurface& surface, const Body& body, const Eigen::Affine3d& map) {
  Field<double> x(body.lattice().size);
  std::vector<float> values;
  for (const std::ptrdiff_t site : surface.sites()) {
    x.set(site, map * body.rest_position(site));
    values.push_back(float(x.at(site).sum()));
  }
  surface.update(x, values);
}

TEST(TrueSurface, EnclosesTheVolumeOfTheMeshAndMovesWithAffineMaps) {
  const TriangleMesh ball = icosphere(0.5, 6);
  const Body body = body_of(ball, 0.13);
  TrueSurface surface(ball, body);
  EXPECT_NEAR(surface.volume() / enclosed_volume(ball), 1, 1e-6);
  ASSERT_EQ(surface.vertices().size(), ball.vertices.size());  // without sharp edges
  Eigen::Affine3d map(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
  map = Eigen::Translation3d(0.1, 0.2, 0.3) * map * Eigen::Scaling(1.2, 0.9, 1.1);
  move(surface, body, map);
  EXPECT_NEAR(surface.volume() / (1.2 * 0.9 * 1.1 * enclosed_volume(ball)), 1, 1e-6);
  for (std::size_t i = 0; i < surface.triangles().size(); ++i) {
    const SurfaceVertex& vertex = surface.vertices()[surface.triangles()[i]];
    const Vec3 expected = map * ball.vertices[std::size_t(ball.triangles[i / 3][i % 3])];
    EXPECT_LT((as_vector(vertex.position) - expected).norm(), 1e-6);
    EXPECT_NEAR(vertex.value, expected.sum(), 2e-6);
  }
}

TEST(TrueSurface, NormalsAreThoseOfTheDeformedTriangles) {
  const TriangleMesh ball = icosphere(0.5, 8);
  const Body body = body_of(ball, 0.2);
  TrueSurface surface(ball, body);
  move(surface, body, Eigen::Affine3d(Eigen::Scaling(2.0, 1.0, 1.0)));
  double worst = 1;
  for (const SurfaceVertex& vertex : surface.vertices()) {
    const Vec3 x = as_vector(vertex.position), normal = Vec3(x[0] / 4, x[1], x[2]).normalized();
    EXPECT_NEAR(as_vector(vertex.normal).norm(), 1, 1e-6);
    worst = std::min(worst, as_vector(vertex.normal).dot(normal));
  }
  EXPECT_GT(worst, 0.995);
  EXPECT_LT(worst, 0.999999);  // of flat triangles
}

TEST(TrueSurface, KeepsSharpEdgesSharp) {
  const TriangleMesh box = box_mesh({0, 0, 0}, {1, 1, 1});
  const TrueSurface surface(box, body_of(box, 0.25));
  EXPECT_EQ(surface.vertices().size(), 24U);
  for (const SurfaceVertex& vertex : surface.vertices())
    EXPECT_NEAR(as_vector(vertex.normal).cwiseAbs().maxCoeff(), 1, 1e-6);
}

TEST(TrueSurface, IsHitWhereItIs) {
  const TriangleMesh ball = icosphere(0.5, 10);
  const Body body = body_of(ball, 0.1);
  const TrueSurface surface(ball, body);
  const auto hit = surface.hit({Vec3(0.1, 0.05, 5), -Vec3::UnitZ()});
  ASSERT_TRUE(hit);
  const double height = std::sqrt(0.25 - 0.01 - 0.0025);
  EXPECT_NEAR(hit->distance, 5 - height, 3e-3);
  EXPECT_LT((body.rest_position(hit->site) - Vec3(0.1, 0.05, height)).norm(),
            0.15);  // a cell's diagonal is .17
  EXPECT_TRUE(body.particle(hit->site) >= 0);
  EXPECT_FALSE(surface.hit({Vec3(0.51, 0, 5), -Vec3::UnitZ()}));  // past it
}

TEST(TrueSurface, SaysHowParticlesMoveIt) {
  const TriangleMesh box = box_mesh(Vec3::Zero(), Vec3(1, 0.7, 0.5));  // with edges
  const Body body = body_of(box, 0.13);
  TrueSurface surface(box, body);
  Field<double> x(body.lattice().size);
  std::vector<float> values;
  for (const std::ptrdiff_t site : surface.sites()) {
    const Vec3 at = body.rest_position(site);
    x.set(site, at + 0.3 * Vec3(at[1] * at[2], at[0] * at[2], at[0] * at[0]));
    values.push_back(float(at.sum()));
  }
  surface.update(x, values);
  testing::expect_motion_is_that_of_update(surface, x, values);
}

}  // namespace
}  // namespace mss::view

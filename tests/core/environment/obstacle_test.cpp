#include "core/environment/obstacle.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "core/base/error.hpp"
#include "core/environment/contact.hpp"
#include "core/mesh/shapes.hpp"
#include "core/mesh/winding.hpp"

namespace mss::obstacle_test {
namespace {

using Random = std::mt19937;

double uniform(Random& random, double from, double to) {
  return std::uniform_real_distribution<double>(from, to)(random);
}
Vec3 any_direction(Random& random) {
  Vec3 x;
  do x = Vec3(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
  while (x.norm() > 1 || x.norm() < 0.1);
  return x.normalized();
}

const Obstacle ball{.radius = 0.3, .centre = {0.1, 0.2, 0.3}};
const Obstacle slab{.shape = ObstacleShape::box,
                    .size = {0.4, 0.7, 0.2},
                    .centre = {0.1, -0.2, 0},
                    .axis = Vec3(1, 2, 2) / 3,
                    .degrees = 40};
const Obstacle pill{.shape = ObstacleShape::capsule,
                    .radius = 0.15,
                    .length = 0.5,
                    .centre = {0, 0.1, 0},
                    .axis = Vec3(2, -1, 2) / 3};
const Obstacle drum{.shape = ObstacleShape::cylinder,
                    .radius = 0.3,
                    .length = 0.4,
                    .centre = {0, 0, 0.1},
                    .axis = Vec3(-2, 1, 2) / 3};
Obstacle of_mesh(const TriangleMesh& mesh) {
  return {.shape = ObstacleShape::mesh, .mesh = std::make_shared<TriangleMesh>(mesh), .axis = Vec3::UnitX()};
}
const Obstacle ring = of_mesh(torus(0.4, 0.15, 24, 12));
const Obstacle cube = of_mesh(box_mesh(Vec3::Constant(-0.3), Vec3::Constant(0.3)));

/// A point of a shape's surface about its own axes.
Vec3 any_point(const Obstacle& o, Random& random) {
  const double angle = uniform(random, 0, 2 * std::numbers::pi);
  const Vec3 round(std::cos(angle), std::sin(angle), 0);
  switch (o.shape) {
    case ObstacleShape::sphere:
      return o.radius * any_direction(random);
    case ObstacleShape::box: {
      Vec3 x(uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5));
      x[int(random() % 3)] = random() % 2 == 0 ? 0.5 : -0.5;
      return x.cwiseProduct(o.size);
    }
    case ObstacleShape::capsule: {
      const Vec3 cap = o.radius * any_direction(random);
      if (random() % 2 == 0) return cap + std::copysign(o.length / 2, cap[2]) * Vec3::UnitZ();
      return o.radius * round + uniform(random, -0.5, 0.5) * o.length * Vec3::UnitZ();
    }
    case ObstacleShape::cylinder:
      if (random() % 2 == 0) return o.radius * round + uniform(random, -0.5, 0.5) * o.length * Vec3::UnitZ();
      return o.radius * std::sqrt(uniform(random, 0, 1)) * round +
             (random() % 2 == 0 ? 0.5 : -0.5) * o.length * Vec3::UnitZ();
    case ObstacleShape::mesh:
      break;
  }
  const auto [a, b, c] = o.mesh->corners(random() % o.mesh->triangles.size());
  double u = uniform(random, 0, 1), v = uniform(random, 0, 1);
  if (u + v > 1) u = 1 - u, v = 1 - v;
  return a + u * (b - a) + v * (c - a);
}
Vec3 placed(const Obstacle& o, const Vec3& y) {
  const bool has_axis = o.shape == ObstacleShape::capsule || o.shape == ObstacleShape::cylinder;
  if (!has_axis) return o.centre + Eigen::AngleAxisd(o.degrees * std::numbers::pi / 180, o.axis) * y;
  return o.centre + Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), o.axis) * y;
}

TEST(Obstacle, DistancesAndNormalsAreThoseOfTheNearestOfManyPoints) {
  Random random(7);
  for (const Obstacle& o : {ball, slab, pill, drum, ring, cube}) {
    const ObstacleSurface surface(o);
    std::vector<Vec3> points;
    for (int i = 0; i < 20000; ++i) points.push_back(placed(o, any_point(o, random)));
    TriangleMesh outside = surface.triangles(0);
    const WindingTree winding(outside);
    for (int i = 0; i < 60; ++i) {
      const Vec3 x = o.centre + uniform(random, 0.02, 0.8) * any_direction(random);
      double nearest = 1e9;
      for (const Vec3& point : points) nearest = std::min(nearest, (point - x).norm());
      const double gap = surface.gap(x, 0);
      const int shape = int(o.shape);
      EXPECT_LE(std::abs(gap), nearest + 1e-12) << shape;
      EXPECT_NEAR(std::abs(gap), nearest, 0.02) << shape;
      if (std::abs(gap) > 0.02) {
        EXPECT_EQ(winding.at(x).winding > 0.5, gap < 0) << shape << " " << x;
      }
      const MovingPlane plane = surface.plane(x, 0, 0);
      EXPECT_NEAR(plane.plane.normal.norm(), 1, 1e-12);
      EXPECT_NEAR(plane.plane.gap(x), gap, 1e-12);
      EXPECT_NEAR(surface.gap(plane.plane.point, 0), 0, 1e-12) << shape;
      Vec3 slope;
      for (int axis = 0; axis < 3; ++axis)
        slope[axis] =
            (surface.gap(x + 1e-6 * Vec3::Unit(axis), 0) - surface.gap(x - 1e-6 * Vec3::Unit(axis), 0)) /
            2e-6;
      if (std::abs(slope.norm() - 1) < 1e-6) {
        EXPECT_LT((slope - plane.plane.normal).norm(), 1e-5) << shape;
      }
    }
  }
}

TEST(Obstacle, AMeshOfABoxIsTheBox) {
  const Obstacle box{.shape = ObstacleShape::box, .size = Vec3::Constant(0.6)};
  const ObstacleSurface of_shape(box), as_mesh(cube);
  Random random(3);
  for (int i = 0; i < 300; ++i) {
    const Vec3 x = uniform(random, 0, 0.9) * any_direction(random);
    EXPECT_NEAR(of_shape.gap(x, 0), as_mesh.gap(x, 0), 1e-14);
  }
}

TEST(Obstacle, RefusesMeshesThatAreNotClosed) {
  TriangleMesh open = *cube.mesh;
  open.triangles.pop_back();
  EXPECT_THROW(ObstacleSurface{of_mesh(open)}, InputError);
  EXPECT_THROW(ObstacleSurface{of_mesh({})}, InputError);
}

TEST(Obstacle, MovesAlongItsPathAndTurns) {
  Obstacle o = slab;
  o.path.points = {{0, Vec3::Zero()}, {1, Vec3(1, 0, 0)}, {2, Vec3(1, 2, 0)}};
  o.turn = Turn{.axis = Vec3::UnitZ(), .centre = Vec3(0, 0.5, 0), .rate = 3, .until = 1.5};
  const ObstacleSurface surface(o), at_rest(slab);
  Random random(5);
  for (const double t : {0.3, 0.8, 1.2, 1.7}) {
    const double angle = 3 * std::min(t, 1.5);
    const Eigen::AngleAxisd turned(angle, Vec3::UnitZ());
    const Vec3 path = t < 1 ? Vec3(t, 0, 0) : Vec3(1, 2 * (t - 1), 0);
    EXPECT_LT((surface.centre(t) - (turned * (o.centre - o.turn->centre) + o.turn->centre + path)).norm(),
              1e-14);
    for (int i = 0; i < 20; ++i) {
      const Vec3 rest = o.centre + uniform(random, 0, 0.8) * any_direction(random);
      const Vec3 x = turned * (rest - o.turn->centre) + o.turn->centre + path;
      EXPECT_NEAR(surface.gap(x, t), at_rest.gap(rest, 0), 1e-13);
      const double dt = 1e-5;
      const MovingPlane plane = surface.plane(x, t, dt);
      EXPECT_LT((plane.moved / dt - plane.velocity).norm(), 1e-3);
    }
  }
  EXPECT_TRUE(o.moves(1.9));
  EXPECT_FALSE(o.moves(2));
  EXPECT_FALSE(slab.moves());
}

// Whatever a step skips: the plane is where the way enters, also of what moves and turns.
TEST(Obstacle, StopsWhatWouldPassItInAStep) {
  const double dt = 1e-3, close = 1e-6;
  const Obstacle plate{.shape = ObstacleShape::box, .size = {1, 1, 1e-3}};
  const ObstacleSurface surface(plate);
  auto met = surface.met({Vec3(0, 0, 0.01), Vec3(0.01, 0, -0.02), dt, dt}, close);
  ASSERT_TRUE(met);
  EXPECT_LT((met->plane.normal - Vec3::UnitZ()).norm(), 1e-12);
  EXPECT_LT((met->plane.point - Vec3(0.01 * 0.0095 / 0.03, 0, 0.0005)).norm(), 1e-8);
  // It lies on the plate, and a step would take it to the other side, or nearer to that.
  for (const double end : {-0.02, -0.0003}) {
    met = surface.met({Vec3(0, 0, 0.0005), Vec3(0, 0, end), dt, dt}, close);
    ASSERT_TRUE(met) << end;
    EXPECT_GT(met->plane.normal[2], 0.99) << end;
  }
  EXPECT_FALSE(surface.met({Vec3(0, 0, 0.01), Vec3(0.1, 0, 0.0006), dt, dt}, close));
  EXPECT_FALSE(surface.met({Vec3(0.6, 0, 0.01), Vec3(0.6, 0, -0.01), dt, dt}, close));
  Obstacle swung = plate;  // a plate that comes to a point at rest
  swung.path.points = {{0, Vec3(0, 0, 0)}, {dt, Vec3(0, 0, 0.02)}};
  met = ObstacleSurface(swung).met({Vec3(0, 0, 0.01), Vec3(0, 0, 0.01), dt, dt}, close);
  ASSERT_TRUE(met);
  EXPECT_GT(met->plane.normal[2], 0.99);
  EXPECT_NEAR(met->velocity[2], 0, 1e-12);  // the path has ended
  EXPECT_NEAR(met->moved[2], 0.02, 1e-12);
}

TEST(Obstacle, PenaltiesLoseWhatIsRelativeToThem) {
  const MovingPlane still{.plane = {.friction = 0.7}}, moving{still.plane, Vec3(0.4, -0.2, 0.1)};
  const Penalty law(still.plane, {.omega = 100}, 9.81, 0.1);
  const Vec3 x(0, 0, -0.003), v(0.5, 0.1, -0.2);
  const Vec3 carried = law.on(moving).acceleration({x, v + moving.velocity});
  EXPECT_LT((carried - law.acceleration({x, v})).norm(), 1e-12);
}

}  // namespace
}  // namespace mss::obstacle_test

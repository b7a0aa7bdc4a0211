// Shape matching: rigid motions are left alone, goals are those of the definition, and what it conserves.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cstring>

#include "integrators/integrator.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

/// The goal of a particle from the definition: a loop over regions, and a singular value decomposition each.
Vec3 goal_by_definition(const Body& body, const Field<double>& x, int width, std::ptrdiff_t site) {
  const Lattice& lattice = body.lattice();
  const auto place = [&](std::ptrdiff_t s) {
    const auto [i, j, k] = lattice.coordinates(s);
    return Eigen::Vector3i(i, j, k);
  };
  const auto near = [&](std::ptrdiff_t a, std::ptrdiff_t b) {
    return width == 0 || (place(a) - place(b)).cwiseAbs().maxCoeff() <= width;
  };
  const auto regions = [&](std::ptrdiff_t particle) {
    if (width == 0) return 1;
    int count = 0;
    for (const std::ptrdiff_t r : body.sites()) count += near(r, particle) ? 1 : 0;
    return count;
  };
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (const std::ptrdiff_t region : body.sites()) {
    if (!near(region, site)) continue;
    double mass = 0;
    Vec3 c = Vec3::Zero(), c0 = Vec3::Zero();
    for (const std::ptrdiff_t i : body.sites()) {
      if (!near(region, i)) continue;
      const double m = body.mass(i) / regions(i);
      mass += m;
      c += m * x.at(i);
      c0 += m * body.rest_position(i);
    }
    c /= mass;
    c0 /= mass;
    Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
    for (const std::ptrdiff_t i : body.sites())
      if (near(region, i))
        a += body.mass(i) / regions(i) * (x.at(i) - c) * (body.rest_position(i) - c0).transpose();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
    sum += svd.matrixU() * svd.matrixV().transpose() * (body.rest_position(site) - c0) + c;
    ++count;
    if (width == 0) break;
  }
  return sum / count;
}

TEST(ShapeMatching, GoalsAreThoseOfTheDefinition) {
  for (const int width : {0, 1, 2})
    for (const char* shape : {"cube3", "plate_x", "ell"}) {
      const auto shapes = testing::test_shapes();
      const Body body(testing::test_config(std::find_if(shapes.begin(), shapes.end(), [&](const auto& s) {
                                             return s.name == shape;
                                           })->voxels));
      SpringSystem<double> system(body, {}, {.threads = 2});
      State<double> state = system.rest_state();
      testing::randomise(body, state, 0.2, 0, 5);
      const State<double> start = state;
      Work work;
      ASSERT_EQ(find_integrator("shape_matching")
                    .make<double>({.dt = 0.01, .region_width = width, .alpha = 0.5})
                    ->advance(system, state, 0.01, work),
                Status::ok);
      for (const std::ptrdiff_t site : body.sites()) {
        const Vec3 goal = goal_by_definition(body, start.x, width, site);
        EXPECT_LT((state.x.at(site) - (start.x.at(site) + goal) / 2).norm(), 1e-9) << shape << width;
      }
    }
}

TEST(ShapeMatching, LeavesRigidMotionAlone) {
  const Body body(testing::test_config(VoxelGrid::box(4, 3, 5)));
  SpringSystem<double> system(body, {}, {.threads = 1});
  State<double> state = system.rest_state();
  const Eigen::AngleAxisd turn(2.5, Vec3(1, 2, 3).normalized());
  for (const std::ptrdiff_t site : body.sites()) {
    state.x.set(site, turn * state.x.at(site) + Vec3(1, 0, 2));
    state.v.set(site, Vec3(0.3, 0, 0));
  }
  const State<double> start = state;
  const auto method = find_integrator("shape_matching").make<double>({.dt = 0.01});
  Work work;
  ASSERT_EQ(method->advance(system, state, 0.5, work), Status::ok);
  for (const std::ptrdiff_t site : body.sites())
    EXPECT_LT((state.x.at(site) - start.x.at(site) - Vec3(0.15, 0, 0)).norm(), 1e-3);
}

TEST(ShapeMatching, KeepsLinearMomentum) {
  for (const int width : {0, 2}) {
    const Body body(testing::test_config(VoxelGrid::box(5, 4, 6)));
    SpringSystem<double> system(body, {}, {.threads = 1});
    State<double> state = system.rest_state();
    testing::randomise(body, state, 0.1, 0.5, 7);
    const auto momentum = [&] {
      Vec3 sum = Vec3::Zero();
      for (const std::ptrdiff_t site : body.sites()) sum += body.mass(site) * state.v.at(site);
      return sum;
    };
    const Vec3 before = momentum();
    Work work;
    find_integrator("shape_matching")
        .make<double>({.dt = 0.01, .region_width = width})
        ->advance(system, state, 0.01, work);
    EXPECT_LT((momentum() - before).norm(), 1e-11 * body.total_mass()) << width;
  }
}

TEST(ShapeMatching, IsTheSameForAnyNumberOfThreads) {
  const Body body(testing::test_config(VoxelGrid::box(5, 4, 6)));
  const auto end = [&](int threads) {
    SpringSystem<double> system(body, {.gravity = Vec3(0, 0, -1)}, {.threads = threads});
    State<double> state = system.rest_state();
    testing::randomise(body, state, 0.1, 0.5, 7);
    Work work;
    find_integrator("shape_matching").make<double>({.dt = 0.01})->advance(system, state, 0.3, work);
    return state;
  };
  const State<double> one = end(1);
  for (const int threads : {2, 3, 8}) {
    const State<double> other = end(threads);
    EXPECT_EQ(std::memcmp(one.x.axis(0), other.x.axis(0), std::size_t(one.x.size()) * sizeof(double)), 0);
  }
}

}  // namespace
}  // namespace mss

// Vertex block descent: with enough passes it is backward Euler; the same for any number of threads.
#include <gtest/gtest.h>

#include <cstring>

#include "integrators/integrator.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

State<double> end_of(const Body& body, const char* method, const IntegratorOptions& options,
                     int threads = 1) {
  SpringSystem<double> system(body, {.gravity = Vec3(0, 0, -9.81)}, {.threads = threads});
  State<double> state = system.rest_state();
  testing::randomise(body, state, 0.05, 0.5, 11);
  Work work;
  EXPECT_EQ(find_integrator(method).make<double>(options)->advance(system, state, 5 * options.dt, work),
            Status::ok);
  return state;
}

double distance(const Body& body, const State<double>& a, const State<double>& b) {
  double largest = 0;
  for (const std::ptrdiff_t site : body.sites())
    largest = std::max(largest, (a.x.at(site) - b.x.at(site)).norm());
  return largest;
}

TEST(Vbd, TendsToBackwardEulerOnEveryShape) {
  for (const auto& [name, voxels] : testing::test_shapes())
    for (const bool damped : {false, true}) {
      BodyConfig config = testing::test_config(voxels);
      if (!damped) config.damping = {};
      const Body body(config);
      const State<double> exact = end_of(body, "backward_euler", {.dt = 0.05}),
                          few = end_of(body, "vbd", {.dt = 0.05, .iterations = 2}),
                          many = end_of(body, "vbd", {.dt = 0.05, .iterations = 300});
      EXPECT_LT(distance(body, many, exact), 1e-9) << name;
      EXPECT_LT(distance(body, few, exact), 0.05) << name;
      EXPECT_GT(distance(body, few, exact), 1e-6) << name;
    }
}

TEST(Vbd, TendsToBackwardEulerWhereCellsAreMixed) {
  for (const auto& voxels : {VoxelGrid::box(3, 3, 3), VoxelGrid::box(9, 7, 1)}) {
    const Body body(testing::mixed_config(voxels, 3));
    const State<double> exact = end_of(body, "backward_euler", {.dt = 0.02}),
                        few = end_of(body, "vbd", {.dt = 0.02, .iterations = 2}),
                        many = end_of(body, "vbd", {.dt = 0.02, .iterations = 300});
    EXPECT_LT(distance(body, many, exact), 1e-9);
    EXPECT_GT(distance(body, few, exact), 1e-6);
  }
}

/// Ten frames of a soft cube that is held at one face and released: slow motions need many passes.
State<double> hanging_cube(const char* method, const IntegratorOptions& options) {
  BodyConfig config{.voxels = VoxelGrid::box(7, 7, 7), .cell_size = 1.0 / 7};
  config.fill({.young = 1e6, .poisson = 0.3}, 0.5);
  const Body body(config);
  SpringSystem<double> system(
      body, {.gravity = Vec3(0, 0, -9.81), .holds = {{.box = {{0, 0, 0}, {0, 1, 1}}}}}, {.threads = 1});
  State<double> state = system.rest_state();
  Work work;
  EXPECT_EQ(find_integrator(method).make<double>(options)->advance(system, state, 10 * options.dt, work),
            Status::ok);
  return state;
}

TEST(Vbd, AccelerationLeadsToTheSameSooner) {
  constexpr double frame = 1.0 / 60;
  BodyConfig config{.voxels = VoxelGrid::box(7, 7, 7), .cell_size = 1.0 / 7};
  const Body body(config);
  const State<double> exact = hanging_cube("backward_euler", {.dt = frame});
  const auto error = [&](int passes, double radius) {
    return distance(
        body, hanging_cube("vbd", {.dt = frame, .iterations = passes, .chebyshev_radius = radius}), exact);
  };
  EXPECT_LT(error(20, 0.9), 0.2 * error(20, 0));
  EXPECT_LT(error(300, 0.9), 1e-6);
  EXPECT_EQ(error(1, 0.9), error(1, 0));  // the first pass is not weighted
}

TEST(Vbd, IsTheSameForAnyNumberOfThreads) {
  const Body body(testing::test_config(VoxelGrid::box(5, 4, 6)));
  for (const double radius : {0.0, 0.5}) {
    const IntegratorOptions options{.dt = 0.01, .iterations = 4, .chebyshev_radius = radius};
    const State<double> one = end_of(body, "vbd", options);
    for (const int threads : {2, 3, 8}) {
      const State<double> other = end_of(body, "vbd", options, threads);
      EXPECT_EQ(std::memcmp(one.x.axis(0), other.x.axis(0), std::size_t(one.x.size()) * sizeof(double)), 0);
    }
  }
}

}  // namespace
}  // namespace mss

// Discrete gradients: their work is exactly the energy lost, however far the step, and they tend to the
// forces.
#include "core/springs/discrete_gradient.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/measures/measures.hpp"
#include "tests/random_bodies.hpp"

namespace mss {
namespace {

/// A body, and two states of it at a distance from each other.
struct Step {
  Step(const BodyConfig& config, double apart) : body(config), system(body, {.gravity = Vec3(1, 2, -9.81)}) {
    from = to = system.rest_state();
    testing::randomise(body, from, 0.3, 0, 5);
    to = from;
    testing::randomise(body, to, apart, 0, 6);
  }
  Field<double> middle() const {
    Field<double> x = from.x;
    x.array() = (x.array() + to.x.array()) / 2;
    return x;
  }
  Field<double> force() {
    Field<double> f(system.size());
    system.force(0, middle(), from.v, f);
    return f;
  }
  Field<double> conserving_force() {
    Field<double> f = force();
    discrete_gradient_of<double>(system).correct(from.x, to.x, f);
    return f;
  }
  double work(const Field<double>& f) const {
    double sum = 0;
    for (const std::ptrdiff_t site : body.sites()) sum += f.at(site).dot(to.x.at(site) - from.x.at(site));
    return sum;
  }
  double lost() const { return measure(system, from).total() - measure(system, to).total(); }

  Body body;
  SpringSystem<double> system;
  State<double> from, to;
};

BodyConfig undamped(const VoxelGrid& voxels, double volume) {
  BodyConfig config = testing::test_config(voxels);
  config.damping = {};
  config.springs.volume = volume;
  return config;
}

TEST(DiscreteGradient, DoesTheWorkThatTheEnergyLoses) {
  for (const auto& shape : testing::test_shapes())
    for (const double volume : {700.0, 0.0, -50.0}) {
      Step step(undamped(shape.voxels, volume), 0.8);
      const double size = measure(step.system, step.from).elastic;
      EXPECT_NEAR(step.work(step.conserving_force()), step.lost(), 1e-11 * size) << shape.name;
      EXPECT_GT(std::abs(step.work(step.force()) - step.lost()), 1e-3 * size)
          << shape.name;  // the midpoint's
    }
}

TEST(DiscreteGradient, KnowsOfFillFactorsAndParts) {
  BodyConfig config = testing::mixed_config(VoxelGrid::box(3, 2, 4), 5);
  config.damping = {};
  for (Part& part : config.parts) part.damping = {};
  Step step(config, 0.8);
  EXPECT_NEAR(step.work(step.conserving_force()), step.lost(),
              1e-11 * measure(step.system, step.from).elastic);
}

TEST(DiscreteGradient, TurnsNothing) {
  Step step(undamped(VoxelGrid::box(3, 2, 4), 0), 0.8);
  const Field<double> f = step.conserving_force(), x = step.middle();
  Vec3 torque = Vec3::Zero();
  double size = 0;
  for (const std::ptrdiff_t site : step.body.sites()) {
    const Vec3 weight = step.body.mass(site) * step.system.environment().gravity;
    torque += x.at(site).cross(f.at(site) - weight);
    size += f.at(site).norm();
  }
  EXPECT_LT(torque.norm(), 1e-13 * size);
}

TEST(DiscreteGradient, TendsToTheForceAtSecondOrder) {
  const auto difference = [](double apart) {
    Step step(undamped(VoxelGrid::box(3, 2, 4), 700), apart);
    return (step.conserving_force().array() - step.force().array()).abs().maxCoeff();
  };
  EXPECT_NEAR(std::log2(difference(0.02) / difference(0.01)), 2, 0.05);
}

}  // namespace
}  // namespace mss

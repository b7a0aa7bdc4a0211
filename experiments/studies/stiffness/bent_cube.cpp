#include "experiments/studies/stiffness/bent_cube.hpp"

#include <cmath>
#include <random>

#include "experiments/simulation/cubes.hpp"
#include "experiments/simulation/model.hpp"

namespace mss::studies::stiffness {

namespace {

constexpr double density = 1000, damping_ratio = 0.01, bend = 0.5, stretch = 1.1;

/// The cube's middle line becomes an arc; cross-sections stay plane and at right angles to it.
Vec3 bent(const Vec3& rest) {
  const double turn = bend * rest[2], radius = stretch / bend, across = rest[0] - 0.5;
  return {0.5 + radius * (1 - std::cos(turn)) + across * std::cos(turn), rest[1],
          radius * std::sin(turn) - across * std::sin(turn)};
}

/// A number in [-1, 1), the same everywhere.
double uniform(std::mt19937_64& random) { return std::ldexp(double(random() >> 11U), -52) - 1; }

}  // namespace

BentCube::BentCube(int n, const ElasticConstants& material, double noise)
    : body(unit_cube(material, density, n, damping_ratio)), state(system(spring_model)->undeformed_state()) {
  std::mt19937_64 random(1);
  for (const std::ptrdiff_t site : body.sites()) {
    const Vec3 rest = body.rest_position(site);
    Vec3 x = bent(rest);
    for (int axis = 0; axis < 3; ++axis) x[axis] += noise / n * uniform(random);
    if (rest[2] > 0) state.x.set(site, x);
  }
}

std::unique_ptr<BodySystem<double>> BentCube::system(const std::string& model) const {
  return make_system<double>(model, body, {.holds = {{.box = {{0, 0, 0}, {1, 1, 0}}}}}, 1);
}

}  // namespace mss::studies::stiffness

#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/springs/spring_system.hpp"
#include "reference/algorithm1.hpp"
#include "tests/random_bodies.hpp"

namespace mss::testing {

/// Largest difference of a body's forces, in a random state, from those of Algorithm 1, over their largest.
template <class Real>
double relative_force_error(const BodyConfig& config, const std::string& kernel, int threads,
                            double amplitude = 0.4, const Vec3& gravity = Vec3(0.3, -0.2, -9.81)) {
  const Body body(config);
  SpringSystem<Real> system(body, {.gravity = gravity}, {threads, kernel});
  reference::Algorithm1 oracle(config, gravity, 1);
  auto state = system.rest_state();
  randomise(body, state, amplitude, 0.5, 3);
  copy_state(body, state, oracle);
  oracle.compute_forces();
  Field<Real> f(system.size());
  system.force(0, state.x, state.v, f);
  double largest = 0, error = 0;
  for (std::size_t id = 0; id < body.particle_count(); ++id) {
    const Vec3& expected = oracle.particles()[id].f;
    largest = std::max(largest, expected.norm());
    error = std::max(error, (f.at(body.sites()[id]) - expected).norm());
  }
  EXPECT_GT(largest, 0);
  return error / largest;
}

}  // namespace mss::testing

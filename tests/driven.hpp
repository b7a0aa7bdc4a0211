#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/springs/solid_system.hpp"
#include "integrators/integrator.hpp"

namespace mss::testing {

/// Expects that every integrator that can takes a system through a short motion, against RK4 with half the
/// step.
inline void expect_driven_by_every_integrator(SolidSystem<double>& system) {
  const double dt = 0.01 / system.spectral_bound().omega, duration = 500 * dt;
  const auto end_of = [&](const std::string& name, double step) {
    State<double> state = system.rest_state();
    Work work;
    EXPECT_EQ(find_integrator(name)
                  .make<double>({.dt = step, .tolerance = 1e-8})
                  ->advance(system, state, duration, work),
              Status::ok)
        << name;
    return state;
  };
  const auto distance = [&](const State<double>& a, const State<double>& b) {
    double largest = 0;
    for (const std::ptrdiff_t site : system.particles())
      largest = std::max(largest, (a.x.at(site) - b.x.at(site)).norm());
    return largest;
  };
  const State<double> expected = end_of("rk4", dt / 2);
  const double moved = distance(expected, system.rest_state());
  ASSERT_GT(moved, 0);
  for (const IntegratorInfo& method : integrators()) {
    if (!method.moves_particles()) continue;
    if (method.needs_springs() && !system.discrete_gradient()) continue;
    const State<double> state = end_of(method.name, method.stepping == Stepping::fixed ? dt : 0);
    EXPECT_LT(distance(state, expected), 0.01 * moved) << method.name;
  }
}

}  // namespace mss::testing

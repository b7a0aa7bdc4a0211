#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>

#include "core/springs/spring_system.hpp"
#include "integrators/integrator.hpp"
#include "tests/random_bodies.hpp"

namespace mss::testing {

template <class Real>
double largest_difference(const Body& body, const Field<Real>& a, const Field<Real>& b) {
  double largest = 0;
  for (const std::ptrdiff_t site : body.sites())
    largest = std::max(largest, (a.at(site) - b.at(site)).norm());
  return largest;
}

/// A body in an environment, stepped by a method on the processor or on a device.
template <class Real>
struct Driven {
  Body body;
  SpringSystem<Real> system;
  State<Real> state;
  std::unique_ptr<Integrator<Real>> method;
  Work work;

  Driven(const BodyConfig& config, const Environment& environment, const std::string& name,
         IntegratorOptions options)
      : body(config),
        system(body, environment, {.threads = 1}),
        state(system.rest_state()),
        method(find_integrator(name).make<Real>(options)) {
    system.constrain(0, state.x, state.v);
  }

  Status advance(double t) { return method->advance(system, state, t, work); }
};

}  // namespace mss::testing

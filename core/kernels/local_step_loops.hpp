// Compiled by sweep_loops.hpp once per instruction set.
#pragma once

#include "core/kernels/independent_loop.hpp"
#include "core/kernels/local_step.hpp"

namespace mss::MSS_ISA {

/// Calls body(i) for every number, with no dependence between them.
template <class Body>
inline void for_numbers(std::ptrdiff_t count, Body&& body) {
  MSS_INDEPENDENT
  for (std::ptrdiff_t i = 0; i < count; ++i) body(i);
}

template <class Real, class Acceleration>
void displace(const ShortStepPlane<Real>& p, Acceleration&& acceleration) {
  const Real *now = p.now, *moves = p.moves;
  Real *next = p.next, *position = p.position;
  const Real of_now = p.of_now, of_before = p.of_before, of_acceleration = p.of_acceleration,
             kept = p.last ? Real(0) : Real(1);
  const auto move = [&](std::ptrdiff_t i, Real by) { position[i] += moves ? moves[i] * by : by; };
  if (!now)
    for_numbers(p.count, [&](std::ptrdiff_t i) {
      next[i] = of_acceleration * acceleration(i);
      move(i, kept * next[i]);
    });
  else if (of_before == 0)
    for_numbers(p.count, [&](std::ptrdiff_t i) {
      next[i] = of_now * now[i] + of_acceleration * acceleration(i);
      move(i, kept * next[i] - now[i]);
    });
  else
    for_numbers(p.count, [&](std::ptrdiff_t i) {
      next[i] = of_now * now[i] - of_before * next[i] + of_acceleration * acceleration(i);
      move(i, kept * next[i] - now[i]);
    });
}

template <class Real>
void short_step(const ShortStepPlane<Real>& p) {
  const Real *given = p.acceleration, *mobility = p.mobility, *frozen = p.frozen, *force = p.force;
  if (given)
    displace(p, [=](std::ptrdiff_t i) { return given[i]; });
  else
    displace(p, [=](std::ptrdiff_t i) { return mobility[i] * (frozen[i] + force[i]); });
}

}  // namespace mss::MSS_ISA

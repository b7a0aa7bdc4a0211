#pragma once

#include <cstddef>
#include <iterator>
#include <numeric>
#include <vector>

#include "core/base/record.hpp"
#include "integrators/fixed_step.hpp"

namespace mss {

/// The parts of a symmetric step that begins and ends with a kick: kick, drift, kick, ... from the first half
/// of its coefficients, without those in the middle, two equal kicks about a drift, which make the sums one.
/// Both half kicks between two steps are one, the first.
template <std::size_t N>
std::vector<DriftKick> symmetric_parts(const double (&kicks)[N], const double (&drifts)[N]) {
  const double middle_kick = 0.5 - std::accumulate(kicks, kicks + N, 0.0),
               middle_drift = 1 - 2 * std::accumulate(drifts, drifts + N, 0.0);
  std::vector<DriftKick> parts{{0, 2 * kicks[0]}};
  for (std::size_t i = 1; i < N; ++i) parts.push_back({drifts[i - 1], kicks[i]});
  parts.push_back({drifts[N - 1], middle_kick});
  parts.push_back({middle_drift, middle_kick});
  for (std::size_t i = N; i-- > 1;) parts.push_back({drifts[i], kicks[i]});
  parts.push_back({drifts[0], 0});
  return parts;
}

/// Symmetric compositions of kicks and drifts that begin with a kick; see symmetric_parts(). The acceleration
/// of the last kick is that of the next step's first, so that a step has a force less than kicks.
template <class Real>
class KickFirst : public Integrator<Real> {
 public:
  KickFirst(const std::vector<DriftKick>& parts, double dt) : parts_(parts), dt_(dt) {}

  void reset() override { acceleration_ = Field<Real>(); }
  void remember(System<Real>& system, Record& record) override {
    record.keep_field(acceleration_, system.size());
  }

 private:
  Status do_advance(System<Real>& system, State<Real>& state, double t_end, Work& work) override {
    const StepEvents<Real>* events = system.events();
    const bool collides = events && events->collides();
    return advance_fixed(*this, system, state, dt_, t_end, work, [&](long steps) {
      begin(system, state, work);
      for (long n = 1; n <= steps; ++n) step(system, collides, n == 1, n == steps, state);
      work.force_evaluations += steps * (std::ssize(parts_) - 1);
    });
  }

  void begin(System<Real>& system, const State<Real>& state, Work& work) {
    if (acceleration_.size() > 0) return;
    stage_ = acceleration_ = Field<Real>(system.size());
    system.acceleration(state.t, state.x, state.v, acceleration_);
    ++work.force_evaluations;
  }

  /// Between two steps the closing and the opening kick use the same acceleration, so they fuse with the
  /// force.
  void step(System<Real>& system, bool collides, bool first, bool last, State<Real>& state) {
    const double t = state.t, half = parts_[0].kick / 2 * dt_;
    if (first)
      system.apply({.kick_after = half, .drift_new = parts_[1].drift * dt_}, acceleration_,
                   parts_[1].drift * dt_, state);
    else
      system.kick_drift({.kick_before = half, .kick_after = half, .drift_new = parts_[1].drift * dt_},
                        parts_[1].drift * dt_, 1, state);
    for (std::size_t i = 1; i + 1 < parts_.size(); ++i)
      kick_drift(system, collides, parts_[i].kick * dt_, parts_[i + 1].drift * dt_, state);
    state.t = t + dt_;
    if (!last) return;
    system.acceleration(state.t, state.x, state.v, acceleration_);
    system.apply({.kick_before = half}, acceleration_, 0, state);
  }

  void kick_drift(System<Real>& system, bool collides, double kick, double drift, State<Real>& state) {
    const KickDrift update{.kick_before = kick, .drift_new = drift};
    if (!collides) return system.kick_drift(update, drift, 1, state);
    // What sticks to a plane must not sink within a step, so its acceleration is needed.
    system.acceleration(state.t, state.x, state.v, stage_);
    system.apply(update, stage_, drift, state);
  }

  const std::vector<DriftKick>& parts_;
  double dt_;
  Field<Real> acceleration_;  ///< at the end of the last step; empty before the first
  Field<Real> stage_;
};

}  // namespace mss

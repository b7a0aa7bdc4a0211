#pragma once

#include <fmt/format.h>

#include <array>
#include <memory>
#include <string>

#include "core/base/error.hpp"
#include "core/base/record.hpp"
#include "integrators/fixed_step.hpp"
#include "integrators/position_based/coloured_particles.hpp"

namespace mss {

/// The springs that a system drives. Throws InputError if it drives something else.
template <class Real>
const SpringSystem<Real>& springs_for(System<Real>& system, const std::string& method);

/// Throws InputError if a method of regions of cells has none in a body.
void check_regions(const BodyConfig& body, const std::string& method);

/// Throws InputError if a method that solves for springs and volumes one by one has no solution for a body's.
void check_local_solutions(const BodyConfig& body, const std::string& method);

/// The accelerations of a body in its environment by everything but springs and volumes.
template <class Real>
class OuterAcceleration {
 public:
  /// Both must outlive it; `system` is `springs`, or wraps it.
  OuterAcceleration(const SpringSystem<Real>& springs, System<Real>& system);

  /// Whether they change from step to step.
  bool varies() const { return is_wrapped_ || loads_vary_ || springs_.contact().has_penalties(); }

  /// At this state; valid until the next call.
  const Field<Real>& at(const State<Real>& state);

 private:
  void add_wrapper(const State<Real>& state);

  const SpringSystem<Real>& springs_;
  System<Real>& system_;
  bool is_wrapped_, loads_vary_;
  Field<Real> sum_;
  std::unique_ptr<SpringSystem<Real>> own_;  ///< to tell what a wrapper adds
  Field<Real> alone_, whole_;
};

/// A method whose steps are passes over the particles of a lattice, in a layout of its own: `Passes` has
/// begin_step(), iterate(), iterate_into_next_step() and particles(), see ColouredParticles, remember(),
/// reset() if it keeps a history, and where the system has bounds end_passes() and rebound(), which keep
/// particles in front of them.
template <class Real, class Passes>
class PositionBasedIntegrator final : public Integrator<Real> {
 public:
  /// Makes passes when the first step begins; may throw InputError.
  using MakePasses = std::unique_ptr<Passes> (*)(const SpringSystem<Real>&, System<Real>&,
                                                 const IntegratorOptions&);

  PositionBasedIntegrator(const IntegratorOptions& options, std::string name, MakePasses make_passes)
      : options_(options),
        name_(std::move(name)),
        make_passes_(make_passes),
        iterations_(std::max(1, options.iterations)) {}

  void reset() override {
    if constexpr (requires { passes_->reset(); })
      if (passes_) passes_->reset();
  }

  void remember(System<Real>& system, Record& record) override {
    bool has_begun = passes_ != nullptr;
    record.keep(has_begun);
    if (has_begun && !passes_) begin(system);
    if (has_begun) record.keep(*passes_);
  }

  Status do_advance(System<Real>& system, State<Real>& state, double t_end, Work& work) override {
    if (!passes_) begin(system);
    return advance_fixed(*this, system, state, options_.dt, t_end, work, [&](long steps) {
      work.force_evaluations += steps * iterations_;
      if (holds_move_ || outer_->varies() || system.bounds())
        for (long n = 0; n < steps; ++n) take_steps(system, state, 1);
      else
        take_steps(system, state, steps);
    });
  }

 private:
  void begin(System<Real>& system) {
    springs_ = &springs_for(system, name_);
    passes_ = make_passes_(*springs_, system, options_);
    outer_ = std::make_unique<OuterAcceleration<Real>>(*springs_, system);
    holds_move_ = springs_->held().move(0, 0, springs_->body().lattice().sites);
  }

  /// Steps during which outer accelerations do not change, and only one if holds move.
  void take_steps(System<Real>& system, State<Real>& state, long steps) {
    auto& particles = passes_->particles();
    if (!knows_accelerations_ || outer_->varies()) particles.load_acceleration(outer_->at(state));
    knows_accelerations_ = true;
    particles.load_state(state);
    passes_->begin_step(state.t);
    if (holds_move_) follow_holds(system, state);
    for (long n = 0; n < steps; ++n) {
      for (int i = 1; i < iterations_; ++i) passes_->iterate();
      if (n + 1 < steps)
        passes_->iterate_into_next_step();
      else
        passes_->iterate();
    }
    passes_->end_passes();
    particles.finish(options_.dt);
    particles.store_state(state);
    passes_->rebound(state);
    for (long n = 0; n < steps; ++n) state.t += options_.dt;  // the same bits however steps are taken
    system.constrain(state.t, state.x, state.v);
  }

  /// Held coordinates go where they belong at the end of the step.
  void follow_holds(const System<Real>& system, const State<Real>& state) {
    end_ = state;
    system.constrain(state.t + options_.dt, end_.x, end_.v);
    for (const std::ptrdiff_t site : system.particles())
      for (int axis = 0; axis < 3; ++axis)
        if (springs_->held().holds(site, axis))
          passes_->particles().set_displacement(site, axis,
                                                end_.x.axis(axis)[site] - state.x.axis(axis)[site]);
  }

  IntegratorOptions options_;
  std::string name_;
  MakePasses make_passes_;
  int iterations_;
  const SpringSystem<Real>* springs_ = nullptr;
  std::unique_ptr<Passes> passes_;
  std::unique_ptr<OuterAcceleration<Real>> outer_;
  bool holds_move_ = false, knows_accelerations_ = false;
  State<Real> end_;
};

}  // namespace mss

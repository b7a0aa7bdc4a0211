// What planes change in iterations of quasi-Newton methods: they hold particles as an active set says
// (bounded_system.hpp), which changes between iterations.
#include <algorithm>
#include <cmath>
#include <limits>

#include "integrators/nonlinear/bounded_system.hpp"
#include "integrators/nonlinear/quasi_newton.hpp"

namespace mss {

namespace {

/// Of what is left to solve, to what planes push with: then that is known, and friction follows it, or after
/// so many iterations.
constexpr double trusted = 0.3;
constexpr int most_without_pressure = 15;

/// After so many changes of what planes hold in a stage the rest is solved, to that share of what it was,
/// before there is another one: then they cannot go round in circles.
constexpr int most_hasty_changes = 12;
constexpr double solved = 1e-3;

}  // namespace

void QuasiNewton::end_step(const StepTaken& step, State<double>& state, Field<double>* a) {
  if (bounded_) bounded_->end_step(step, state, a);
}

void QuasiNewton::make_bounded(System<double>& system) {
  bounded_ = std::make_shared<BoundedSystem>(system);
  jump_ = impulse_ = gradient_;
}

void QuasiNewton::begin_contact(State<double>& state) {
  jumps_ = bounded_->jump(state.v, jump_);
  norm_at_pressure_ = std::numeric_limits<double>::infinity();
  since_pressure_ = 0;
  changes_ = 0;
}

/// A jump to planes, and the first step after what planes hold has changed, are taken whole.
bool QuasiNewton::take_step(System<double>& system, const ImplicitStage& stage, State<double>& state,
                            Work& work) {
  if (!jumps_ && settled_) return search(system, stage, state, work);
  move(system, stage, state, 1);
  length_ = 0;
  evaluate(system, stage, state, work);
  return std::isfinite(norm_);
}

/// The gradient with friction, without what holds particles.
void QuasiNewton::leave_out_held(System<double>& system, const State<double>& state) {
  gradient_.array() = impulse_.array();
  bounded_->add_friction(state.v, gradient_);
  gradient_.array() = -gradient_.array();
  system.clear_prescribed(gradient_);
  measure_gradient(system);
}

/// Changes what planes hold after a step, and friction once the rest is solved for that of before: if it
/// followed every iteration, sliding would diverge. True if the rest is a function that has not changed.
bool QuasiNewton::update_contact(System<double>& system, State<double>& state, double good) {
  const bool jumped = jumps_;
  if (changes_ >= most_hasty_changes && norm_ > std::max(good, solved * norm_at_change_)) {
    jumps_ = bounded_->jump(state.v, jump_);
    if (jumps_) forget_steps();
    return !jumped && !jumps_;
  }
  const bool changed = bounded_->update(impulse_, state.v, norm_);
  const double friction = follow_pressure(good);
  if (changed || friction > good) cycle_->hold(bounded_->held(state.v));
  jumps_ = bounded_->jump(state.v, jump_);
  if (!changed && !jumps_ && friction <= good) return !jumped;
  forget_steps();
  leave_out_held(system, state);
  ++changes_;
  norm_at_change_ = norm_;
  return false;
}

/// Lets friction follow the pressure where that is known well enough; by how much it changes [N s].
double QuasiNewton::follow_pressure(double good) {
  ++since_pressure_;
  if (!bounded_->slides()) return 0;
  const bool known = norm_ < trusted * std::min(norm_at_pressure_, bounded_->push()) || norm_ <= good;
  if (!known && since_pressure_ < most_without_pressure) return 0;
  const double friction = bounded_->follow_pressure();
  norm_at_pressure_ = std::max(norm_, friction);
  since_pressure_ = 0;
  return friction;
}

/// Whether what planes push with is known well enough for an iteration to count.
bool QuasiNewton::knows_push() const {
  return !bounded_ || bounded_->touching() == 0 || norm_ < trusted * bounded_->push();
}

/// Where iterations end before contacts have settled: planes stop what is behind them, at once.
void QuasiNewton::put_in_front(System<double>& system, const ImplicitStage& stage, State<double>& state) {
  jump_ = state.v;
  bounded_->put_in_front(state.v);
  impulse_.array() -= mass_.array() * (state.v.array() - jump_.array());
  state.x.array() = stage.x_base->array() + stage.gamma_x * state.v.array();
  system.constrain(stage.t, state.x, state.v);
}

}  // namespace mss

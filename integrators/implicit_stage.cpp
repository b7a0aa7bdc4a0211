// Newton's method: (M + gamma C + gamma^2 K) dv = gamma f - M (v - v_base), halving steps that do not reduce
// the residual. With the projected tangent every direction is one of descent, at the price of slower
// convergence where springs are strongly pressed. Nocedal and Wright, Numerical Optimization, chapter 11.
#include "integrators/implicit_stage.hpp"

#include <cmath>

namespace mss {

namespace {

constexpr int most_iterations = 60;
constexpr double shortest_step = 1.0 / 4096;

/// Moves below this share of the coordinates are rounding.
constexpr double negligible = 1e-14;

}  // namespace

Newton::Newton(const IntegratorOptions& options)
    : tolerance_(options.newton_tolerance),
      kind_(options.tangent),
      linear_(find_linear_solver(options.linear_solver).make(options.linear_tolerance)) {}

/// Places x and prescribed coordinates for state.v, fills residual_ and returns its norm.
double Newton::residual(System<double>& system, const ImplicitStage& stage, State<double>& state,
                        Work& work) {
  state.x.array() = stage.x_base->array() + stage.gamma * state.v.array();
  system.constrain(stage.t, state.x, state.v);
  system.force(stage.t, state.x, state.v, residual_);
  ++work.force_evaluations;
  for (int axis = 0; axis < 3; ++axis) {
    double* r = residual_.axis(axis);
    const double *v = state.v.axis(axis), *v_base = stage.v_base->axis(axis);
    for (const std::ptrdiff_t i : system.particles())
      r[i] = stage.gamma * r[i] - system.mass(i) * (v[i] - v_base[i]);
  }
  system.clear_prescribed(residual_);
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (const std::ptrdiff_t i : system.particles())
      sum += residual_.axis(axis)[i] * residual_.axis(axis)[i];
  return std::sqrt(sum);
}

/// Takes the longest of the steps 1, 1/2, 1/4 ... that reduces the residual.
bool Newton::search(System<double>& system, const ImplicitStage& stage, State<double>& state, double& norm,
                    Work& work) {
  trial_ = state.v;
  for (double length = 1; length >= shortest_step; length /= 2) {
    state.v.array() = trial_.array() + length * step_.array();
    const double shorter = residual(system, stage, state, work);
    if (shorter <= (1 - 1e-4 * length) * norm) {  // false for NaN
      norm = shorter;
      return true;
    }
  }
  state.v = trial_;
  norm = residual(system, stage, state, work);
  return false;
}

double Newton::largest_move(const ImplicitStage& stage) const {
  return stage.gamma * step_.array().abs().maxCoeff();
}

Status Newton::solve(System<double>& system, const ImplicitStage& stage, State<double>& state, Work& work) {
  if (residual_.size() == 0)
    for (Field<double>* field : {&residual_, &step_, &trial_}) *field = Field<double>(system.size());
  double norm = residual(system, stage, state, work);
  if (!std::isfinite(norm)) return Status::non_finite;
  const double target = tolerance_ * norm;
  for (int iteration = 0; iteration < most_iterations && norm > 0; ++iteration) {
    const TangentSum sum{
        .mass = 1, .damping = stage.gamma, .stiffness = stage.gamma * stage.gamma, .kind = kind_};
    Status status = linear_->prepare(system, stage.t, state.x, state.v, sum, work);
    if (status == Status::ok) status = linear_->solve(residual_, step_, work);
    if (status != Status::ok) return status;
    const bool rounding = largest_move(stage) <= negligible * state.x.array().abs().maxCoeff();
    if (!search(system, stage, state, norm, work)) return rounding ? Status::ok : Status::newton_stalled;
    if (rounding || norm <= target) return Status::ok;
  }
  return norm > target ? Status::newton_stalled : Status::ok;
}

}  // namespace mss

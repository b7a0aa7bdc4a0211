// Newton's method: (M + gamma C + gamma gamma_x K) dv = r = gamma f - M (v - v_base). Where damping is off, r
// is minus the gradient of an energy, and dv, from a positive definite matrix, is a descent direction: so a
// step is halved if the slope r.dv has turned against it by more than half of what it was. This needs no
// energy, and, unlike a decrease of |r|, which projected tangents do not guarantee, it does not stall.
// Nocedal and Wright, Numerical Optimization, chapter 3.
//
// A step that conserves energy has another force than K and C belong to; its own tangent is unsymmetric. With
// the projected ones at its midpoint the iteration converges linearly, by a factor of about ten where springs
// turn by a few tenths of a radian a step.
#include "integrators/nonlinear/implicit_stage.hpp"

#include <cmath>
#include <limits>

#include "core/base/record.hpp"
#include "core/base/suggest.hpp"
#include "core/springs/discrete_gradient.hpp"
#include "integrators/nonlinear/bounded_system.hpp"

namespace mss {

namespace {

/// Of the residual, to that before the first iteration.
constexpr double tolerance = 1e-10;

constexpr int most_halvings = 12;

/// Where friction acts, which has no energy, so that no step may seem short enough.
constexpr int most_halvings_sliding = 6;

/// Solves with one matrix for friction to follow pressure, and the largest share of the residual that may be
/// left of that.
constexpr int most_friction_rounds = 12;
constexpr double most_friction_left = 0.01;

/// Where a stage with contact has stalled, it is solved once more: from projected tangents, with friction
/// that follows pressure only when what is left to solve is this share of what planes push with.
constexpr double trusted = 0.3;
constexpr int most_careful = 300;

/// Of gravity's impulse: a change of friction that leaves a stage solved.
constexpr double negligible_friction = contact_tolerance / 10;

/// When a stage counts as solved.
struct Goal {
  int most_iterations;
  double negligible;    ///< moves below this share of the coordinates are rounding
  int idle_iterations;  ///< that a small residual must have stayed as large as it was
};
constexpr Goal ordinary{.most_iterations = 60, .negligible = 1e-14, .idle_iterations = 0};
/// Where what remains is energy: until rounding lets neither moves nor residuals become smaller.
constexpr Goal conserving{.most_iterations = 200, .negligible = 1e-16, .idle_iterations = 3};

/// Where planes hold particles, whose tolerance is a share of the body's weight and not of a residual that
/// may be its stiffness.
constexpr double negligible_in_contact = 1e-12;

/// An iteration that leaves more than this share of the residual is idle.
constexpr double reduced = 0.9;

double dot(const System<double>& system, const Field<double>& a, const Field<double>& b) {
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (const std::ptrdiff_t i : system.particles()) sum += a.axis(axis)[i] * b.axis(axis)[i];
  return system.ranks().sum(sum);
}

}  // namespace

void stage_force(System<double>& system, const ImplicitStage& stage, const State<double>& state,
                 Field<double>& x_end, Field<double>& force) {
  system.force(stage.t, state.x, stage.force_velocity ? *stage.force_velocity : state.v, force);
  if (!stage.conserve_from) return;
  if (x_end.size() == 0) x_end = Field<double>(system.size());
  x_end.array() = 2 * state.x.array() - stage.conserve_from->array();
  discrete_gradient_of(system).correct(*stage.conserve_from, x_end, force);
}

void free_acceleration(System<double>& system, double t, const Field<double>& x, const Field<double>& v,
                       double seconds, Field<double>& a) {
  if (!system.bounds()) {
    system.acceleration(t, x, v, a);
    return kicked_for(system, seconds);
  }
  system.force(t, x, v, a);
  for (const std::ptrdiff_t site : system.particles()) a.set(site, a.at(site) / system.mass(site));
  system.clear_prescribed(a);
}

Newton::Newton(const IntegratorOptions& options)
    : kind_(options.tangent),
      iterations_(options.iterations),
      linear_(find_linear_solver(options.linear_solver).make(options.linear_tolerance)) {}
Newton::~Newton() = default;

void Newton::end_step(const StepTaken& step, State<double>& state, Field<double>* a) {
  if (bounded_) bounded_->end_step(step, state, a);
}

void Newton::remember(System<double>& system, Record& record) { remember_bounded(system, record, bounded_); }

/// Places x and prescribed coordinates for state.v, fills residual_ and returns its norm.
double Newton::residual(System<double>& system, const ImplicitStage& stage, State<double>& state,
                        Work& work) {
  state.x.array() = stage.x_base->array() + stage.gamma_x * state.v.array();
  system.constrain(stage.t, state.x, state.v);
  stage_force(system, stage, state, x_end_, residual_);
  ++work.force_evaluations;
  for (int axis = 0; axis < 3; ++axis) {
    double* r = residual_.axis(axis);
    const double *v = state.v.axis(axis), *v_base = stage.v_base->axis(axis);
    for (const std::ptrdiff_t i : system.particles())
      r[i] = stage.gamma * r[i] - system.mass(i) * (v[i] - v_base[i]);
  }
  if (bounded_) impulse_ = residual_;
  return leave_out_held(system, state);
}

/// Adds friction to the residual, removes what holds particles, and returns its norm.
double Newton::leave_out_held(const System<double>& system, const State<double>& state) {
  if (bounded_) {
    residual_ = impulse_;
    bounded_->add_friction(state.v, residual_);
  }
  system.clear_prescribed(residual_);
  return std::sqrt(dot(system, residual_, residual_));
}

/// The step from the tangent where the body is; with a jump to planes, that and what it leaves to the rest.
/// Friction is that of the pressure after the step, found by solving again with the same matrix: with that of
/// before, sliding would converge linearly; found to a share of the residual that shrinks as iterations
/// converge (Eisenstat and Walker, SIAM J. Sci. Comput. 17 (1996) 16) it takes none more.
Status Newton::find_step(System<double>& system, const ImplicitStage& stage, const State<double>& state,
                         Work& work) {
  TangentCoefficients sum{.mass = 1,
                          .damping = stage.force_velocity ? 0 : stage.gamma,
                          .stiffness = stage.gamma * stage.gamma_x,
                          .kind = stage.conserve_from || careful_ ? Tangent::projected : kind_};
  if (!bounded_)
    return solve_tangent(*linear_, system, stage.t, state.x, state.v, sum, residual_, step_, work);
  const auto product = [&](const Field<double>& move) {
    tangents_of(bounded_->unbounded()).product(stage.t, state.x, state.v, sum, move, expected_);
    ++work.products;
  };
  if (jumps_) {
    product(jump_);
    residual_.array() -= expected_.array();
    system.clear_prescribed(residual_);
  }
  Status status = solve_tangent(*linear_, system, stage.t, state.x, state.v, sum, residual_, step_, work);
  double change = std::numeric_limits<double>::max();
  for (int round = 0; status == Status::ok && !careful_ && round < most_friction_rounds && bounded_->slides();
       ++round) {
    system.clear_prescribed(step_);
    if (jumps_) step_.array() += jump_.array();
    product(step_);
    expected_.array() = impulse_.array() - expected_.array();
    const double before = std::sqrt(dot(system, residual_, residual_));
    const double last = change;
    change = bounded_->expect_pressure(expected_, last, residual_);
    const double enough = std::max(friction_left_ * before, negligible_friction * bounded_->scale());
    if (change > last || change <= enough) return status;
    status = linear_->solve(residual_, step_, work);
  }
  system.clear_prescribed(step_);
  if (jumps_) step_.array() += jump_.array();
  return status;
}

/// False if no part of the step makes things better. A jump, and the first step after what planes hold has
/// changed, are taken whole: then the residual is another function.
bool Newton::take_step(System<double>& system, const ImplicitStage& stage, State<double>& state, double& norm,
                       bool settled, Work& work) {
  if (!jumps_ && settled) return search(system, stage, state, norm, work);
  state.v.array() += step_.array();
  norm = residual(system, stage, state, work);
  return std::isfinite(norm);
}

/// Takes the longest of the steps 1, 1/2, 1/4 ... that does not overshoot.
bool Newton::search(System<double>& system, const ImplicitStage& stage, State<double>& state, double& norm,
                    Work& work) {
  v_before_ = state.v;
  const double slope = dot(system, residual_, step_);
  for (int halvings = 0; halvings <= most_halvings; ++halvings) {
    const double length = std::ldexp(1.0, -halvings);
    state.v.array() = v_before_.array() + length * step_.array();
    norm = residual(system, stage, state, work);
    if (std::isfinite(norm) && dot(system, residual_, step_) >= -slope / 2) return true;
    if (bounded_ && halvings == most_halvings_sliding) return std::isfinite(norm);
  }
  return false;
}

/// Lets friction follow pressure once the rest is solved for that of before; true if it changed.
bool Newton::follow_once_solved(double norm, double good) {
  if (!bounded_->slides() || (norm >= trusted * std::min(norm_at_pressure_, bounded_->push()) && norm > good))
    return false;
  const double change = bounded_->follow_pressure();
  norm_at_pressure_ = std::max(norm, change);
  return change > good;
}

/// The largest change of a coordinate that the step makes, over the largest coordinate.
double Newton::relative_move(const System<double>& system, const ImplicitStage& stage,
                             const State<double>& state) const {
  const double move = stage.gamma_x * system.ranks().largest(step_.array().abs().maxCoeff());
  return move / system.ranks().largest(state.x.array().abs().maxCoeff());
}

Status Newton::solve(System<double>& system, const ImplicitStage& stage, State<double>& state, Work& work) {
  if (system.bounds()) guess_ = state.v;
  careful_ = false;
  Status status = solve_stage(system, stage, state, work);
  if (status != Status::ok && bounded_ && iterations_ == 0) {
    state.v = guess_;
    bounded_->let_go();
    careful_ = true;
    status = solve_stage(system, stage, state, work);
    if (status != Status::ok) status = Status::newton_stalled;  // whatever the last iterate was
  }
  if (status == Status::ok && bounded_) bounded_->end_stage(stage, impulse_);
  return status;
}

Status Newton::solve_stage(System<double>& plain, const ImplicitStage& stage, State<double>& state,
                           Work& work) {
  tangents_of(plain);  // throws if there are none, even where nothing moves
  if (residual_.size() == 0)
    for (Field<double>* field : {&residual_, &step_, &v_before_}) *field = Field<double>(plain.size());
  if (plain.bounds() && !bounded_) bounded_ = std::make_shared<BoundedSystem>(plain);
  if (bounded_ && jump_.size() == 0) jump_ = impulse_ = expected_ = residual_;
  System<double>& system = bounded_ ? *bounded_ : plain;
  if (bounded_) {
    bounded_->begin(stage);
    jumps_ = bounded_->jump(state.v, jump_);
  }
  double norm = residual(system, stage, state, work), least = norm;
  if (!std::isfinite(norm)) return Status::non_finite;
  const auto goal = [&] {  // what slides conserves no energy
    return stage.conserve_from && !(bounded_ && bounded_->slides()) ? conserving : ordinary;
  };
  const double good = std::max(tolerance * norm, bounded_ ? contact_tolerance * bounded_->scale() : 0);
  const double target = iterations_ > 0 ? 0 : good;
  const int most = iterations_ > 0 ? iterations_ : careful_ ? most_careful : goal().most_iterations;
  norm_at_pressure_ = std::numeric_limits<double>::infinity();
  bool settled = !bounded_;  // what planes hold
  friction_left_ = most_friction_left;
  for (int iteration = 0, idle = 0; iteration < most && (norm > 0 || !settled); ++iteration) {
    const Status status = find_step(system, stage, state, work);
    if (status != Status::ok) return status;
    const double move = relative_move(system, stage, state), before = norm;
    const bool jumped = jumps_;
    if (!take_step(system, stage, state, norm, settled, work))
      return settled && (move <= ordinary.negligible || before <= good) ? Status::ok : Status::newton_stalled;
    if (bounded_) {
      settled = !bounded_->update(impulse_, state.v, norm) && !jumped;
      if (!careful_)
        bounded_->follow_pressure();
      else if (follow_once_solved(norm, good))
        settled = false;
      jumps_ = bounded_->jump(state.v, jump_);
      norm = leave_out_held(system, state);
      friction_left_ = std::min(most_friction_left, std::pow(norm / before, 2) / 10);
      if (!settled || jumps_) continue;
    }
    const bool near = norm <= target || move <= (bounded_ ? negligible_in_contact : ordinary.negligible);
    idle = !near || norm < reduced * least ? 0 : idle + 1;
    least = std::min(least, norm);
    if (move <= goal().negligible || (near && idle >= goal().idle_iterations)) return Status::ok;
  }
  if (iterations_ > 0 && bounded_) {
    bounded_->put_in_front(state.v);
    norm = residual(system, stage, state, work);
  }
  return iterations_ > 0 || (settled && norm <= 0) ? Status::ok : Status::newton_stalled;
}

NonlinearSolverInfo newton() {
  return {.name = "newton",
          .summary =
              "Newton's method: the tangent, assembled or not, and a linear solver; any model, converges "
              "quadratically",
          .make = [](const IntegratorOptions& o) { return std::make_unique<Newton>(o); }};
}

const NonlinearSolverInfo& find_nonlinear_solver(std::string_view name) {
  return find_named(nonlinear_solvers(), name, "nonlinear solver", "nonlinear_solvers");
}

std::unique_ptr<NonlinearSolver> make_nonlinear_solver(const IntegratorOptions& options) {
  return find_nonlinear_solver(options.nonlinear_solver).make(options);
}

}  // namespace mss

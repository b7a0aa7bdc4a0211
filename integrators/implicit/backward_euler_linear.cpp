// Backward Euler with one linear solve a step:
//   (M + dt C + dt^2 K) dv = dt (f(x_n, v_n) - dt K v_n),   v_{n+1} = v_n + dv,   x_{n+1} = x_n + dt v_{n+1},
// with C and K at the beginning of the step. First order, stable for any step on the test equation; strongly
// bent bodies can still diverge, because there is only one linearisation.
// Prescribed coordinates get their new values before forces are evaluated, so that they act on the others.
// Contact: the active set of bounded_system.hpp on the linear model, a solve for every set.
// Baraff and Witkin, SIGGRAPH 1998.
#include "integrators/nonlinear/bounded_system.hpp"
#include "integrators/nonlinear/implicit_stage.hpp"

namespace mss {

namespace {

class BackwardEulerLinear final : public Integrator<double> {
 public:
  explicit BackwardEulerLinear(const IntegratorOptions& options)
      : dt_(options.dt),
        kind_(options.tangent),
        linear_(find_linear_solver(options.linear_solver).make(options.linear_tolerance)) {}

  Status do_advance(System<double>& system, State<double>& state, double t_end, Work& work) override {
    return advance_step_by_step(*this, system, state, dt_, t_end, work,
                                [&] { return step(system, state, work); });
  }

  void remember(System<double>& system, Record& record) override {
    remember_bounded(system, record, bounded_);
  }

 private:
  Status step(System<double>& system, State<double>& state, Work& work) {
    if (rhs_.size() == 0)
      for (Field<double>* field : {&rhs_, &product_, &change_}) *field = Field<double>(system.size());
    const double t = state.t + dt_;
    system.constrain(t, state.x, state.v);
    system.force(t, state.x, state.v, rhs_);
    ++work.force_evaluations;
    change_ = state.v;
    system.clear_prescribed(change_);
    tangents_of(system).product(t, state.x, state.v, {.stiffness = dt_, .kind = kind_}, change_, product_);
    ++work.products;
    rhs_.array() = dt_ * (rhs_.array() - product_.array());
    const TangentCoefficients sum{.mass = 1, .damping = dt_, .stiffness = dt_ * dt_, .kind = kind_};
    x_before_ = state.x;
    v_before_ = state.v;
    const Status status =
        system.bounds() ? solve_with_bounds(system, t, state, sum, work)
                        : solve_tangent(*linear_, system, t, state.x, state.v, sum, rhs_, change_, work);
    if (status != Status::ok) return status;
    state.v.array() += change_.array();
    state.x.array() += dt_ * state.v.array();
    if (bounded_)
      bounded_->end_step({.free = {.dt = dt_, .drift = 1}, .x = &x_before_, .v = &v_before_}, state, nullptr);
    state.t = t;
    system.constrain(t, state.x, state.v);
    return Status::ok;
  }

  /// Solves again for what planes hold by the last solution, until that is what it was.
  Status solve_with_bounds(System<double>& system, double t, const State<double>& state,
                           TangentCoefficients sum, Work& work) {
    constexpr int most_rounds = 60;
    constexpr double tolerance = 1e-10;
    if (!bounded_) bounded_ = std::make_shared<BoundedSystem>(system);
    const ImplicitStage stage{
        .t = t, .gamma = dt_, .x_base = &state.x, .v_base = &state.v, .impulse_weight = 1};
    bounded_->begin(stage);
    velocity_ = state.v;
    jump_ = residual_ = product_ = rhs_;
    leave_to_solve(system, t, state, sum, work);
    bool stale = true;  // the matrix; friction that follows pressure does with that of its set
    for (int round = 0; round < most_rounds; ++round) {
      const bool jumps = bounded_->jump(velocity_, jump_);
      bounded_->add_friction(velocity_, residual_);
      if (jumps) {
        tangents_of(system).product(t, state.x, state.v, sum, jump_, product_);
        ++work.products;
        residual_.array() -= product_.array();
      }
      bounded_->clear_prescribed(residual_);
      Status status =
          stale ? prepare_definite(*linear_, *bounded_, t, state.x, velocity_, sum, work) : Status::ok;
      if (status == Status::ok) status = linear_->solve(residual_, change_, work);
      if (status == Status::not_positive_definite && sum.kind != Tangent::projected) {
        sum.kind = Tangent::projected;
        leave_to_solve(system, t, state, sum, work);
        stale = true;
        continue;
      }
      if (status != Status::ok) return status;
      bounded_->clear_prescribed(change_);
      const double move = system.ranks().largest(change_.array().abs().maxCoeff());
      velocity_.array() += change_.array();
      if (jumps) velocity_.array() += jump_.array();
      leave_to_solve(system, t, state, sum, work);
      const bool changed = bounded_->update(residual_, velocity_);
      const double friction = bounded_->follow_pressure();
      stale = changed || move > bounded_->slowest(velocity_) / 10;
      if (changed || friction > tolerance * std::max(bounded_->scale(), bounded_->push())) continue;
      bounded_->end_stage(stage, residual_);
      change_.array() = velocity_.array() - state.v.array();
      return Status::ok;
    }
    return Status::newton_stalled;
  }

  /// What the linear model leaves of its right-hand side at velocity_.
  void leave_to_solve(System<double>& system, double t, const State<double>& state,
                      const TangentCoefficients& sum, Work& work) {
    change_.array() = velocity_.array() - state.v.array();
    tangents_of(system).product(t, state.x, state.v, sum, change_, product_);
    ++work.products;
    residual_.array() = rhs_.array() - product_.array();
  }

  double dt_;
  Tangent kind_;
  std::unique_ptr<LinearSolver> linear_;
  Field<double> rhs_, product_, change_;
  std::shared_ptr<BoundedSystem> bounded_;  ///< the system where it has bounds
  Field<double> x_before_, v_before_, velocity_, jump_, residual_;
};

}  // namespace

IntegratorInfo backward_euler_linear() {
  return describe_double<BackwardEulerLinear>(
      {.name = "backward_euler_linear",
       .summary =
           "implicit Euler with one linear solve a step (Baraff and Witkin): first order, loses energy",
       .order_undamped = 1,
       .order_damped = 1,
       .implicit = true,
       .collisions = Collisions::inside_steps,
       .relaxes = true});
}

}  // namespace mss

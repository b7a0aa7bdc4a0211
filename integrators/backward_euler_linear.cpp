// Backward Euler with one linear solve a step:
//   (M + dt C + dt^2 K) dv = dt (f(x_n, v_n) - dt K v_n),   v_{n+1} = v_n + dv,   x_{n+1} = x_n + dt v_{n+1},
// with C and K at the beginning of the step. First order, stable for any step on the test equation; strongly
// bent bodies can still diverge, because there is only one linearisation.
// Prescribed coordinates get their new values before forces are evaluated, so that they act on the others.
// Baraff and Witkin, SIGGRAPH 1998.
#include "integrators/implicit_stage.hpp"

namespace mss {

namespace {

class BackwardEulerLinear final : public Integrator<double> {
 public:
  explicit BackwardEulerLinear(const IntegratorOptions& options)
      : dt_(options.dt),
        kind_(options.tangent),
        linear_(find_linear_solver(options.linear_solver).make(options.linear_tolerance)) {}

  Status advance(System<double>& system, State<double>& state, double t_end, Work& work) override {
    return advance_step_by_step(*this, system, state, dt_, t_end, work,
                                [&] { return step(system, state, work); });
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
    const TangentSum sum{.mass = 1, .damping = dt_, .stiffness = dt_ * dt_, .kind = kind_};
    const Status status = solve_tangent(*linear_, system, t, state.x, state.v, sum, rhs_, change_, work);
    if (status != Status::ok) return status;
    state.v.array() += change_.array();
    state.x.array() += dt_ * state.v.array();
    state.t = t;
    system.constrain(t, state.x, state.v);
    return Status::ok;
  }

  double dt_;
  Tangent kind_;
  std::unique_ptr<LinearSolver> linear_;
  Field<double> rhs_, product_, change_;
};

}  // namespace

IntegratorInfo backward_euler_linear() {
  return describe_double<BackwardEulerLinear>(
      {.name = "backward_euler_linear",
       .summary =
           "implicit Euler with one linear solve a step (Baraff and Witkin): first order, loses energy",
       .order_undamped = 1,
       .order_damped = 1,
       .implicit = true});
}

}  // namespace mss

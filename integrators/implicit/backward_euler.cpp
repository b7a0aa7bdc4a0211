// Backward (implicit) Euler, thesis eq. 2-13, solved to convergence by Newton's method:
//   v_{n+1} = v_n + dt M^-1 f(x_{n+1}, v_{n+1}),   x_{n+1} = x_n + dt v_{n+1}.
// First order, stable for any step on the test equation; loses energy.
#include "integrators/nonlinear/implicit_stage.hpp"

namespace mss {

namespace {

class BackwardEuler final : public Integrator<double> {
 public:
  explicit BackwardEuler(const IntegratorOptions& options)
      : dt_(options.dt), solver_(make_nonlinear_solver(options)) {}

  Status do_advance(System<double>& system, State<double>& state, double t_end, Work& work) override {
    return advance_step_by_step(*this, system, state, dt_, t_end, work, [&] {
      x_ = state.x;
      v_ = state.v;
      const Status status = solver_->solve(
          system, {.t = state.t + dt_, .gamma = dt_, .x_base = &x_, .v_base = &v_, .impulse_weight = 1},
          state, work);
      if (status != Status::ok) return status;
      solver_->end_step({.free = {.dt = dt_, .drift = 1}, .x = &x_, .v = &v_}, state, nullptr);
      state.t += dt_;
      return status;
    });
  }

  void remember(System<double>& system, Record& record) override { solver_->remember(system, record); }

 private:
  double dt_;
  std::unique_ptr<NonlinearSolver> solver_;
  Field<double> x_, v_;  ///< at the beginning of the step
};

}  // namespace

IntegratorInfo backward_euler() {
  return describe_double<BackwardEuler>(
      {.name = "backward_euler",
       .summary = "implicit Euler (2-13) by Newton's method: first order, any step, loses energy",
       .order_undamped = 1,
       .order_damped = 1,
       .implicit = true,
       .collisions = Collisions::inside_steps,
       .relaxes = true,
       .iterates = true,
       .variants = {"/lbfgs:5"}});
}

}  // namespace mss

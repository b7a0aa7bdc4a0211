// Implicit midpoint rule:
//   X = x_n + dt/2 V,   M (V - v_n) = dt/2 f(t + dt/2, X, V),   x_{n+1} = 2 X - x_n,   v_{n+1} = 2 V - v_n.
// Second order, damped or not; symplectic and time-reversible without damping; stable for any step on the
// test equation, where it neither gains nor loses energy. Hairer, Lubich and Wanner, Geometric Numerical
// Integration, II.1.
#include "integrators/nonlinear/implicit_stage.hpp"

namespace mss {

namespace {

class ImplicitMidpoint final : public Integrator<double> {
 public:
  explicit ImplicitMidpoint(const IntegratorOptions& options)
      : dt_(options.dt), solver_(make_nonlinear_solver(options)) {}

  Status do_advance(System<double>& system, State<double>& state, double t_end, Work& work) override {
    return advance_step_by_step(*this, system, state, dt_, t_end, work, [&] {
      x_ = state.x;
      v_ = state.v;
      const double half = dt_ / 2;
      const Status status = solver_->solve(system,
                                           {.t = state.t + half,
                                            .gamma = half,
                                            .x_base = &x_,
                                            .v_base = &v_,
                                            .bound_base = &x_,
                                            .bound_gamma = dt_,
                                            .impulse_weight = 2},
                                           state, work);
      if (status != Status::ok) return status;
      state.x.array() = 2 * state.x.array() - x_.array();
      state.v.array() = 2 * state.v.array() - v_.array();
      solver_->end_step({.free = {.dt = dt_, .drift = 0.5}, .x = &x_, .v = &v_}, state, nullptr);
      state.t += dt_;
      system.constrain(state.t, state.x, state.v);
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

IntegratorInfo implicit_midpoint() {
  return describe_double<ImplicitMidpoint>(
      {.name = "implicit_midpoint",
       .summary = "implicit midpoint rule by Newton's method: second order, any step, keeps energy",
       .order_undamped = 2,
       .order_damped = 2,
       .implicit = true,
       .collisions = Collisions::inside_steps,
       .relaxes = true,
       .iterates = true,
       .symplectic = true});
}

}  // namespace mss

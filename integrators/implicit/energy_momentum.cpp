// The energy-momentum method: the implicit midpoint rule with a discrete gradient in place of the force,
//   X = x_n + dt/2 V,   M (V - v_n) = dt/2 f(x_n, x_{n+1}, V),   x_{n+1} = 2 X - x_n,   v_{n+1} = 2 V - v_n,
//   f(x_n, x_{n+1}) . (x_{n+1} - x_n) = E(x_n) - E(x_{n+1}).
// The change of kinetic energy is f . (x_{n+1} - x_n), so without damping the total energy stays the same at
// any step, as far as the step's equations are solved: they are, to rounding. Springs' forces act along the
// line between their ends, which keeps angular momentum too. Gravity and loads are exact, the fold guard and
// penalty planes those of the midpoint rule; dampers act with the velocity V. Second order, damped or not.
// The tangent is that of the force at the midpoint, so Newton's method converges linearly, in steps the
// faster the less springs turn. For the forces see core/springs/discrete_gradient.hpp.
#include "integrators/nonlinear/implicit_stage.hpp"

namespace mss {

namespace {

class EnergyMomentum final : public Integrator<double> {
 public:
  explicit EnergyMomentum(const IntegratorOptions& options)
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
                                            .conserve_from = &x_,
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

IntegratorInfo energy_momentum() {
  return describe_double<EnergyMomentum>(
      {.name = "energy_momentum",
       .summary =
           "midpoint rule with a discrete gradient (LaBudde and Greenspan): second order, any step, energy "
           "exact, of springs also angular momentum",
       .order_undamped = 2,
       .order_damped = 2,
       .implicit = true,
       .collisions = Collisions::inside_steps,
       .iterates = true,
       .energy_exact = true});
}

}  // namespace mss

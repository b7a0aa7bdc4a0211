// Generalized-alpha, Newmark's formulas with the equation of motion between the two ends of a step:
//   x_1 = x_0 + dt v_0 + dt^2 ((1/2 - beta) a_0 + beta a_1),   v_1 = v_0 + dt ((1 - gamma) a_0 + gamma a_1),
//   M ((1 - m) a_1 + m a_0) = (1 - f) f(x_1, v_1) + f f(x_0, v_0),
//   m = (2 rho - 1) / (rho + 1),   f = rho / (rho + 1),   gamma = 1/2 - m + f,   beta = (1 - m + f)^2 / 4.
// Second order, damped or not; stable for any step on the test equation. rho, `solve.spectral_radius`, is by
// what a step multiplies motions that it cannot resolve: 0 removes them in one step, 1 keeps them, and of all
// methods with that rho this one damps slow motions least. The acceleration is history.
//
// Others of the family: rho = 1 is Newmark's trapezoidal rule (beta = 1/4, gamma = 1/2), to rounding, for
// nonlinear forces too, because the forces at the ends are mixed, not the ends. The method of Hilber, Hughes
// and Taylor with their alpha in [-1/3, 0] has rho = (1 + alpha) / (1 - alpha), from 1/2 to 1, and damps slow
// motions more; so 0.9, near their common -0.05, is the default.
// Chung and Hulbert, J. Appl. Mech. 60 (1993) 371; Newmark, J. Eng. Mech. Div. ASCE 85 (1959) 67; Hilber,
// Hughes and Taylor, Earthq. Eng. Struct. Dyn. 5 (1977) 283.
#include "core/base/record.hpp"
#include "integrators/nonlinear/implicit_stage.hpp"

namespace mss {

namespace {

class GeneralizedAlpha final : public Integrator<double> {
 public:
  explicit GeneralizedAlpha(const IntegratorOptions& options)
      : dt_(options.dt),
        mass_share_((2 * options.spectral_radius - 1) / (options.spectral_radius + 1)),
        force_share_(options.spectral_radius / (options.spectral_radius + 1)),
        solver_(make_nonlinear_solver(options)) {}

  Status do_advance(System<double>& system, State<double>& state, double t_end, Work& work) override {
    return advance_step_by_step(*this, system, state, dt_, t_end, work,
                                [&] { return step(system, state, work); });
  }

  void reset() override { acceleration_ = Field<double>(); }
  void remember(System<double>& system, Record& record) override {
    record.keep_field(acceleration_, system.size());
    solver_->remember(system, record);
  }

 private:
  Status step(System<double>& system, State<double>& state, Work& work) {
    const double m = mass_share_, f = force_share_;
    const double gamma = 0.5 - m + f, beta = (1 - m + f) * (1 - m + f) / 4, ratio = beta / gamma;
    begin(system, state, dt_ * gamma * f / (1 - m), work);
    x_base_.array() =
        x_.array() + dt_ * (1 - ratio) * v_.array() + dt_ * dt_ * (0.5 - ratio) * acceleration_.array();
    v_base_.array() = v_.array() + dt_ * gamma * f / (1 - m) * force_.array() +
                      dt_ * (1 - gamma - gamma * m / (1 - m)) * acceleration_.array();
    const Status status = solver_->solve(system,
                                         {.t = state.t + dt_,
                                          .gamma = dt_ * gamma * (1 - f) / (1 - m),
                                          .gamma_x = dt_ * ratio,
                                          .x_base = &x_base_,
                                          .v_base = &v_base_,
                                          .start = &x_,
                                          .since = dt_,
                                          .impulse_weight = (1 - m) / gamma},
                                         state, work);
    if (status != Status::ok) return status;
    acceleration_.array() =
        (state.v.array() - v_.array()) / (dt_ * gamma) - (1 - gamma) / gamma * acceleration_.array();
    system.clear_prescribed(acceleration_);
    solver_->end_step({.free = {.dt = dt_, .drift = 0.5}, .x = &x_, .v = &v_, .lag = dt_ * (1 - gamma - m)},
                      state, &acceleration_);
    state.t += dt_;
    return status;
  }

  /// Keeps what is known at the beginning of a step, whose forces change velocities for some seconds; the
  /// first step has no other acceleration than theirs.
  void begin(System<double>& system, const State<double>& state, double seconds, Work& work) {
    if (force_.size() == 0)
      for (Field<double>* field : {&force_, &x_base_, &v_base_}) *field = Field<double>(system.size());
    x_ = state.x;
    v_ = state.v;
    free_acceleration(system, state.t, state.x, state.v, seconds, force_);
    ++work.force_evaluations;
    if (acceleration_.size() > 0) return;
    acceleration_ = force_;
    if (system.bounds())
      system.acceleration(state.t, state.x, state.v, acceleration_);  // what sticks has none
  }

  double dt_;
  double mass_share_;   ///< m, of the old acceleration
  double force_share_;  ///< f, of the old force
  std::unique_ptr<NonlinearSolver> solver_;
  Field<double> x_, v_;         ///< at the beginning of the step
  Field<double> force_;         ///< over mass, at the beginning of the step
  Field<double> acceleration_;  ///< a_0; empty before the first step
  Field<double> x_base_, v_base_;
};

}  // namespace

IntegratorInfo generalized_alpha() {
  return describe_double<GeneralizedAlpha>(
      {.name = "generalized_alpha",
       .summary =
           "Chung and Hulbert's: second order, any step, damps the unresolved as solve.spectral_radius says; "
           "1: Newmark's trapezoidal rule",
       .order_undamped = 2,
       .order_damped = 2,
       .implicit = true,
       .collisions = Collisions::inside_steps,
       .relaxes = true,
       .iterates = true});
}

}  // namespace mss

// TR-BDF2, the composite scheme of Bank et al. that Bathe (2007) introduced to structural dynamics (thesis's
// reference 17), here with the split g = 2 - sqrt 2 that gives both stages the same matrix. With d = g dt /
// 2:
//   trapezoid to t + g dt:  x_g = x_n + d (v_n + v_g),  M (v_g - v_n) = d (f_n + f_g)
//   BDF2 to t + dt:         x_{n+1} = a x_g - b x_n + d v_{n+1},  M (v_{n+1} - a v_g + b v_n) = d f_{n+1}
//   with a = 1 / (g (2 - g)),  b = (1 - g)^2 / (g (2 - g)).
// Second order, damped or not; stable for any step on the test equation; damps what the step cannot resolve.
// Bank et al., IEEE Trans. CAD 4 (1985) 436; Bathe, Computers & Structures 85 (2007) 437.
#include "integrators/nonlinear/implicit_stage.hpp"

namespace mss {

namespace {

class TrBdf2 final : public Integrator<double> {
 public:
  explicit TrBdf2(const IntegratorOptions& options)
      : dt_(options.dt), solver_(make_nonlinear_solver(options)) {}

  Status do_advance(System<double>& system, State<double>& state, double t_end, Work& work) override {
    return advance_step_by_step(*this, system, state, dt_, t_end, work,
                                [&] { return step(system, state, work); });
  }

  void remember(System<double>& system, Record& record) override { solver_->remember(system, record); }

 private:
  Status step(System<double>& system, State<double>& state, Work& work) {
    const double g = 2 - std::sqrt(2.0), d = g * dt_ / 2;
    const double a = 1 / (g * (2 - g)), b = (1 - g) * (1 - g) / (g * (2 - g));
    if (v_base_.size() == 0) v_base_ = Field<double>(system.size());
    x_ = state.x;
    v_ = state.v;
    free_acceleration(system, state.t, state.x, state.v, a * d, v_base_);
    ++work.force_evaluations;
    v_base_.array() = v_.array() + d * v_base_.array();
    x_base_ = x_;
    x_base_.array() += d * v_.array();
    const double began = state.t;
    const auto solve = [&](double t, double weight) {
      return solver_->solve(system,
                            {.t = t,
                             .gamma = d,
                             .x_base = &x_base_,
                             .v_base = &v_base_,
                             .start = &x_,
                             .since = t - began,
                             .impulse_weight = weight},
                            state, work);
    };
    const Status status = solve(state.t + g * dt_, a);
    if (status != Status::ok) return status;
    x_base_.array() = a * state.x.array() - b * x_.array();
    v_base_.array() = a * state.v.array() - b * v_.array();
    state.t += dt_;
    const Status end = solve(state.t, 1);
    if (end == Status::ok)
      solver_->end_step({.free = {.dt = dt_, .drift = 0.5}, .x = &x_, .v = &v_}, state, nullptr);
    return end;
  }

  double dt_;
  std::unique_ptr<NonlinearSolver> solver_;
  Field<double> x_, v_;  ///< at the beginning of the step
  Field<double> x_base_, v_base_;
};

}  // namespace

IntegratorInfo tr_bdf2() {
  return describe_double<TrBdf2>(
      {.name = "tr_bdf2",
       .summary =
           "trapezoid, then BDF2 (Bathe's composite scheme): second order, any step, damps the unresolved",
       .order_undamped = 2,
       .order_damped = 2,
       .implicit = true,
       .collisions = Collisions::inside_steps,
       .relaxes = true,
       .iterates = true});
}

}  // namespace mss

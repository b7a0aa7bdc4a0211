// Explicit (forward) Euler, thesis eq. 2-11:
//   x_{n+1} = x_n + dt v_n,   v_{n+1} = v_n + dt M^-1 f(x_n, v_n).
// First order. Stable iff w^2 dt < c and 2 c dt < 4 + w^2 dt^2; undamped never.
#include "integrators/fixed_step.hpp"

namespace mss {

namespace {

template <class Real>
class ExplicitEuler final : public Integrator<Real> {
 public:
  explicit ExplicitEuler(const IntegratorOptions& options) : dt_(options.dt) {}

  Status advance(System<Real>& system, State<Real>& state, double t_end, Work& work) override {
    return advance_fixed(state, dt_, t_end, work, [&](long steps) {
      system.kick_drift({.kick_before = dt_, .kick_after = 0, .drift_old = dt_, .drift_new = 0}, dt_, steps,
                        state);
      work.force_evaluations += steps;
    });
  }

 private:
  double dt_;
};

}  // namespace

IntegratorInfo explicit_euler() {
  return describe<ExplicitEuler>({.name = "explicit_euler",
                                  .summary = "forward Euler (2-11): first order, unstable without damping",
                                  .order_undamped = 1,
                                  .order_damped = 1,
                                  .limit = StabilityLimit::explicit_euler});
}

}  // namespace mss

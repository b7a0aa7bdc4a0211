// Explicit (forward) Euler, thesis eq. 2-11:
//   x_{n+1} = x_n + dt v_n,   v_{n+1} = v_n + dt M^-1 f(x_n, v_n).
// First order. Stable iff w^2 dt < c and 2 c dt < 4 + w^2 dt^2; undamped never.
#include "integrators/device/on_device.hpp"
#include "integrators/fixed_step.hpp"

namespace mss {

namespace {

template <class Real>
class ExplicitEuler final : public Integrator<Real> {
 public:
  explicit ExplicitEuler(const IntegratorOptions& options) : dt_(options.dt) {}

  Status do_advance(System<Real>& system, State<Real>& state, double t_end, Work& work) override {
    return advance_fixed(*this, system, state, dt_, t_end, work, [&](long steps) {
      system.kick_drift({.kick_before = dt_, .kick_after = 0, .drift_old = dt_, .drift_new = 0}, dt_, steps,
                        state);
      work.force_evaluations += steps;
    });
  }

 private:
  double dt_;
};

/// The smaller of c / w^2 and the first root of 4 - 2 c dt + w^2 dt^2 = 0, if it has one.
double explicit_euler_limit(double omega, double damping) {
  const double oscillating = damping / (omega * omega);
  if (damping < 2 * omega) return oscillating;
  return std::min(oscillating, 4 / (damping + std::sqrt(damping * damping - 4 * omega * omega)));
}

}  // namespace

IntegratorInfo explicit_euler() {
  return on_device(
      DeviceSteps::explicit_euler,
      describe<ExplicitEuler>({.name = "explicit_euler",
                               .summary = "forward Euler (2-11): first order, unstable without damping",
                               .order_undamped = 1,
                               .order_damped = 1,
                               .relaxes = true,
                               .limit = explicit_euler_limit,
                               .polynomial = {1, 1}}));
}

}  // namespace mss

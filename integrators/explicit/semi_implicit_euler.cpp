// Semi-implicit (symplectic) Euler, thesis eq. 2-12:
//   v_{n+1} = v_n + dt M^-1 f(x_n, v_n),   x_{n+1} = x_n + dt v_{n+1}.
// First order, symplectic without damping. Stable iff w^2 dt^2 + 2 c dt < 4.
#include "integrators/device/on_device.hpp"
#include "integrators/fixed_step.hpp"

namespace mss {

namespace {

template <class Real>
class SemiImplicitEuler final : public Integrator<Real> {
 public:
  explicit SemiImplicitEuler(const IntegratorOptions& options) : dt_(options.dt) {}

  Status do_advance(System<Real>& system, State<Real>& state, double t_end, Work& work) override {
    return advance_fixed(*this, system, state, dt_, t_end, work, [&](long steps) {
      system.kick_drift({.kick_before = dt_, .kick_after = 0, .drift_old = 0, .drift_new = dt_}, dt_, steps,
                        state);
      work.force_evaluations += steps;
    });
  }

 private:
  double dt_;
};

}  // namespace

IntegratorInfo semi_implicit_euler() {
  return on_device(
      DeviceSteps::semi_implicit_euler,
      describe<SemiImplicitEuler>({.name = "semi_implicit_euler",
                                   .summary = "symplectic Euler (2-12): first order, one force a step",
                                   .order_undamped = 1,
                                   .order_damped = 1,
                                   .relaxes = true,
                                   .local_steps = true,
                                   .symplectic = true,
                                   .limit = central_limit}));
}

}  // namespace mss

// Velocity Verlet (kick, drift, kick):
//   v_{n+1/2} = v_n + dt/2 a_n,   x_{n+1} = x_n + dt v_{n+1/2},
//   a_{n+1} = M^-1 f(x_{n+1}, v_{n+1/2}),   v_{n+1} = v_{n+1/2} + dt/2 a_{n+1}.
// One force a step: a_{n+1} opens the next step too. Second order and symplectic without damping; a damping
// force uses the velocity of half a step ago, which reduces it to first order. Stable iff w^2 dt^2 + 2 c dt
// < 4. Swope, Andersen, Berens and Wilson, J. Chem. Phys. 76 (1982) 637.
#include "core/base/record.hpp"
#include "integrators/device/on_device.hpp"
#include "integrators/fixed_step.hpp"

namespace mss {

namespace {

template <class Real>
class VelocityVerlet final : public Integrator<Real> {
 public:
  explicit VelocityVerlet(const IntegratorOptions& options) : dt_(options.dt) {}

  Status do_advance(System<Real>& system, State<Real>& state, double t_end, Work& work) override {
    return advance_fixed(*this, system, state, dt_, t_end, work,
                         [&](long steps) { take(system, state, steps, work); });
  }

  void reset() override { acceleration_ = Field<Real>(); }
  void remember(System<Real>& system, Record& record) override {
    record.keep_field(acceleration_, system.size());
  }

 private:
  /// Between two steps the closing and the opening kick use the same acceleration, so they fuse with the
  /// force.
  void take(System<Real>& system, State<Real>& state, long steps, Work& work) {
    const double half = dt_ / 2;
    if (acceleration_.size() == 0) {
      acceleration_ = Field<Real>(system.size());
      system.acceleration(state.t, state.x, state.v, acceleration_);
      ++work.force_evaluations;
    }
    system.apply({.kick_before = 0, .kick_after = half, .drift_old = 0, .drift_new = dt_}, acceleration_, dt_,
                 state);
    system.kick_drift({.kick_before = half, .kick_after = half, .drift_old = 0, .drift_new = dt_}, dt_,
                      steps - 1, state);
    system.acceleration(state.t, state.x, state.v, acceleration_);
    system.apply({.kick_before = half, .kick_after = 0, .drift_old = 0, .drift_new = 0}, acceleration_, 0,
                 state);
    work.force_evaluations += steps;
  }

  double dt_;
  Field<Real> acceleration_;  ///< a_n; empty before the first step
};

}  // namespace

IntegratorInfo velocity_verlet() {
  return on_device(
      DeviceSteps::velocity_verlet,
      describe<VelocityVerlet>({.name = "velocity_verlet",
                                .summary = "kick-drift-kick: second order undamped, one force a step",
                                .order_undamped = 2,
                                .order_damped = 1,
                                .relaxes = true,
                                .local_steps = true,
                                .symplectic = true,
                                .limit = central_limit}));
}

}  // namespace mss

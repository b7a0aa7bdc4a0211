// Velocity Verlet with damping forces from the velocity of the same time, extrapolated:
//   v_{n+1/2} = v_n + dt/2 a_n,   x_{n+1} = x_n + dt v_{n+1/2},
//   a_{n+1} = M^-1 f(x_{n+1}, v_n + dt a_n),   v_{n+1} = v_{n+1/2} + dt/2 a_{n+1}.
// One force a step. Second order with damping too, which the thesis's Verlet and the plain velocity Verlet
// are not; without damping the same as the latter. Stable iff w^2 dt^2 + 4 c dt < 4: the characteristic
// polynomial on the test equation, W = w^2 dt^2, z = c dt, is l^3 - (2 - W - 3z/2) l^2 + (1 - 2z) l + z/2,
// and Jury's conditions reduce to p(-1) < 0.
#include "core/base/record.hpp"
#include "integrators/device/on_device.hpp"
#include "integrators/fixed_step.hpp"

namespace mss {

namespace {

template <class Real>
class DampedVerlet final : public Integrator<Real> {
 public:
  explicit DampedVerlet(const IntegratorOptions& options) : dt_(options.dt) {}

  Status do_advance(System<Real>& system, State<Real>& state, double t_end, Work& work) override {
    return advance_fixed(*this, system, state, dt_, t_end, work, [&](long steps) {
      if (acceleration_.size() == 0) {
        acceleration_ = Field<Real>(system.size());
        system.acceleration(state.t, state.x, state.v, acceleration_);
        ++work.force_evaluations;
      }
      for (long n = 0; n < steps; ++n) step(system, state);
      work.force_evaluations += steps;
    });
  }

  void reset() override { acceleration_ = Field<Real>(); }
  void remember(System<Real>& system, Record& record) override {
    record.keep_field(acceleration_, system.size());
  }

 private:
  void step(System<Real>& system, State<Real>& state) {
    const auto dt = static_cast<Real>(dt_), half = static_cast<Real>(dt_ / 2);
    middle_ = state.v;
    middle_.array() += half * acceleration_.array();
    state.x.array() += dt * middle_.array();
    state.v.array() += dt * acceleration_.array();
    kicked_for(system, dt_ / 2);
    state.t += dt_;
    system.constrain(state.t, state.x, state.v);
    system.acceleration(state.t, state.x, state.v, acceleration_);
    kicked_for(system, dt_ / 2);
    state.v.array() = middle_.array() + half * acceleration_.array();
    system.constrain(state.t, state.x, state.v);
  }

  double dt_;
  Field<Real> acceleration_;  ///< a_n; empty before the first step
  Field<Real> middle_;        ///< v_{n+1/2}
};

/// The positive root of w^2 dt^2 + 4 c dt = 4.
double damped_verlet_limit(double omega, double damping) {
  return 2 / (damping + std::hypot(damping, omega));
}

}  // namespace

IntegratorInfo damped_verlet() {
  return on_device(
      DeviceSteps::damped_verlet,
      describe<DampedVerlet>({.name = "damped_verlet",
                              .summary = "velocity Verlet, second order with damping too, one force a step",
                              .order_undamped = 2,
                              .order_damped = 2,
                              .relaxes = true,
                              .symplectic = true,
                              .limit = damped_verlet_limit}));
}

}  // namespace mss

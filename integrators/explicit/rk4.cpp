// The classical Runge-Kutta method, with y = (x, v) and y' = (v, M^-1 f):
//   k1 = y'(t, y), k2 = y'(t + dt/2, y + dt/2 k1), k3 = y'(t + dt/2, y + dt/2 k2), k4 = y'(t + dt, y + dt
//   k3), y_{n+1} = y_n + dt/6 (k1 + 2 k2 + 2 k3 + k4).
// Fourth order; four forces a step. Stable while |R(z)| <= 1, R = 1 + z + z^2/2 + z^3/6 + z^4/24, at the
// roots of z^2 + c dt z + w^2 dt^2 = 0: w dt < 2 sqrt 2 without damping, where it slowly loses energy.
#include "integrators/device/on_device.hpp"
#include "integrators/fixed_step.hpp"

namespace mss {

namespace {

template <class Real>
class Rk4 final : public Integrator<Real> {
 public:
  explicit Rk4(const IntegratorOptions& options) : dt_(options.dt) {}

  Status do_advance(System<Real>& system, State<Real>& state, double t_end, Work& work) override {
    return advance_fixed(*this, system, state, dt_, t_end, work, [&](long steps) {
      for (long n = 0; n < steps; ++n) step(system, state);
      work.force_evaluations += 4 * steps;
    });
  }

 private:
  void step(System<Real>& system, State<Real>& state) {
    if (a_.size() == 0) a_ = Field<Real>(system.size());
    stage_ = state;
    dx_ = state.v;
    system.acceleration(state.t, state.x, state.v, a_);
    kicked_for(system, dt_ / 6);
    dv_ = a_;
    for (const double part : {0.5, 0.5, 1.0}) {
      const auto h = static_cast<Real>(part * dt_);
      stage_.x.array() = state.x.array() + h * stage_.v.array();
      stage_.v.array() = state.v.array() + h * a_.array();
      const double t = state.t + part * dt_;
      system.constrain(t, stage_.x, stage_.v);
      system.acceleration(t, stage_.x, stage_.v, a_);
      const Real weight = part == 0.5 ? 2 : 1;
      kicked_for(system, double(weight) * dt_ / 6);
      dx_.array() += weight * stage_.v.array();
      dv_.array() += weight * a_.array();
    }
    const auto sixth = static_cast<Real>(dt_ / 6);
    state.x.array() += sixth * dx_.array();
    state.v.array() += sixth * dv_.array();
    state.t += dt_;
    system.constrain(state.t, state.x, state.v);
  }

  double dt_;
  State<Real> stage_;
  Field<Real> a_, dx_, dv_;
};

const std::vector<double> polynomial{1, 1, 1.0 / 2, 1.0 / 6, 1.0 / 24};

double rk4_limit(double omega, double damping) { return polynomial_limit(polynomial, omega, damping); }

}  // namespace

IntegratorInfo rk4() {
  return on_device(DeviceSteps::rk4,
                   describe<Rk4>({.name = "rk4",
                                  .summary = "classical Runge-Kutta: fourth order, four forces a step",
                                  .order_undamped = 4,
                                  .order_damped = 4,
                                  .limit = rk4_limit,
                                  .polynomial = polynomial}));
}

}  // namespace mss

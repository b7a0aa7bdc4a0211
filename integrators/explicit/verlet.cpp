// The thesis's Verlet, eq. 2-15 with the velocity of eq. 2-21:
//   v_{n-1/2} = (x_n - x_{n-1}) / dt,   x_{n+1} = 2 x_n - x_{n-1} + dt^2 M^-1 f(x_n, v_{n-1/2}).
// The same recursion as semi-implicit Euler: state.v is v_{n-1/2}, and x_{-1} = x_0 - dt v_0 starts it. As a
// sampler of the exact (x, v) it is first order, not second as the thesis says: the start and the damping lag
// by dt/2. Stable iff w^2 dt^2 + 2 c dt < 4.
#include "core/base/record.hpp"
#include "integrators/device/on_device.hpp"
#include "integrators/fixed_step.hpp"

namespace mss {

namespace {

template <class Real>
class Verlet final : public Integrator<Real> {
 public:
  explicit Verlet(const IntegratorOptions& options) : dt_(options.dt) {}

  Status do_advance(System<Real>& system, State<Real>& state, double t_end, Work& work) override {
    return advance_fixed(*this, system, state, dt_, t_end, work, [&](long steps) {
      for (long n = 0; n < steps; ++n) step(system, state);
      work.force_evaluations += steps;
    });
  }

  void reset() override { previous_ = Field<Real>(); }
  void remember(System<Real>& system, Record& record) override {
    record.keep_field(previous_, system.size());
  }

 private:
  void start(const State<Real>& state) {
    previous_ = state.x;
    previous_.array() -= static_cast<Real>(dt_) * state.v.array();
  }

  void step(System<Real>& system, State<Real>& state) {
    if (acceleration_.size() == 0) acceleration_ = Field<Real>(system.size());
    if (previous_.size() == 0) start(state);
    const auto dt = static_cast<Real>(dt_);
    system.acceleration(state.t, state.x, state.v, acceleration_);
    const auto x = state.x.array();
    // x_{n-1} is not needed any more: x_{n+1} is stored there, and the two fields are swapped.
    previous_.array() = (x + x) - previous_.array() + (dt * dt) * acceleration_.array();
    state.v.array() = (previous_.array() - x) / dt;
    std::swap(state.x, previous_);
    state.t += dt_;
    system.constrain(state.t, state.x, state.v);
  }

  double dt_;
  Field<Real> previous_;  ///< x_{n-1}; empty before the first step
  Field<Real> acceleration_;
};

}  // namespace

IntegratorInfo verlet() {
  return on_device(
      DeviceSteps::semi_implicit_euler,
      describe<Verlet>({.name = "verlet",
                        .summary = "the thesis's Verlet (2-15, 2-21), first order, one force a step",
                        .order_undamped = 1,
                        .order_damped = 1,
                        .relaxes = true,
                        .local_steps = true,
                        .symplectic = true,
                        .limit = central_limit,
                        .variant_of = "semi_implicit_euler",
                        .variation = "the same recursion, kept as positions instead of velocities"}));
}

}  // namespace mss

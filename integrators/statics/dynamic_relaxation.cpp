// Dynamic relaxation with kinetic damping: the undamped motion
//   v' = v + dt M^-1 f(t, x, 0),   x' = x + dt v',
// with t the end time, stopped whenever its kinetic energy has passed a peak, until from one peak to the next
// no coordinate moves by more than the tolerance. It lowers the potential energy at every stop, needs no
// tangent and no matrix, and forces of dampers are left out. Steps must be below the limit of undamped
// motion; where a strongly deformed body is stiffer than that allows, it begins again with half the step.
// Cundall, in: Criteria for nuclear power plant structures (1976); Barnes, Form finding and analysis of
// tension structures by dynamic relaxation, Int. J. Space Structures 14 (1999) 89.
#include <algorithm>
#include <cmath>
#include <limits>

#include "integrators/nonlinear/implicit_stage.hpp"

namespace mss {

namespace {

constexpr long most_steps = 200000;
constexpr int most_halvings = 6;

class DynamicRelaxation final : public Integrator<double> {
 public:
  explicit DynamicRelaxation(const IntegratorOptions& options)
      : dt_(options.dt),
        most_steps_(std::min(options.most_steps, most_steps)),
        enough_(options.tolerance * options.length_scale) {}

  Status do_advance(System<double>& system, State<double>& state, double t_end, Work& work) override {
    if (system.memory()) system.memory()->forget();
    state.t = t_end;
    if (rest_.size() == 0)
      for (Field<double>* field : {&rest_, &acceleration_}) *field = Field<double>(system.size());
    state.v = rest_;
    system.constrain(state.t, state.x, state.v);
    start_ = state.x;
    double dt = dt_;
    Status status = relax(system, state, dt, work);
    for (int halvings = 0; status == Status::non_finite && halvings < most_halvings; ++halvings) {
      state.x = start_;
      dt /= 2;
      status = relax(system, state, dt, work);
    }
    return status;
  }

 private:
  Status relax(System<double>& system, State<double>& state, double dt, Work& work) {
    state.v = rest_;
    stopped_ = state.x;
    double before = 0;  // kinetic energy, twice
    for (long step = 0; step < most_steps_; ++step) {
      take_step(system, state, dt, work);
      const double now = kinetic_energy(system, state);
      if (!std::isfinite(now)) return Status::non_finite;
      if (now > before) {
        before = now;
        continue;
      }
      before = 0;
      state.v = rest_;
      if ((state.x.array() - stopped_.array()).abs().maxCoeff() <= enough_) return Status::ok;
      stopped_ = state.x;
    }
    return Status::step_limit;
  }

  void take_step(System<double>& system, State<double>& state, double dt, Work& work) {
    system.acceleration(state.t, state.x, rest_, acceleration_);
    ++work.force_evaluations;
    ++work.steps;
    system.apply({.kick_before = dt, .drift_new = dt}, acceleration_, 0, state);
  }

  double kinetic_energy(const System<double>& system, const State<double>& state) const {
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double* v = state.v.axis(axis);
      for (const std::ptrdiff_t i : system.particles()) sum += system.mass(i) * v[i] * v[i];
    }
    return sum;
  }

  double dt_;
  long most_steps_;
  double enough_;  ///< [m]
  Field<double> rest_, acceleration_;
  Field<double> start_, stopped_;  ///< positions at first, and at the last peak
};

}  // namespace

IntegratorInfo dynamic_relaxation() {
  return describe_double<DynamicRelaxation>({.name = "dynamic_relaxation",
                                             .summary = "no motion: where a body comes to rest at the end "
                                                        "time, by undamped motion stopped at every peak of "
                                                        "its kinetic energy",
                                             .stepping = Stepping::equilibrium,
                                             .collisions = Collisions::never,
                                             .relaxes = true,
                                             .limit = [](double omega, double) { return 2 / omega; }});
}

}  // namespace mss

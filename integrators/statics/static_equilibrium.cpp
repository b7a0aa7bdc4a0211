// Static equilibrium, f(t, x, 0) = 0, by pseudo-transient continuation: steps of backward Euler that start
// from rest each time,
//   M (x' - x) / tau^2 = f(t, x', 0),
// solved by a nonlinear solver. Each one lowers the potential energy. Newton's method begins with short
// steps, the first no further than the body would fall in tau, so that it does not jump into a folded state;
// as tau grows, inertia vanishes and it converges quadratically. Quasi-Newton methods, whose matrix bounds
// the tangent, go downhill from anywhere and take long steps at once, until none moves the body by more than
// the tolerance. Prescribed coordinates have their values at time t. Kelley and Keyes, SIAM J. Numer. Anal.
// 35 (1998) 508.
// Planes act inside the steps, see bounded_system.hpp. What slides in one is where it was, and at rest, when
// the next begins, so that friction holds what it can hold where it has come to.
#include <limits>

#include "core/base/record.hpp"
#include "integrators/nonlinear/implicit_stage.hpp"

namespace mss {

namespace {

constexpr double first_tau = 10, last_tau = 1e6;  ///< times the stiffest particle's period over 2 pi
constexpr double growth = 10;
constexpr int most_steps = 60;
constexpr int most_stuck = 3;  ///< steps of the largest tau without convergence: the body falls

/// Of quasi-Newton methods: a body of a hundred cells falls far in it, a loose one hardly drifts.
constexpr double long_tau = 1e5;

/// Steps of the largest tau that move coordinates by less than this share count as converged.
constexpr double negligible = 1e-11;

class StaticEquilibrium final : public Integrator<double> {
 public:
  explicit StaticEquilibrium(const IntegratorOptions& options)
      : options_(options),
        solver_(make_nonlinear_solver(options)),
        by_newton_(options.nonlinear_solver == "newton"),
        enough_(options.tolerance * options.length_scale) {}
  void reset() override { settled_force_ = -1; }
  void remember(System<double>& system, Record& record) override {
    bool newton = by_newton_;
    record.keep(newton, settled_force_);
    if (newton && !by_newton_) take_newton();
    solver_->remember(system, record);
  }

  Status do_advance(System<double>& system, State<double>& state, double t_end, Work& work) override {
    if (system.memory()) system.memory()->forget();
    seconds_ = t_end - state.t;
    state.t = t_end;
    rest_ = Field<double>(system.size());
    system.constrain(state.t, state.x, state.v);
    state.v = rest_;
    if (!system.bounds() && still_at_rest(system, state, work)) return Status::ok;
    const double unit = 1 / stiffest(system, state);
    if (by_newton_) return continue_to_rest(system, state, unit, work);
    start_ = state.x;
    const Status status = descend(system, state, long_tau * unit, work);
    if (status == Status::ok || !system.bounds()) return status;
    state.x = start_;
    take_newton();
    return continue_to_rest(system, state, unit, work);
  }

 private:
  /// On planes long steps may slide on the edge of friction's cone; Newton's begin short.
  void take_newton() {
    options_.nonlinear_solver = "newton";
    solver_ = make_nonlinear_solver(options_);
    by_newton_ = true;
  }

  /// Ever longer steps.
  Status continue_to_rest(System<double>& system, State<double>& state, double unit, Work& work) {
    double tau = first_tau * unit;
    double before = std::numeric_limits<double>::infinity();
    for (int step = 0, stuck = 0; step < most_steps && stuck < most_stuck; ++step) {
      const Status status = relax(system, state, tau, work);
      ++work.steps;
      if (status == Status::ok && tau >= last_tau * unit) {
        const double move = largest_move(state) / state.x.array().abs().maxCoeff();
        if (move <= negligible) return settle(system, state, tau, work);
        if (move > before / 2) ++stuck;
        before = move;
      }
      tau = status == Status::ok ? std::min(growth * tau, last_tau * unit) : tau / (growth * growth);
      if (status != Status::ok && tau < 1e-3 * unit) return status;
    }
    return Status::newton_stalled;
  }

  /// Steps of one length; what a step has reached stays, even if it stalls.
  Status descend(System<double>& system, State<double>& state, double tau, Work& work) {
    double before = std::numeric_limits<double>::infinity();
    for (int step = 0, stuck = 0; step < most_steps && stuck < most_stuck; ++step) {
      const Status status = relax(system, state, tau, work);
      ++work.steps;
      if (status != Status::ok) return status;
      const double move = largest_move(state);
      if (move <= enough_) return settle(system, state, tau, work);
      if (move > before / 2) ++stuck;
      before = move;
    }
    return Status::newton_stalled;
  }

  /// One step from rest; Newton's method restores the positions if it fails.
  Status relax(System<double>& system, State<double>& state, double tau, Work& work,
               double impulse_weight = 0) {
    x_ = state.x;
    const ImplicitStage stage{.t = state.t,
                              .gamma = tau,
                              .x_base = &x_,
                              .v_base = &rest_,
                              .force_velocity = &rest_,
                              .impulse_weight = impulse_weight,
                              .enough = enough_ / 10};
    const Status status = solver_->solve(system, stage, state, work);
    if (status != Status::ok && by_newton_) state.x = x_;
    state.v = rest_;
    return status;
  }

  /// Of the last step [m].
  double largest_move(const State<double>& state) const {
    return (state.x.array() - x_.array()).abs().maxCoeff();
  }

  /// Planes give what they would in the time that has passed; a step more finds it.
  Status settle(System<double>& system, State<double>& state, double tau, Work& work) {
    if (system.bounds()) {
      const Status status = relax(system, state, tau, work, seconds_ / tau);
      if (status != Status::ok) return status;
    }
    settled_force_ = largest_force(system, state, work);
    return std::isfinite(settled_force_) ? Status::ok : Status::non_finite;
  }

  /// Whether nothing has moved since the last equilibrium.
  bool still_at_rest(System<double>& system, const State<double>& state, Work& work) {
    return settled_force_ >= 0 && largest_force(system, state, work) <= settled_force_;
  }

  double largest_force(System<double>& system, const State<double>& state, Work& work) {
    force_ = Field<double>(system.size());
    system.force(state.t, state.x, state.v, force_);
    system.clear_prescribed(force_);
    ++work.force_evaluations;
    return force_.array().abs().maxCoeff();
  }

  /// Largest angular frequency of one particle while the others are still [1/s].
  double stiffest(System<double>& system, const State<double>& state) {
    std::vector<Eigen::Matrix3d> blocks;
    tangents_of(system).diagonal(state.t, state.x, state.v, {.stiffness = 1, .kind = Tangent::projected},
                                 blocks);
    double largest = 0;
    for (std::size_t p = 0; p < blocks.size(); ++p)
      largest = std::max(largest, blocks[p].diagonal().maxCoeff() / system.mass(system.particles()[p]));
    return largest > 0 ? std::sqrt(largest) : 1;
  }

  IntegratorOptions options_;
  std::unique_ptr<NonlinearSolver> solver_;
  bool by_newton_;
  double enough_;        ///< moves of quasi-Newton methods [m]
  Field<double> start_;  ///< of the search
  Field<double> x_;      ///< before the step
  Field<double> rest_;   ///< zero
  Field<double> force_;
  double seconds_ = 0;         ///< between the last time and this one
  double settled_force_ = -1;  ///< largest one left at the last equilibrium [N]; negative: there is none
};

}  // namespace

IntegratorInfo static_equilibrium() {
  return describe_double<StaticEquilibrium>(
      {.name = "static",
       .summary =
           "no motion: where a body comes to rest at the end time, by a nonlinear solver with continuation",
       .stepping = Stepping::equilibrium,
       .implicit = true,
       .collisions = Collisions::inside_steps,
       .relaxes = true,
       .iterates = true});
}

}  // namespace mss

#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/environment/contact.hpp"
#include "integrators/fixed_step.hpp"
#include "integrators/linear/linear_solver.hpp"

namespace mss {

/// One implicit stage of a method: find the velocity v at time t with
///   M (v - v_base) = gamma f(t, x, v),   x = x_base + gamma_x v.
/// Backward Euler is one such stage, implicit midpoint and TR-BDF2 are made of them. In the words of Hairer,
/// Norsett and Wanner (Solving ODEs I, II.14) gamma is dt a_ii, the diagonal coefficient of a Runge-Kutta-
/// Nystrom method for velocities, and gamma gamma_x is dt^2 abar_ii, that for positions. A Runge-Kutta method
/// applied to (x, v) has gamma_x = gamma; of Newmark's family gamma_x is beta/gamma dt in Newmark's letters.
struct ImplicitStage {
  double t = 0;            ///< [s]
  double gamma = 0;        ///< [s]
  double gamma_x = gamma;  ///< [s]
  const Field<double>* x_base = nullptr;
  const Field<double>* v_base = nullptr;
  const Field<double>* force_velocity = nullptr;  ///< constant velocities for the forces instead of v
  /// Positions at the beginning of a step with x at its middle: forces are then the discrete gradient over
  /// the whole step (core/springs/discrete_gradient.hpp), and the stage is solved to rounding, because what
  /// remains is energy gained or lost.
  const Field<double>* conserve_from = nullptr;
  /// Planes bound particles at bound_base + bound_gamma v; without, at x.
  const Field<double>* bound_base = nullptr;
  double bound_gamma = 0;                ///< [s]
  const Field<double>* start = nullptr;  ///< positions where the step began; without, bound_base or x_base
  double since = 0;                      ///< how long ago that was, with `start` [s]
  /// By what impulses that planes give in it change velocities at the end of the step: then the system keeps
  /// them. 0: it does not, as in a search for an equilibrium.
  double impulse_weight = 0;
  double enough = 0;  ///< quasi-Newton methods may stop once an iteration moves coordinates by this [m, rms]
};

/// The forces of a stage at state.x and state.v, shape 3 x sites; overwritten. `x_end` is scratch.
void stage_force(System<double>& system, const ImplicitStage& stage, const State<double>& state,
                 Field<double>& x_end, Field<double>& force);

/// M^-1 f; where planes act inside steps, of the forces alone, without what holds a particle at a plane. It
/// changes the velocities at the end of the step for so many `seconds`.
void free_acceleration(System<double>& system, double t, const Field<double>& x, const Field<double>& v,
                       double seconds, Field<double>& a);

/// A step that has been taken.
struct StepTaken {
  FreeStep free;
  const Field<double>*x, *v;  ///< at its beginning
  /// Of methods that keep accelerations: by how much momentum lags behind forces, over the accelerations [s].
  double lag = 0;
};

/// Solves implicit stages.
class NonlinearSolver {
 public:
  NonlinearSolver() = default;
  NonlinearSolver(const NonlinearSolver&) = delete;
  NonlinearSolver& operator=(const NonlinearSolver&) = delete;
  virtual ~NonlinearSolver() = default;

  /// Solves a stage; state.v holds a guess on entry, state.x and state.v the solution on return, state.t does
  /// not change. Prescribed coordinates have their values at the stage's time, and all particles are in front
  /// of the system's bounds. The system and its holds must be the same at every call. Throws InputError if
  /// the solver cannot serve the system.
  virtual Status solve(System<double>& system, const ImplicitStage& stage, State<double>& state,
                       Work& work) = 0;

  /// Ends a step: what a bound has stopped leaves it as restitution says. Accelerations, where a method keeps
  /// some, lose what points into bounds; what leaves them falls freely.
  virtual void end_step(const StepTaken& step, State<double>& state, Field<double>* a) {
    static_cast<void>(step), static_cast<void>(state), static_cast<void>(a);
  }

  /// See Integrator::remember().
  virtual void remember(System<double>& system, Record& record) {
    static_cast<void>(system), static_cast<void>(record);
  }
};

/// Facts about a nonlinear solver.
struct NonlinearSolverInfo {
  std::string name;
  std::string summary;  ///< one line for `mss list`
  std::function<std::unique_ptr<NonlinearSolver>(const IntegratorOptions&)> make;
};

/// All nonlinear solvers; the first is the default.
const std::vector<NonlinearSolverInfo>& nonlinear_solvers();

/// The solver of that name. Throws InputError that names the nearest known one.
const NonlinearSolverInfo& find_nonlinear_solver(std::string_view name);

/// The solver that the options name.
std::unique_ptr<NonlinearSolver> make_nonlinear_solver(const IntegratorOptions& options);

class BoundedSystem;

/// Newton's method with backtracking. Contact is an active set inside it (bounded_system.hpp).
class Newton final : public NonlinearSolver {
 public:
  explicit Newton(const IntegratorOptions& options);
  ~Newton() override;
  Status solve(System<double>& system, const ImplicitStage& stage, State<double>& state, Work& work) override;
  void end_step(const StepTaken& step, State<double>& state, Field<double>* a) override;
  void remember(System<double>& system, Record& record) override;
  /// Takes over, for one stage, from another solver with the system as it bounds it.
  Status solve_for(const std::shared_ptr<BoundedSystem>& bounded, System<double>& system,
                   const ImplicitStage& stage, State<double>& state, Work& work) {
    bounded_ = bounded;
    return solve(system, stage, state, work);
  }

 private:
  Status solve_stage(System<double>& plain, const ImplicitStage& stage, State<double>& state, Work& work);
  double residual(System<double>& system, const ImplicitStage& stage, State<double>& state, Work& work);
  double leave_out_held(const System<double>& system, const State<double>& state);
  Status find_step(System<double>& system, const ImplicitStage& stage, const State<double>& state,
                   Work& work);
  bool take_step(System<double>& system, const ImplicitStage& stage, State<double>& state, double& norm,
                 bool settled, Work& work);
  bool search(System<double>& system, const ImplicitStage& stage, State<double>& state, double& norm,
              Work& work);
  bool follow_once_solved(double norm, double good);
  double relative_move(const System<double>& system, const ImplicitStage& stage,
                       const State<double>& state) const;

  Tangent kind_;
  int iterations_;
  std::unique_ptr<LinearSolver> linear_;
  Field<double> residual_;  ///< gamma f - M (v - v_base)
  Field<double> step_;
  Field<double> v_before_;                  ///< the step
  Field<double> x_end_;                     ///< of a step that conserves energy
  std::shared_ptr<BoundedSystem> bounded_;  ///< the system where it has bounds
  Field<double> impulse_;                   ///< there, the residual with what holds particles
  Field<double> expected_;                  ///< the same after a step
  Field<double> jump_;                      ///< and the part of a step that takes them to their planes
  bool jumps_ = false;
  double friction_left_ = 0;     ///< of the residual, when friction has followed pressure
  bool careful_ = false;         ///< whether a stage that has stalled is solved once more
  Field<double> guess_;          ///< from which
  double norm_at_pressure_ = 0;  ///< |r| when friction followed the pressure last
};

/// Completes the facts of a method that computes in double precision only.
template <class Method>
IntegratorInfo describe_double(IntegratorInfo info) {
  info.make_double = [](const IntegratorOptions& o) { return std::make_unique<Method>(o); };
  return info;
}

}  // namespace mss

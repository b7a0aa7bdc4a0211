#pragma once

#include <memory>

#include "integrators/fixed_step.hpp"
#include "integrators/linear/linear_solver.hpp"

namespace mss {

/// One implicit stage of a method: find the velocity v at time t with
///   M (v - v_base) = gamma f(t, x, v),   x = x_base + gamma v.
/// Backward Euler is one such stage, implicit midpoint and TR-BDF2 are made of them.
struct ImplicitStage {
  double t = 0;      ///< [s]
  double gamma = 0;  ///< [s]
  const Field<double>* x_base = nullptr;
  const Field<double>* v_base = nullptr;
  const Field<double>* force_velocity = nullptr;  ///< constant velocities for the forces instead of v
};

/// Newton's method with backtracking for implicit stages.
class Newton {
 public:
  explicit Newton(const IntegratorOptions& options);

  /// Solves a stage; state.v holds a guess on entry, state.x and state.v the solution on return, state.t does
  /// not change. Prescribed coordinates have their values at the stage's time.
  Status solve(System<double>& system, const ImplicitStage& stage, State<double>& state, Work& work);

 private:
  double residual(System<double>& system, const ImplicitStage& stage, State<double>& state, Work& work);
  bool search(System<double>& system, const ImplicitStage& stage, State<double>& state, double& norm,
              Work& work);
  double largest_move(const ImplicitStage& stage) const;

  Tangent kind_;
  std::unique_ptr<LinearSolver> linear_;
  Field<double> residual_;  ///< gamma f - M (v - v_base)
  Field<double> step_;
  Field<double> v_before_;  ///< the step
};

/// Completes the facts of a method that computes in double precision only.
template <class Method>
IntegratorInfo describe_double(IntegratorInfo info) {
  info.make_double = [](const IntegratorOptions& o) { return std::make_unique<Method>(o); };
  return info;
}

}  // namespace mss

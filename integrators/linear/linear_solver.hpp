#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "integrators/integrator.hpp"

namespace mss {

/// Solves (a M + b C + c K) y = r for the unknowns of a system; symmetric tangents only.
class LinearSolver {
 public:
  LinearSolver() = default;
  LinearSolver(const LinearSolver&) = delete;
  LinearSolver& operator=(const LinearSolver&) = delete;
  virtual ~LinearSolver() = default;

  /// Prepares to solve with the tangent at a state. The system and its holds must be the same at every call;
  /// x and v must outlive the solves that follow. Throws InputError if the system has no tangents.
  virtual Status prepare(System<double>& system, double t, const Field<double>& x, const Field<double>& v,
                         const TangentCoefficients& sum, Work& work) = 0;

  /// Solves with what was prepared. Prescribed coordinates of `rhs` are ignored; those of `solution` become
  /// 0.
  virtual Status solve(const Field<double>& rhs, Field<double>& solution, Work& work) = 0;
};

/// Prepares a solver; where the requested elastic tangent cannot be factored, sum.kind becomes projected.
Status prepare_definite(LinearSolver& solver, System<double>& system, double t, const Field<double>& x,
                        const Field<double>& v, TangentCoefficients& sum, Work& work);

/// Prepares and solves; where the requested elastic tangent is indefinite, the projected one takes its place.
Status solve_tangent(LinearSolver& solver, System<double>& system, double t, const Field<double>& x,
                     const Field<double>& v, TangentCoefficients sum, const Field<double>& rhs,
                     Field<double>& solution, Work& work);

/// Facts about a linear solver.
struct LinearSolverInfo {
  std::string name;
  std::string summary;         ///< one line for `mss list`
  bool products_only = false;  ///< has no matrix of the whole body
  bool one_lattice = false;    ///< is for bodies with cells of one size
  bool in_ranks = false;       ///< works where ranks share a body
  std::function<std::unique_ptr<LinearSolver>(double tolerance)> make;
};

/// All linear solvers; the first is the default.
const std::vector<LinearSolverInfo>& linear_solvers();

/// The solver of that name. Throws InputError that names the nearest known one.
const LinearSolverInfo& find_linear_solver(std::string_view name);

}  // namespace mss

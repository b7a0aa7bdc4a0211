#pragma once

#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>

#include <memory>

#include "integrators/linear/linear_solver.hpp"
#include "integrators/sundials/first_order.hpp"

namespace mss::sundials {

struct MatrixRelease {
  void operator()(SUNMatrix m) const { SUNMatDestroy(m); }
};
using Matrix = std::unique_ptr<std::remove_pointer_t<SUNMatrix>, MatrixRelease>;

struct SolverRelease {
  void operator()(SUNLinearSolver s) const { SUNLinSolFree(s); }
};
using Solver = std::unique_ptr<std::remove_pointer_t<SUNLinearSolver>, SolverRelease>;

/// A linear solver for SUNDIALS' Newton matrix I - gamma dg/dy with the position increment eliminated:
///   (M + gamma C + gamma^2 K) dv = M b_v - gamma K b_x,   dx = b_x + gamma dv.
/// Half the unknowns, symmetric, and positive definite where the tangent is; factors are reused as CVODE
/// decides.
struct Eliminated {
  Matrix matrix;  ///< no numbers: the state at which derivatives are taken, and gamma
  Solver solver;
};
Eliminated make_eliminated(FirstOrder& problem, const IntegratorOptions& options, SUNContext context);

/// CVODE's Jacobian callback for that matrix: stores the state.
int store_jacobian_state(double t, N_Vector y, N_Vector, SUNMatrix jacobian, void*, N_Vector, N_Vector,
                         N_Vector);

}  // namespace mss::sundials

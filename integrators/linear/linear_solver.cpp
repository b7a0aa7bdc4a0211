#include "integrators/linear/linear_solver.hpp"

#include "core/base/suggest.hpp"

namespace mss {

Status prepare_definite(LinearSolver& solver, System<double>& system, double t, const Field<double>& x,
                        const Field<double>& v, TangentCoefficients& sum, Work& work) {
  const Status status = solver.prepare(system, t, x, v, sum, work);
  if (status != Status::not_positive_definite || sum.kind == Tangent::projected) return status;
  sum.kind = Tangent::projected;
  return solver.prepare(system, t, x, v, sum, work);
}

Status solve_tangent(LinearSolver& solver, System<double>& system, double t, const Field<double>& x,
                     const Field<double>& v, TangentCoefficients sum, const Field<double>& rhs,
                     Field<double>& solution, Work& work) {
  for (;;) {
    Status status = prepare_definite(solver, system, t, x, v, sum, work);
    if (status == Status::ok) status = solver.solve(rhs, solution, work);
    if (status != Status::not_positive_definite || sum.kind == Tangent::projected) return status;
    sum.kind = Tangent::projected;  // iterative solvers detect it only here
  }
}

const LinearSolverInfo& find_linear_solver(std::string_view name) {
  return find_named(linear_solvers(), name, "linear solver", "linear_solvers");
}

}  // namespace mss

// The list of linear solvers is in ../CMakeLists.txt: the line that compiles one also registers it.
#include "integrators/linear/linear_solver.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/suggest.hpp"

namespace mss {

#define MSS_LINEAR_SOLVER(name) LinearSolverInfo name();
#include "integrators/linear_solvers.inc"
#undef MSS_LINEAR_SOLVER

const std::vector<LinearSolverInfo>& linear_solvers() {
  static const std::vector<LinearSolverInfo> all{
#define MSS_LINEAR_SOLVER(name) name(),
#include "integrators/linear_solvers.inc"
#undef MSS_LINEAR_SOLVER
  };
  return all;
}

Status solve_tangent(LinearSolver& solver, System<double>& system, double t, const Field<double>& x,
                     const Field<double>& v, TangentSum sum, const Field<double>& rhs,
                     Field<double>& solution, Work& work) {
  for (;;) {
    Status status = solver.prepare(system, t, x, v, sum, work);
    if (status == Status::ok) status = solver.solve(rhs, solution, work);
    if (status != Status::not_positive_definite || sum.kind == Tangent::projected) return status;
    sum.kind = Tangent::projected;
  }
}

const LinearSolverInfo& find_linear_solver(std::string_view name) {
  std::vector<std::string> known;
  for (const LinearSolverInfo& info : linear_solvers()) {
    if (info.name == name) return info;
    known.push_back(info.name);
  }
  throw InputError(
      fmt::format("linear solver '{}' is unknown; did you mean '{}'? `mss list linear_solvers` shows all",
                  name, nearest(name, known)));
}

}  // namespace mss

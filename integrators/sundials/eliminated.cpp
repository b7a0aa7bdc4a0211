#include "integrators/sundials/eliminated.hpp"

namespace mss::sundials {

namespace {

/// Content of our SUNMatrix: I - gamma dg/dy is defined by the state at which dg/dy is taken, and by gamma.
struct Where {
  FirstOrder* problem;
  double t = 0;
  double gamma = 0;
  Field<double> x, v;
};
Where& where(SUNMatrix m) { return *static_cast<Where*>(m->content); }

SUNMatrix new_matrix(FirstOrder& problem, SUNContext context);

SUNMatrix_ID matrix_id(SUNMatrix) { return SUNMATRIX_CUSTOM; }
SUNMatrix clone_matrix(SUNMatrix m) { return new_matrix(*where(m).problem, m->sunctx); }
void destroy_matrix(SUNMatrix m) {
  delete static_cast<Where*>(m->content);
  SUNMatFreeEmpty(m);
}
int zero_matrix(SUNMatrix) { return 0; }
int copy_matrix(SUNMatrix from, SUNMatrix to) {
  where(to) = where(from);
  return 0;
}
/// m = c m + I, which CVODE calls with c = -gamma.
int scale_add_identity(double c, SUNMatrix m) {
  where(m).gamma = -c;
  return 0;
}

SUNMatrix new_matrix(FirstOrder& problem, SUNContext context) {
  SUNMatrix m = SUNMatNewEmpty(context);
  const std::ptrdiff_t size = problem.system().size();
  m->content = new Where{&problem, 0, 0, Field<double>(size), Field<double>(size)};
  m->ops->getid = matrix_id;
  m->ops->clone = clone_matrix;
  m->ops->destroy = destroy_matrix;
  m->ops->zero = zero_matrix;
  m->ops->copy = copy_matrix;
  m->ops->scaleaddi = scale_add_identity;
  return m;
}

/// Content of our SUNLinearSolver.
struct Elimination {
  Tangents<double>& tangents;
  std::unique_ptr<LinearSolver> linear;
  Tangent kind;                    ///< requested
  TangentCoefficients prepared{};  ///< the one that `linear` has prepared, at...
  Where* where = nullptr;
  Field<double> rhs, product, solution;
};
Elimination& elimination(SUNLinearSolver s) { return *static_cast<Elimination*>(s->content); }

SUNLinearSolver_Type solver_type(SUNLinearSolver) { return SUNLINEARSOLVER_DIRECT; }
SUNLinearSolver_ID solver_id(SUNLinearSolver) { return SUNLINEARSOLVER_CUSTOM; }
int free_solver(SUNLinearSolver s) {
  delete static_cast<Elimination*>(s->content);
  SUNLinSolFreeEmpty(s);
  return 0;
}

int set_up(SUNLinearSolver s, SUNMatrix m) {
  Elimination& e = elimination(s);
  Where& at = where(m);
  e.where = &at;
  e.prepared = {.mass = 1, .damping = at.gamma, .stiffness = at.gamma * at.gamma, .kind = e.kind};
  const Status status =
      prepare_definite(*e.linear, at.problem->system(), at.t, at.x, at.v, e.prepared, *at.problem->work);
  return status == Status::ok ? 0 : 1;  // 1: a smaller step may help
}

/// e.solution = dv for the right-hand side (bx, bv).
Status solve_eliminated(Elimination& e, const double* bx, const double* bv) {
  Where& at = *e.where;
  const System<double>& system = at.problem->system();
  e.solution.array() = 0;
  for (const auto [site, axis] : at.problem->unknowns()) e.solution.axis(axis)[site] = *bx++;
  e.tangents.product(at.t, at.x, at.v, {.stiffness = at.gamma, .kind = e.prepared.kind}, e.solution,
                     e.product);
  ++at.problem->work->products;
  for (const auto [site, axis] : at.problem->unknowns())
    e.rhs.axis(axis)[site] = system.mass(site) * *bv++ - e.product.axis(axis)[site];
  return e.linear->solve(e.rhs, e.solution, *at.problem->work);
}

int solve(SUNLinearSolver s, SUNMatrix m, N_Vector x, N_Vector b, double) {
  Elimination& e = elimination(s);
  const Eigen::Index size = e.where->problem->size();
  const double* bx = N_VGetArrayPointer(b);
  Status status = solve_eliminated(e, bx, bx + size);
  if (status == Status::not_positive_definite && e.kind != Tangent::projected) {
    e.kind = Tangent::projected;  // iterative solvers detect it only here; kept from here on
    if (set_up(s, m) != 0) return 1;
    status = solve_eliminated(e, bx, bx + size);
  }
  double *dx = N_VGetArrayPointer(x), *dv = dx + size;
  std::size_t i = 0;
  for (const auto [site, axis] : e.where->problem->unknowns()) {
    const double change = e.solution.axis(axis)[site];
    dx[i] = bx[i] + e.where->gamma * change;  // x and b may be the same vector
    dv[i] = change;
    ++i;
  }
  return status == Status::ok ? 0 : 1;
}

}  // namespace

int store_jacobian_state(double t, N_Vector y, N_Vector, SUNMatrix jacobian, void*, N_Vector, N_Vector,
                         N_Vector) {
  Where& at = where(jacobian);
  at.problem->fields(t, y);
  at.t = t;
  at.x = at.problem->x();
  at.v = at.problem->v();
  return 0;
}

Eliminated make_eliminated(FirstOrder& problem, const IntegratorOptions& options, SUNContext context) {
  const std::ptrdiff_t size = problem.system().size();
  std::unique_ptr<Elimination> content(  // first: a system without tangents throws
      new Elimination{.tangents = tangents_of(problem.system()),
                      .linear = find_linear_solver(options.linear_solver).make(options.linear_tolerance),
                      .kind = options.tangent,
                      .rhs = Field<double>(size),
                      .product = Field<double>(size),
                      .solution = Field<double>(size)});
  SUNLinearSolver s = SUNLinSolNewEmpty(context);
  s->content = content.release();
  s->ops->gettype = solver_type;
  s->ops->getid = solver_id;
  s->ops->setup = set_up;
  s->ops->solve = solve;
  s->ops->free = free_solver;
  return {Matrix(new_matrix(problem, context)), Solver(s)};
}

}  // namespace mss::sundials

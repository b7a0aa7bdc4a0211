// CVODE's variable-order, variable-step multistep methods on y = (x, v): Adams-Moulton of orders 1 to 12 with
// fixed-point iteration, and BDF of orders 1 to 5 with Newton's method and a choice of linear solvers.
// Hindmarsh et al., SUNDIALS, ACM TOMS 31 (2005) 363.
#include <cvode/cvode.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#include <sunmatrix/sunmatrix_sparse.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <stdexcept>

#include "core/base/error.hpp"
#include "integrators/linear/conjugate_gradients.hpp"
#include "integrators/linear/unknowns.hpp"
#include "integrators/sundials/eliminated.hpp"

namespace mss {

namespace {

using namespace sundials;

struct CvodeRelease {
  void operator()(void* memory) const { CVodeFree(&memory); }
};
struct NonlinearRelease {
  void operator()(SUNNonlinearSolver s) const { SUNNonlinSolFree(s); }
};

Status status_of(int flag) {
  if (flag >= 0) return Status::ok;
  switch (flag) {
    case CV_TOO_MUCH_WORK:
      return Status::step_limit;
    case CV_TOO_MUCH_ACC:
    case CV_ERR_FAILURE:
    case CV_TOO_CLOSE:  // of options that are sound: an interval so short that numbers end
    case CV_ILL_INPUT:
      return Status::tolerance_missed;
    case CV_CONV_FAILURE:
      return Status::newton_stalled;
    case CV_LSETUP_FAIL:
      return Status::not_positive_definite;
    case CV_LSOLVE_FAIL:
      return Status::linear_stalled;
    case CV_RHSFUNC_FAIL:
    case CV_FIRST_RHSFUNC_ERR:
    case CV_REPTD_RHSFUNC_ERR:
    case CV_UNREC_RHSFUNC_ERR:
      return Status::non_finite;
    default:
      throw std::logic_error("CVODE returned " + std::to_string(flag));
  }
}

/// What solves BDF's linear systems.
enum class Linear { none, eliminated, klu, gmres };

/// Everything CVODE needs for one system, from the first advance to a reset.
class Session {
 public:
  Session(System<double>& system, const State<double>& state, const IntegratorOptions& options,
          Linear linear);
  Status advance(State<double>& state, double t_end, Work& work);

 private:
  void attach_eliminated(const IntegratorOptions& options);
  void attach_klu();
  void attach_gmres();
  void find_events(double t, const Field<double>& x);
  void begin_again(double t);
  void count(Work& work);
  static int rate(double t, N_Vector y, N_Vector ydot, void* self);
  static int event_functions(double t, N_Vector y, double* values, void* self);
  static int write_jacobian(double t, N_Vector y, N_Vector, SUNMatrix jacobian, void* self, N_Vector,
                            N_Vector, N_Vector);
  static int prepare_preconditioner(double t, N_Vector y, N_Vector, int, int* updated, double gamma,
                                    void* self);
  static int precondition(double t, N_Vector y, N_Vector, N_Vector r, N_Vector z, double gamma, double, int,
                          void* self);

  Context context_ = make_context();
  FirstOrder problem_;
  Linear linear_;
  Tangents<double>* tangents_;  ///< nullptr: Adams-Moulton, which needs none
  Vector tolerances_;
  std::unique_ptr<std::remove_pointer_t<SUNNonlinearSolver>, NonlinearRelease> nonlinear_;
  Matrix matrix_;
  Solver solver_;
  std::unique_ptr<void, CvodeRelease> cvode_;
  long steps_ = 0, factorisations_ = 0, solves_ = 0;  ///< counted so far
  SparseMatrix stiffness_, damping_;                  ///< of KLU
  BlockJacobi preconditioner_;                        ///< of GMRES
  Field<double> mask_;                                ///< of unknowns
  Field<double> rhs_, change_, product_;
};

Session::Session(System<double>& system, const State<double>& state, const IntegratorOptions& options,
                 Linear linear)
    : problem_(system, context_.get()),
      linear_(linear),
      tangents_(linear == Linear::none ? nullptr : &tangents_of(system)),
      tolerances_(problem_.tolerances(options)),
      cvode_(CVodeCreate(linear == Linear::none ? CV_ADAMS : CV_BDF, context_.get())),
      rhs_(system.size()),
      change_(system.size()),
      product_(system.size()) {
  problem_.load_state(state);
  CVodeSetErrFile(cvode_.get(), nullptr);  // failures are statuses
  CVodeInit(cvode_.get(), rate, state.t, problem_.y());
  CVodeSVtolerances(cvode_.get(), 0, tolerances_.get());
  CVodeSetUserData(cvode_.get(), this);
  CVodeSetMaxNumSteps(cvode_.get(), options.most_steps);
  CVodeSetInitStep(cvode_.get(), options.dt);
  find_events(state.t, state.x);
  switch (linear) {
    case Linear::none:
      nonlinear_.reset(SUNNonlinSol_FixedPoint(problem_.y(), 0, context_.get()));
      CVodeSetNonlinearSolver(cvode_.get(), nonlinear_.get());
      break;
    case Linear::eliminated:
      attach_eliminated(options);
      break;
    case Linear::klu:
      attach_klu();
      break;
    case Linear::gmres:
      attach_gmres();
      break;
  }
}

void Session::attach_eliminated(const IntegratorOptions& options) {
  Eliminated eliminated = make_eliminated(problem_, options, context_.get());
  matrix_ = std::move(eliminated.matrix);
  solver_ = std::move(eliminated.solver);
  CVodeSetLinearSolver(cvode_.get(), solver_.get(), matrix_.get());
  CVodeSetJacFn(cvode_.get(), store_jacobian_state);
}

/// dg/dy = [0, I; -M^-1 K, -M^-1 C], by rows, with an entry for every diagonal element.
void Session::attach_klu() {
  if (!tangents_->has_fixed_pattern())
    throw InputError(
        "cvode_bdf_klu keeps the pattern of its matrix, and contact between bodies changes it; leave "
        "[contact] out, or give cvode_bdf");
  stiffness_ = damping_ = tangents_->pattern();
  const Eigen::Index size = problem_.size();
  matrix_.reset(
      SUNSparseMatrix(2 * size, 2 * size, 2 * size + 2 * stiffness_.nonZeros(), CSR_MAT, context_.get()));
  solver_.reset(SUNLinSol_KLU(problem_.y(), matrix_.get(), context_.get()));
  CVodeSetLinearSolver(cvode_.get(), solver_.get(), matrix_.get());
  CVodeSetJacFn(cvode_.get(), write_jacobian);
}

int Session::write_jacobian(double t, N_Vector y, N_Vector, SUNMatrix jacobian, void* self, N_Vector,
                            N_Vector, N_Vector) {
  Session& s = *static_cast<Session*>(self);
  const System<double>& system = s.problem_.system();
  s.problem_.fields(t, y);
  s.tangents_->values(t, s.problem_.x(), s.problem_.v(), {.stiffness = 1}, s.stiffness_);
  s.tangents_->values(t, s.problem_.x(), s.problem_.v(), {.damping = 1}, s.damping_);
  ++s.problem_.work->jacobians;
  const Eigen::Index size = s.problem_.size();
  sunindextype *start = SUNSparseMatrix_IndexPointers(jacobian),
               *column = SUNSparseMatrix_IndexValues(jacobian);
  double* value = SUNSparseMatrix_Data(jacobian);
  sunindextype place = 0;
  const auto put = [&](Eigen::Index at, double number) {
    column[place] = sunindextype(at);
    value[place++] = number;
  };
  for (Eigen::Index row = 0; row < size; ++row) {
    *start++ = place;
    put(row, 0);
    put(size + row, 1);
  }
  for (Eigen::Index row = 0; row < size; ++row) {
    *start++ = place;
    const double mass = system.mass(s.problem_.unknowns()[std::size_t(row)].site);
    for (SparseMatrix::InnerIterator k(s.stiffness_, row); k; ++k) put(k.col(), -k.value() / mass);
    for (SparseMatrix::InnerIterator c(s.damping_, row); c; ++c) put(size + c.col(), -c.value() / mass);
  }
  *start = place;
  return 0;
}

void Session::attach_gmres() {
  solver_.reset(SUNLinSol_SPGMR(problem_.y(), SUN_PREC_LEFT, 30, context_.get()));
  CVodeSetLinearSolver(cvode_.get(), solver_.get(), nullptr);
  CVodeSetPreconditioner(cvode_.get(), prepare_preconditioner, precondition);
}

/// The eliminated matrix M + gamma C + gamma^2 K, reduced to its 3 x 3 diagonal blocks.
int Session::prepare_preconditioner(double t, N_Vector y, N_Vector, int, int* updated, double gamma,
                                    void* self) {
  Session& s = *static_cast<Session*>(self);
  s.problem_.fields(t, y);
  if (s.mask_.size() == 0) s.mask_ = mask_of_unknowns(s.problem_.system());
  s.preconditioner_.prepare(
      s.problem_.system(), t, s.problem_.x(), s.problem_.v(),
      {.mass = 1, .damping = gamma, .stiffness = gamma * gamma, .kind = Tangent::projected}, s.mask_);
  ++s.problem_.work->jacobians;
  *updated = 1;
  return 0;
}

/// dv = B^-1 (M r_v - gamma K r_x), dx = r_x + gamma dv.
int Session::precondition(double t, N_Vector y, N_Vector, N_Vector r, N_Vector z, double gamma, double, int,
                          void* self) {
  Session& s = *static_cast<Session*>(self);
  const System<double>& system = s.problem_.system();
  s.problem_.fields(t, y);
  const double *rx = N_VGetArrayPointer(r), *rv = rx + s.problem_.size();
  double *dx = N_VGetArrayPointer(z), *dv = dx + s.problem_.size();
  std::size_t i = 0;
  s.change_.array() = 0;
  for (const auto [site, axis] : s.problem_.unknowns()) s.change_.axis(axis)[site] = rx[i++];
  s.tangents_->product(t, s.problem_.x(), s.problem_.v(), {.stiffness = gamma, .kind = Tangent::projected},
                       s.change_, s.product_);
  ++s.problem_.work->products;
  i = 0;
  for (const auto [site, axis] : s.problem_.unknowns())
    s.rhs_.axis(axis)[site] = system.mass(site) * rv[i++] - s.product_.axis(axis)[site];
  s.preconditioner_.apply(s.rhs_, s.change_, {0, system.size()});
  i = 0;
  for (const auto [site, axis] : s.problem_.unknowns()) {
    dv[i] = s.change_.axis(axis)[site];
    dx[i] = rx[i] + gamma * dv[i];
    ++i;
  }
  return 0;
}

int Session::rate(double t, N_Vector y, N_Vector ydot, void* self) {
  return static_cast<Session*>(self)->problem_.rate(t, y, ydot) ? 0 : 1;  // 1: a smaller step may help
}

/// Only where they fall, as bodies begin to touch: when they part, the force goes to zero smoothly.
void Session::find_events(double t, const Field<double>& x) {
  StepEvents<double>* events = problem_.system().events();
  const std::size_t count = events ? events->event_functions(t, x).size() : 0;
  if (count == 0) return;
  std::vector<int> directions(count, -1);
  CVodeRootInit(cvode_.get(), int(count), event_functions);
  CVodeSetRootDirection(cvode_.get(), directions.data());
  CVodeSetNoInactiveRootWarn(cvode_.get());  // bodies that start in contact stay there for a while
}

int Session::event_functions(double t, N_Vector y, double* values, void* self) {
  Session& s = *static_cast<Session*>(self);
  s.problem_.fields(t, y);
  System<double>& system = s.problem_.system();
  for (const double gap : system.events()->event_functions(t, s.problem_.x()))
    *values++ = -system.ranks().largest(-gap);  // the smallest of all
  return 0;
}

/// After an event: the history of a multistep method is not valid beyond it.
void Session::begin_again(double t) {
  CVodeReInit(cvode_.get(), t, problem_.y());
  steps_ = factorisations_ = solves_ = 0;
}

void Session::count(Work& work) {
  long steps = 0, setups = 0, solves = 0;
  CVodeGetNumSteps(cvode_.get(), &steps);
  work.steps += steps - std::exchange(steps_, steps);
  if (linear_ == Linear::klu) {
    CVodeGetNumLinSolvSetups(cvode_.get(), &setups);
    work.factorisations += setups - std::exchange(factorisations_, setups);
  }
  if (linear_ == Linear::klu || linear_ == Linear::gmres) {
    CVodeGetNumNonlinSolvIters(cvode_.get(), &solves);
    work.linear_solves += solves - std::exchange(solves_, solves);
  }
}

Status Session::advance(State<double>& state, double t_end, Work& work) {
  problem_.work = &work;
  int flag = CV_ROOT_RETURN;
  while (flag == CV_ROOT_RETURN && state.t < t_end) {
    CVodeSetStopTime(cvode_.get(), t_end);
    flag = CVode(cvode_.get(), t_end, problem_.y(), &state.t, CV_NORMAL);
    count(work);
    if (flag == CV_ROOT_RETURN) begin_again(state.t);
  }
  problem_.store_state(state);
  return status_of(flag);
}

class Cvode final : public Integrator<double> {
 public:
  Cvode(const IntegratorOptions& options, Linear linear) : options_(options), linear_(linear) {}

  Status do_advance(System<double>& system, State<double>& state, double t_end, Work& work) override {
    if (!(t_end > state.t)) return Status::ok;
    if (!session_ && advance_if_all_prescribed(system, state, t_end)) return Status::ok;
    if (!session_) session_ = std::make_unique<Session>(system, state, options_, linear_);
    return session_->advance(state, t_end, work);
  }

  void reset() override { session_.reset(); }

 private:
  IntegratorOptions options_;
  Linear linear_;
  std::unique_ptr<Session> session_;
};

IntegratorInfo describe_cvode(Linear linear, const std::string& name, const std::string& summary) {
  return {.name = name,
          .summary = summary,
          .stepping = Stepping::adaptive,
          .implicit = linear != Linear::none,
          .collisions = Collisions::never,
          .exact_restart = false,
          .make_double = [linear](const IntegratorOptions& o) { return std::make_unique<Cvode>(o, linear); }};
}

}  // namespace

IntegratorInfo cvode_adams() {
  return describe_cvode(Linear::none, "cvode_adams",
                        "CVODE Adams-Moulton, orders 1 to 12: adaptive, for what is not stiff");
}
IntegratorInfo cvode_bdf() {
  return describe_cvode(Linear::eliminated, "cvode_bdf",
                        "CVODE BDF, orders 1 to 5, positions eliminated: adaptive, any linear solver listed");
}
IntegratorInfo cvode_bdf_klu() {
  IntegratorInfo info =
      describe_cvode(Linear::klu, "cvode_bdf_klu", "CVODE BDF with KLU on the whole first-order system");
  info.linear_algebra = LinearAlgebra::own_factors;
  info.variant_of = "cvode_bdf";
  info.variation = "another linear solver, on twice the unknowns";
  return info;
}
IntegratorInfo cvode_bdf_gmres() {
  IntegratorInfo info =
      describe_cvode(Linear::gmres, "cvode_bdf_gmres", "CVODE BDF with GMRES, block-Jacobi preconditioned");
  info.linear_algebra = LinearAlgebra::own_products;
  info.variant_of = "cvode_bdf";
  info.variation = "another linear solver, on twice the unknowns";
  return info;
}

}  // namespace mss

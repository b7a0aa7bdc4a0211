// ARKODE's Runge-Kutta methods on y = (x, v), with adaptive steps: several stages where a multistep method
// has one, but no history.
// - Explicit: the pairs of Dormand and Prince, orders 5 and 4 (seven stages, the last of which is the next
//   step's first), J. Comput. Appl. Math. 6 (1980) 19; of Verner, orders 6 and 5 (eight stages), SIAM J.
//   Numer. Anal. 15 (1978) 772; of Fehlberg, orders 8 and 7 (thirteen stages), NASA TR R-287 (1968). Damping
//   forces are part of y', so these orders are theirs with damping too.
// - Diagonally implicit with an explicit first stage: ESDIRK4(3)7L[2]SA of Kennedy and Carpenter, orders 4
//   and 3, stiffly accurate and L-stable. All its stages have the same matrix. Appl. Numer. Math. 146 (2019)
//   221.
#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_erkstep.h>

#include <algorithm>
#include <stdexcept>
#include <type_traits>

#include "integrators/sundials/eliminated.hpp"

namespace mss {

namespace {

using namespace sundials;

struct ErkRelease {
  void operator()(void* memory) const { ERKStepFree(&memory); }
};
struct ArkRelease {
  void operator()(void* memory) const { ARKStepFree(&memory); }
};

Status status_of(int flag) {
  if (flag >= 0) return Status::ok;
  switch (flag) {
    case ARK_TOO_MUCH_WORK:
      return Status::step_limit;
    case ARK_TOO_MUCH_ACC:
    case ARK_ERR_FAILURE:
    case ARK_TOO_CLOSE:  // of options that are sound: an interval so short that numbers end
    case ARK_ILL_INPUT:
      return Status::tolerance_missed;
    case ARK_CONV_FAILURE:
      return Status::newton_stalled;
    case ARK_LSETUP_FAIL:
      return Status::not_positive_definite;
    case ARK_LSOLVE_FAIL:
      return Status::linear_stalled;
    case ARK_RHSFUNC_FAIL:
    case ARK_FIRST_RHSFUNC_ERR:
    case ARK_REPTD_RHSFUNC_ERR:
    case ARK_UNREC_RHSFUNC_ERR:
      return Status::non_finite;
    default:
      throw std::logic_error("ARKODE returned " + std::to_string(flag));
  }
}

int rate(double t, N_Vector y, N_Vector ydot, void* problem) {
  return static_cast<FirstOrder*>(problem)->rate(t, y, ydot) ? 0 : 1;  // 1: a smaller step may help
}

/// What both kinds need for one system, from the first advance to a reset.
struct Problem {
  Problem(System<double>& system, const State<double>& state, const IntegratorOptions& options)
      : form(system, context.get()), tolerances(form.tolerances(options)) {
    form.load_state(state);
  }
  void count(long now, Work& work) { work.steps += now - std::exchange(steps, now); }

  Context context = make_context();
  FirstOrder form;
  Vector tolerances;
  long steps = 0;  ///< counted so far
};

struct TableRelease {
  void operator()(ARKodeButcherTable table) const { ARKodeButcherTable_Free(table); }
};
using Table = std::unique_ptr<std::remove_pointer_t<ARKodeButcherTable>, TableRelease>;

/// A pair whose last stage is the solution. SUNDIALS 6.4 takes the rates of the last stage for those at the
/// next step's begin wherever it lies at the step's end, also where it is no solution, as in the pairs of
/// Verner and Fehlberg: steps then err more than is estimated. One stage more, without a weight, costs no
/// rate more.
Table with_solution_last(ARKODE_ERKTableID id) {
  Table pair(ARKodeButcherTable_LoadERK(id));
  const int stages = pair->stages;
  if (std::equal(pair->b, pair->b + stages, pair->A[stages - 1])) return pair;
  Table longer(ARKodeButcherTable_Alloc(stages + 1, SUNTRUE));
  longer->q = pair->q;
  longer->p = pair->p;
  for (int i = 0; i < stages; ++i) {
    longer->c[i] = pair->c[i];
    longer->b[i] = longer->A[stages][i] = pair->b[i];
    longer->d[i] = pair->d[i];
    std::copy_n(pair->A[i], stages, longer->A[i]);
  }
  longer->c[stages] = 1;
  return longer;
}

template <ARKODE_ERKTableID table>
class Explicit {
 public:
  Explicit(System<double>& system, const State<double>& state, const IntegratorOptions& options)
      : problem_(system, state, options),
        erk_(ERKStepCreate(rate, state.t, problem_.form.y(), problem_.context.get())) {
    ERKStepSetErrFile(erk_.get(), nullptr);  // failures are statuses
    ERKStepSetTable(erk_.get(), with_solution_last(table).get());
    ERKStepSVtolerances(erk_.get(), 0, problem_.tolerances.get());
    ERKStepSetUserData(erk_.get(), &problem_.form);
    ERKStepSetMaxNumSteps(erk_.get(), options.most_steps);
    ERKStepSetInitStep(erk_.get(), options.dt);
  }

  Status advance(State<double>& state, double t_end, Work& work) {
    problem_.form.work = &work;
    ERKStepSetStopTime(erk_.get(), t_end);
    const int flag = ERKStepEvolve(erk_.get(), t_end, problem_.form.y(), &state.t, ARK_NORMAL);
    problem_.form.store_state(state);
    long now = 0;
    ERKStepGetNumSteps(erk_.get(), &now);
    problem_.count(now, work);
    return status_of(flag);
  }

 private:
  Problem problem_;
  std::unique_ptr<void, ErkRelease> erk_;
};

class DiagonallyImplicit {
 public:
  DiagonallyImplicit(System<double>& system, const State<double>& state, const IntegratorOptions& options)
      : problem_(system, state, options),
        eliminated_(make_eliminated(problem_.form, options, problem_.context.get())),
        ark_(ARKStepCreate(nullptr, rate, state.t, problem_.form.y(), problem_.context.get())) {
    ARKStepSetErrFile(ark_.get(), nullptr);  // failures are statuses
    ARKStepSetTableNum(ark_.get(), ARKODE_ESDIRK437L2SA_7_3_4, ARKODE_ERK_NONE);
    ARKStepSVtolerances(ark_.get(), 0, problem_.tolerances.get());
    ARKStepSetUserData(ark_.get(), &problem_.form);
    ARKStepSetMaxNumSteps(ark_.get(), options.most_steps);
    ARKStepSetInitStep(ark_.get(), options.dt);
    ARKStepSetLinearSolver(ark_.get(), eliminated_.solver.get(), eliminated_.matrix.get());
    ARKStepSetJacFn(ark_.get(), store_jacobian_state);
    ARKStepSetDeduceImplicitRhs(ark_.get(), 1);  // from a stage's solution, not by one more force
    // A rate of convergence from before the step changed would let Newton's method end too early.
    ARKStepSetNonlinCRDown(ark_.get(), 1);
  }

  Status advance(State<double>& state, double t_end, Work& work) {
    problem_.form.work = &work;
    ARKStepSetStopTime(ark_.get(), t_end);
    const int flag = ARKStepEvolve(ark_.get(), t_end, problem_.form.y(), &state.t, ARK_NORMAL);
    problem_.form.store_state(state);
    long now = 0;
    ARKStepGetNumSteps(ark_.get(), &now);
    problem_.count(now, work);
    return status_of(flag);
  }

 private:
  Problem problem_;
  Eliminated eliminated_;
  std::unique_ptr<void, ArkRelease> ark_;
};

template <class Session>
class Arkode final : public Integrator<double> {
 public:
  explicit Arkode(const IntegratorOptions& options) : options_(options) {}

  Status do_advance(System<double>& system, State<double>& state, double t_end, Work& work) override {
    if (!(t_end > state.t)) return Status::ok;
    if (!session_ && advance_if_all_prescribed(system, state, t_end)) return Status::ok;
    if (!session_) session_ = std::make_unique<Session>(system, state, options_);
    return session_->advance(state, t_end, work);
  }

  void reset() override { session_.reset(); }

 private:
  IntegratorOptions options_;
  std::unique_ptr<Session> session_;
};

template <ARKODE_ERKTableID table>
IntegratorInfo explicit_pair(const std::string& name, const std::string& summary) {
  return {
      .name = name,
      .summary = "ARKODE, explicit Runge-Kutta of " + summary + ": adaptive",
      .stepping = Stepping::adaptive,
      .collisions = Collisions::never,
      .exact_restart = false,
      .make_double = [](const IntegratorOptions& o) { return std::make_unique<Arkode<Explicit<table>>>(o); }};
}

}  // namespace

IntegratorInfo arkode_erk() {
  return explicit_pair<ARKODE_DORMAND_PRINCE_7_4_5>("arkode_erk", "Dormand and Prince, order 5");
}
IntegratorInfo arkode_verner() {
  return explicit_pair<ARKODE_VERNER_8_5_6>("arkode_verner", "Verner, order 6");
}
IntegratorInfo arkode_fehlberg() {
  return explicit_pair<ARKODE_FEHLBERG_13_7_8>("arkode_fehlberg", "Fehlberg, order 8");
}
IntegratorInfo arkode_dirk() {
  return {.name = "arkode_dirk",
          .summary =
              "ARKODE, diagonally implicit Runge-Kutta, order 4, positions eliminated: adaptive, for what is "
              "stiff",
          .stepping = Stepping::adaptive,
          .implicit = true,
          .collisions = Collisions::never,
          .exact_restart = false,
          .make_double = [](const IntegratorOptions& o) {
            return std::make_unique<Arkode<DiagonallyImplicit>>(o);
          }};
}

}  // namespace mss

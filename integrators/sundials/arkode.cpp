// ARKODE's explicit Runge-Kutta pair of Dormand and Prince, orders 5 and 4, on y = (x, v): adaptive steps,
// four times the stages of a multistep method but no history. J. Comput. Appl. Math. 6 (1980) 19.
#include <arkode/arkode_erkstep.h>

#include <stdexcept>

#include "integrators/sundials/first_order.hpp"

namespace mss {

namespace {

using namespace sundials;

struct ErkRelease {
  void operator()(void* memory) const { ERKStepFree(&memory); }
};

class Arkode final : public Integrator<double> {
 public:
  explicit Arkode(const IntegratorOptions& options) : options_(options) {}

  Status advance(System<double>& system, State<double>& state, double t_end, Work& work) override {
    if (!(t_end > state.t)) return Status::ok;
    if (!session_ && advance_if_all_prescribed(system, state, t_end)) return Status::ok;
    if (!session_) session_ = std::make_unique<Session>(system, state, options_);
    return session_->advance(state, t_end, work);
  }

  void reset() override { session_.reset(); }

 private:
  struct Session {
    Session(System<double>& system, const State<double>& state, const IntegratorOptions& options)
        : problem(system, context.get()), tolerances(problem.tolerances(options)) {
      problem.load(state);
      erk.reset(ERKStepCreate(rate, state.t, problem.y(), context.get()));
      ERKStepSetErrFile(erk.get(), nullptr);  // failures are statuses
      ERKStepSetTableNum(erk.get(), ARKODE_DORMAND_PRINCE_7_4_5);
      ERKStepSVtolerances(erk.get(), 0, tolerances.get());
      ERKStepSetUserData(erk.get(), &problem);
      ERKStepSetMaxNumSteps(erk.get(), options.most_steps);
      ERKStepSetInitStep(erk.get(), options.dt);
    }

    static int rate(double t, N_Vector y, N_Vector ydot, void* problem) {
      return static_cast<FirstOrder*>(problem)->rate(t, y, ydot) ? 0 : 1;  // 1: a smaller step may help
    }

    Status advance(State<double>& state, double t_end, Work& work) {
      problem.work = &work;
      ERKStepSetStopTime(erk.get(), t_end);
      const int flag = ERKStepEvolve(erk.get(), t_end, problem.y(), &state.t, ARK_NORMAL);
      problem.store(state);
      long now = 0;
      ERKStepGetNumSteps(erk.get(), &now);
      work.steps += now - std::exchange(steps, now);
      return status_of(flag);
    }

    static Status status_of(int flag) {
      if (flag >= 0) return Status::ok;
      switch (flag) {
        case ARK_TOO_MUCH_WORK:
          return Status::step_limit;
        case ARK_TOO_MUCH_ACC:
        case ARK_ERR_FAILURE:
          return Status::tolerance_missed;
        case ARK_RHSFUNC_FAIL:
        case ARK_FIRST_RHSFUNC_ERR:
        case ARK_REPTD_RHSFUNC_ERR:
        case ARK_UNREC_RHSFUNC_ERR:
          return Status::non_finite;
        default:
          throw std::logic_error("ARKODE returned " + std::to_string(flag));
      }
    }

    Context context = make_context();
    FirstOrder problem;
    Vector tolerances;
    std::unique_ptr<void, ErkRelease> erk;
    long steps = 0;  ///< counted so far
  };

  IntegratorOptions options_;
  std::unique_ptr<Session> session_;
};

}  // namespace

IntegratorInfo arkode_erk() {
  return {.name = "arkode_erk",
          .summary = "ARKODE, explicit Runge-Kutta of Dormand and Prince, order 5: adaptive",
          .stepping = Stepping::adaptive,
          .make_double = [](const IntegratorOptions& o) { return std::make_unique<Arkode>(o); }};
}

}  // namespace mss

#include "experiments/python/callbacks.hpp"

#include <limits>
#include <utility>

#include "core/base/error.hpp"
#include "experiments/python/arrays.hpp"
#include "integrators/fixed_step.hpp"

namespace mss::python {

namespace py = pybind11;

void ForcedSystem::force(double t, const Field<double>& x, const Field<double>& v, Field<double>& f) {
  other().force(t, x, v, f);
  if (!error_ && !forces_.empty()) {
    const py::gil_scoped_acquire lock;
    try {
      for (const py::function& function : forces_)
        add_vectors(f, particles(),
                    Doubles(function(t, vectors_of(x, particles()), vectors_of(v, particles()))),
                    "the forces of a Python function");
    } catch (...) {
      error_ = std::current_exception();
    }
  }
  if (error_) f.array() = std::numeric_limits<double>::quiet_NaN();
}

// NOLINTBEGIN(bugprone-parent-virtual-call): forces from Python need the general ways of System, not those
// that a wrapper passes on.
void ForcedSystem::acceleration(double t, const Field<double>& x, const Field<double>& v, Field<double>& a) {
  if (empty())
    other().acceleration(t, x, v, a);
  else
    System<double>::acceleration(t, x, v, a);
}

void ForcedSystem::kick_drift(const KickDrift& update, double dt, long steps, State<double>& state) {
  if (empty())
    other().kick_drift(update, dt, steps, state);
  else
    System<double>::kick_drift(update, dt, steps, state);
}
// NOLINTEND(bugprone-parent-virtual-call)

void ForcedSystem::rethrow() {
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

PythonMethod::PythonMethod(py::function step, double dt)
    : step_(std::move(step)),
      acceleration_(py::cpp_function(
          [this](double t, const Doubles& x, const Doubles& v) { return acceleration(t, x, v); })),
      dt_(dt) {}

// NOLINTNEXTLINE(bugprone-exception-escape): without an interpreter there is nothing to go on with
PythonMethod::~PythonMethod() {
  const py::gil_scoped_acquire lock;
  step_ = py::function();
  acceleration_ = py::object();
}

Status PythonMethod::do_advance(System<double>& system, State<double>& state, double t_end, Work& work) {
  struct Stepping {
    PythonMethod& method;
    ~Stepping() { method.system_ = nullptr; }
  } const stepping{*this};
  system_ = &system;
  return advance_step_by_step(*this, system, state, dt_, t_end, work, [&] {
    take_step(state);
    work.force_evaluations += std::exchange(evaluations_, 0);
    return Status::ok;
  });
}

void PythonMethod::take_step(State<double>& state) {
  const py::gil_scoped_acquire lock;
  const auto& sites = system_->particles();
  const py::object result =
      step_(acceleration_, state.t, vectors_of(state.x, sites), vectors_of(state.v, sites), dt_);
  const auto [x, v] = result.cast<std::pair<Doubles, Doubles>>();
  set_vectors(state.x, sites, x, "the positions that a Python method returns");
  set_vectors(state.v, sites, v, "the velocities that a Python method returns");
  state.t += dt_;
  system_->constrain(state.t, state.x, state.v);
}

Doubles PythonMethod::acceleration(double t, const Doubles& x, const Doubles& v) {
  if (system_ == nullptr) throw InputError("acceleration() works during the step that it is given to only");
  const auto& sites = system_->particles();
  if (x_.size() == 0) x_ = v_ = a_ = Field<double>(system_->size());
  set_vectors(x_, sites, x, "the positions given to acceleration()");
  set_vectors(v_, sites, v, "the velocities given to acceleration()");
  system_->acceleration(t, x_, v_, a_);
  ++evaluations_;
  return vectors_of(a_, sites);
}

}  // namespace mss::python

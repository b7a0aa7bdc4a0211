#pragma once

#include <pybind11/pybind11.h>

#include <exception>
#include <vector>

#include "core/system/system_wrapper.hpp"
#include "experiments/python/arrays.hpp"
#include "integrators/integrator.hpp"

namespace mss::python {

/// Another system with forces that Python functions compute: f(t, x, v) -> (N, 3) in newtons. Their
/// derivatives are unknown to implicit methods, which take them as constant in each iteration.
///
/// An exception must not pass through the C code of solvers. It is kept, and forces are not a number from
/// then on, which ends every method.
class ForcedSystem final : public SystemWrapper<double> {
 public:
  explicit ForcedSystem(System<double>& other) : SystemWrapper<double>(other) {}

  void add(pybind11::function force) { forces_.push_back(std::move(force)); }
  bool empty() const { return forces_.empty(); }

  void force(double t, const Field<double>& x, const Field<double>& v, Field<double>& f) override;
  void acceleration(double t, const Field<double>& x, const Field<double>& v, Field<double>& a) override;
  void kick_drift(const KickDrift& update, double dt, long steps, State<double>& state) override;

  /// Throws the exception kept, if there is one, and forgets it.
  void rethrow();

 private:
  std::vector<pybind11::function> forces_;
  std::exception_ptr error_;
};

/// A method of fixed step that a Python function computes: step(acceleration, t, x, v, dt) -> (x, v), where
/// acceleration(t, x, v) -> (N, 3) in m/s^2.
class PythonMethod final : public Integrator<double> {
 public:
  PythonMethod(pybind11::function step, double dt);
  ~PythonMethod() override;  // NOLINT(bugprone-exception-escape): as in callbacks.cpp
  Status do_advance(System<double>& system, State<double>& state, double t_end, Work& work) override;

 private:
  void take_step(State<double>& state);
  Doubles acceleration(double t, const Doubles& x, const Doubles& v);

  pybind11::function step_;
  pybind11::object acceleration_;
  double dt_;
  System<double>* system_ = nullptr;  ///< while a step is taken
  long evaluations_ = 0;              ///< in it
  Field<double> x_, v_, a_;
};

}  // namespace mss::python

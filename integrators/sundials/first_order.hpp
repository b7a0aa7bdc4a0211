#pragma once

// This folder is the only place that names SUNDIALS.

#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>

#include <memory>
#include <new>
#include <type_traits>

#include "integrators/integrator.hpp"

namespace mss::sundials {

struct ContextRelease {
  void operator()(SUNContext context) const { SUNContext_Free(&context); }
};
using Context = std::unique_ptr<std::remove_pointer_t<SUNContext>, ContextRelease>;
inline Context make_context() {
  SUNContext context = nullptr;
  if (SUNContext_Create(nullptr, &context) != 0) throw std::bad_alloc();
  return Context(context);
}

struct VectorRelease {
  void operator()(N_Vector v) const { N_VDestroy(v); }
};
using Vector = std::unique_ptr<std::remove_pointer_t<N_Vector>, VectorRelease>;

/// Where every coordinate is prescribed there is nothing to solve, and SUNDIALS has no empty vectors: writes
/// the state at t_end. False, and nothing is done, where there is an unknown.
bool advance_if_all_prescribed(System<double>& system, State<double>& state, double t_end);

/// A system in first-order form: y' = g(t, y) with y = (x, v) of the unknowns. Prescribed coordinates are
/// not among them; they are written before every evaluation.
class FirstOrder {
 public:
  FirstOrder(System<double>& system, SUNContext context);

  System<double>& system() { return system_; }
  N_Vector y() { return y_.get(); }
  const std::vector<FreeDof>& unknowns() const { return unknowns_; }
  Eigen::Index size() const { return size_; }  ///< number of unknowns; y has twice as many

  void load_state(const State<double>& state);
  void store_state(State<double>& state) const;  ///< also writes prescribed coordinates at state.t

  /// Fields from a vector, prescribed coordinates included; valid until the next call.
  void fields(double t, N_Vector y);
  const Field<double>& x() const { return x_; }
  const Field<double>& v() const { return v_; }

  /// ydot = (v, M^-1 f). False if it is not finite.
  bool rate(double t, N_Vector y, N_Vector ydot);

  /// Absolute tolerances of y: tolerance times the options' scales of length and speed.
  Vector tolerances(const IntegratorOptions& options) const;

  Work* work = nullptr;        ///< counts what callbacks do
  std::exception_ptr failure;  ///< an exception that must not cross C code

 private:
  System<double>& system_;
  std::vector<FreeDof> unknowns_;
  Eigen::Index size_;
  Vector y_;
  Field<double> x_, v_, a_;
};

}  // namespace mss::sundials

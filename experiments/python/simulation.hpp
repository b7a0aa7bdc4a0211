#pragma once

#include <pybind11/pybind11.h>

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"
#include "experiments/python/arrays.hpp"
#include "integrators/integrator.hpp"

namespace mss::python {

/// A simulation that failed; the message says how and when.
struct SimulationFailed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A scene being simulated, as Python sees it: fields as arrays (N, 3) of doubles, copied, whatever precision
/// the scene computes in. The interpreter is free while it computes, and no other thread may use it then.
class Simulation {
 public:
  Simulation() = default;
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;
  virtual ~Simulation() = default;

  virtual const Scene& scene() const = 0;
  /// Its bodies.
  virtual const std::vector<Level>& levels() const = 0;
  virtual double time() const = 0;
  virtual double dt() const = 0;
  virtual const Work& work() const = 0;
  virtual Doubles positions() const = 0;
  virtual Doubles velocities() const = 0;
  virtual Doubles forces() = 0;
  /// (M, 3, 3) [Pa], with or without dampers' part. Throws InputError for models that do not know it.
  virtual Doubles cell_stress(bool damping) const = 0;
  virtual pybind11::dict measures() = 0;

  /// Throws InputError for a time that is past, SimulationFailed, and what a Python function throws; the
  /// state is then the one before.
  virtual void advance(double until) = 0;
  /// Throws InputError for arrays of another shape and numbers that are not finite.
  virtual void set_state(double t, const Doubles& x, const Doubles& v) = 0;
  /// Both throw InputError for scenes in single precision, and add_force() for scenes that let particles
  /// sleep.
  virtual void add_force(pybind11::function force) = 0;
  virtual void set_integrator(pybind11::function step) = 0;
};

/// Throws InputError if the scene cannot be simulated.
std::unique_ptr<Simulation> make_simulation(const Scene& scene);

}  // namespace mss::python

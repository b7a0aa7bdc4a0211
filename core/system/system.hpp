#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

#include "core/base/communicator.hpp"
#include "core/base/field.hpp"
#include "core/base/state.hpp"
#include "core/system/step_events.hpp"
#include "core/system/step_memory.hpp"
#include "core/system/tangents.hpp"

namespace mss {

template <class Real>
class BodySystem;
template <class Real>
class DiscreteGradient;
class PlaneBounds;
class PlaneImpulses;
class ReducedMotion;
template <class Real>
class SolidSystem;
template <class Real>
class SpringSystem;

/// The linear update that every one-stage explicit method makes from an acceleration a:
///   v' = (v + kick_before a) + kick_after a,   x' = x + drift_old v + drift_new v'.
/// All four are times [s]. The two kicks are added one after the other, so that a method that stops between
/// them (velocity Verlet) gives the same bits as one that does not.
struct KickDrift {
  double kick_before = 0;
  double kick_after = 0;
  double drift_old = 0;
  double drift_new = 0;
};

/// The second-order ODE M a = f(t, x, v) that every integrator, experiment and window drives.
///
/// Masses are lumped. Prescribed coordinates have no acceleration; constrain() writes their motion. Fields
/// have size() sites; sites without a particle have inverse mass 0. A model for explicit methods needs the
/// first four functions only; a class that wraps another system derives from SystemWrapper.
template <class Real>
class System {
 public:
  System() = default;
  System(const System&) = delete;
  System& operator=(const System&) = delete;
  virtual ~System() = default;

  /// Sites of every field.
  virtual std::ptrdiff_t size() const = 0;

  /// Sites that contain particles, ascending.
  virtual const std::vector<std::ptrdiff_t>& particles() const = 0;

  /// Mass of the particle at a site [kg]; 0 where there is none.
  virtual double mass(std::ptrdiff_t site) const = 0;

  /// Forces on all particles [N], shape 3 x sites; overwritten.
  virtual void force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f) = 0;

  /// M^-1 f [m/s^2], shape 3 x sites, 0 for prescribed coordinates; overwritten.
  virtual void acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a);

  /// Writes prescribed positions and velocities at time t.
  virtual void constrain(double t, Field<Real>& x, Field<Real>& v) const;

  /// Zeroes prescribed coordinates of a field (a residual, a search direction), and only these.
  virtual void clear_prescribed(Field<Real>& field) const;

  /// Derivatives of the forces; nullptr if the model has none, and then only explicit methods can be used.
  virtual Tangents<Real>* tangents() { return nullptr; }

  /// The body of cells that the system moves, but for forces that a wrapper adds, for solvers that work on
  /// larger cells; nullptr if there is none.
  virtual const BodySystem<Real>* cells() const { return nullptr; }
  /// The same of cells of one size or of several.
  virtual const SolidSystem<Real>* solid() const { return nullptr; }
  /// The same as cells() if they are of springs, for methods that step these one by one.
  virtual const SpringSystem<Real>* springs() const { return nullptr; }

  /// What an energy-conserving method needs beside the force; nullptr if the model has none.
  virtual DiscreteGradient<Real>* discrete_gradient() { return nullptr; }

  /// Whether some particles take several steps in each of a method's, which must have one force a step.
  virtual bool in_local_steps() const { return false; }

  /// Contact and sleep; nullptr if nothing happens between steps.
  virtual StepEvents<Real>* events() { return nullptr; }

  /// What forces depend on beside the moment's positions and velocities; nullptr where there is nothing.
  virtual StepMemory<Real>* memory() { return nullptr; }

  /// The few coordinates that its particles follow; nullptr where each moves by itself.
  virtual ReducedMotion* reduced() { return nullptr; }

  /// Planes as bounds, for methods that keep contact inside their steps; nullptr where there are none, or
  /// where planes touch a surface instead of particles.
  virtual const PlaneBounds* bounds() const { return nullptr; }

  /// Where planes and methods write down what planes give particles in a step; nullptr where no plane acts by
  /// impulses.
  virtual PlaneImpulses* plane_impulses() const { return nullptr; }

  /// Those that share the system, each with some of its particles. What methods decide by a state, and sums
  /// over particles, are to be all ranks' together.
  virtual const Communicator& ranks() const { return Communicator::alone(); }

  /// Runs task(0) ... task(count - 1), on as many threads as forces are computed with. Tasks must not throw.
  virtual void parallel(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task);
  /// Threads that took part, on average over what was computed so far: fewer than there are while other
  /// programs have the cores.
  virtual double threads_working() const { return 1; }

  /// One update from a given acceleration; advances state.t by dt.
  virtual void apply(const KickDrift& update, const Field<Real>& a, double dt, State<Real>& state) const;

  /// `steps` updates, each from the acceleration at its beginning; advances state.t by steps dt.
  virtual void kick_drift(const KickDrift& update, double dt, long steps, State<Real>& state);

 private:
  Field<Real> scratch_;
};

/// A system's tangents. Throws InputError if it has none.
template <class Real>
Tangents<Real>& tangents_of(System<Real>& system);

/// The coordinates that nothing prescribes, by particle, then axis: those of its tangents, if it has any.
template <class Real>
std::vector<FreeDof> unknowns_of(const System<Real>& system);

/// As system.parallel(), for tasks so short that only `group` of them together are worth handing to a thread.
template <class Real, class Task>
void parallel_in_groups(System<Real>& system, std::ptrdiff_t count, std::ptrdiff_t group, Task&& task) {
  system.parallel((count + group - 1) / group, [&](std::ptrdiff_t g) {
    for (std::ptrdiff_t i = g * group; i < std::min(count, (g + 1) * group); ++i) task(i);
  });
}

/// Says that velocities change by the last acceleration for so long [s]. Methods whose steps have several
/// accelerations call it after each, so that the forces on what sticks to planes add up to what planes give;
/// those that use apply() need not.
template <class Real>
void kicked_for(const System<Real>& system, double seconds);

/// Calls task(site) for every particle, on all of the system's threads. Tasks must not throw.
template <class Real, class Task>
void for_each_particle(System<Real>& system, Task&& task) {
  constexpr std::ptrdiff_t portion = 256;
  const std::vector<std::ptrdiff_t>& sites = system.particles();
  const auto count = std::ptrdiff_t(sites.size());
  parallel_in_groups(system, count, portion, [&](std::ptrdiff_t p) { task(sites[std::size_t(p)]); });
}

}  // namespace mss

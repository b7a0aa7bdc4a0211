#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <vector>

#include "core/body/body.hpp"
#include "core/body/spectral_bound.hpp"
#include "core/environment/environment.hpp"
#include "core/system/system.hpp"

namespace mss {

class Record;
class RefinedBody;

/// Energy stored in a deformed body [J].
struct StoredEnergy {
  double elastic = 0;   ///< of springs and the guard against folding, or of finite elements
  double volume = 0;    ///< eq. 3-1 summed over cells
  double relaxing = 0;  ///< of Maxwell branches, which their dampers dissipate
};

/// Forces of something on a solid: their sum [N], then that of their moments about the origin [N m].
using Wrench = Eigen::Matrix<double, 6, 1>;
inline void add_force(const Vec3& at, const Vec3& force, Wrench& sum) {
  sum.head<3>() += force;
  sum.tail<3>() += at.cross(force);
}

/// A deformable solid in its environment: what a simulation measures, writes and draws. BodySystem is one of
/// cells of one size, RefinedSystem one of several.
template <class Real>
class SolidSystem : public System<Real> {
 public:
  /// Its lattices, one after the other in fields; at least one. Where there are several, some of their
  /// particles follow others: these are not among particles(), and constrain() puts them where they belong.
  virtual const std::vector<Level>& levels() const = 0;
  /// How they hang together; nullptr: all cells have one size.
  virtual const RefinedBody* refined_body() const { return nullptr; }
  /// [m/s^2]
  virtual Vec3 gravity() const = 0;

  const SolidSystem* solid() const override { return this; }
  const Communicator& ranks() const override { return levels().front().body.ranks(); }

  /// The solid while nothing acts on it: boundary conditions have not moved anything.
  State<Real> undeformed_state() const;
  /// The same at t = 0, with held coordinates where holds put them.
  State<Real> rest_state() const;

  /// Energy stored at positions x; NaN or infinite where x is.
  virtual StoredEnergy stored_energy(const Field<Real>& x) const = 0;
  /// What dampers of Maxwell branches have dissipated until the last step's end [J].
  virtual double dissipated_by_relaxation() const { return 0; }
  /// Virials of cells at positions x [m] and velocities v [m/s], by level in the order of for_each_cell(): of
  /// each -sum f x^T [J] of the forces f by which what is in it acts on its corners x. All cells' forces add
  /// up to the solid's own. Nothing where a model's forces are not those of cells. Ghosts must be up to date.
  virtual std::optional<std::vector<Eigen::Matrix3d>> cell_virials(const Field<Real>&,
                                                                   const Field<Real>&) const {
    return std::nullopt;
  }
  /// Potential of gravity, from z = 0, of loads and of penalty planes at time t and positions x [J].
  virtual double outer_potential(double t, const Field<Real>& x) const = 0;

  /// Adds the forces of penalty planes, then of such obstacles, in the environment's order. All ranks must
  /// call it.
  virtual void add_penalty_forces(const State<Real>& state, std::vector<Wrench>& forces) const = 0;

  /// Bounds on the spectrum of the solid where it may touch planes.
  virtual SpectralBound spectral_bound() const = 0;

  /// What with_local_steps() is limited by, as a bound without damping.
  virtual SpectralBound local_bound() const { return spectral_bound(); }
  /// The same solid for methods with one force a step, in steps of dt [s] that only its larger cells resolve
  /// (local_steps.hpp); nullptr where all cells have one size.
  virtual std::unique_ptr<System<Real>> with_local_steps(double) { return nullptr; }

  /// Threads that forces are computed with.
  virtual int threads() const = 0;
  /// What computes them, as an instruction set.
  virtual const char* kernel_name() const = 0;

  virtual bool all_asleep() const { return false; }
  /// Planes of particles that sleep, over all.
  virtual double share_asleep() const { return 0; }
  /// Must be called after a change of velocities.
  virtual void wake_moving(const State<Real>&) {}
  /// Must be called after a change of positions, or of what acts on the solid.
  virtual void wake_all() {}

  /// What it keeps from step to step: which parts sleep, what planes have given. See core/base/record.hpp.
  virtual void remember(Record&) {}

  /// Where other ranks share the solid: gets from them what measures of a state read at ghosts.
  virtual void update_ghosts(const State<Real>&) const {}

  double total_mass() const;
  /// Position at rest of the particle at a site [m].
  Vec3 rest_position(std::ptrdiff_t site) const;
  /// Of the smallest cells [m].
  double cell_size() const { return levels().back().body.config().cell_size; }

  /// Adds the velocity change of an impulse; prescribed velocities are overwritten again, so there it is
  /// lost.
  void give(const Strike& strike, Field<Real>& v) const;
};

}  // namespace mss

#pragma once

#include <cstddef>
#include <vector>

#include "core/field.hpp"

namespace mss {

/// Positions [m] and velocities [m/s] of every site at time t [s].
template <class Real>
struct State {
  double t = 0;
  Field<Real> x;
  Field<Real> v;
};

/// The linear update every one-stage explicit method makes once it knows the acceleration a:
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
/// Masses are lumped. Prescribed coordinates have no acceleration; constrain() writes what they do. Fields
/// have size() sites; sites without a particle have inverse mass 0.
template <class Real>
class System {
 public:
  System() = default;
  System(const System&) = delete;
  System& operator=(const System&) = delete;
  virtual ~System() = default;

  /// Sites of every field.
  virtual std::ptrdiff_t size() const = 0;

  /// Sites that hold particles, ascending.
  virtual const std::vector<std::ptrdiff_t>& particles() const = 0;

  /// Mass of the particle at a site [kg]; 0 where there is none.
  virtual double mass(std::ptrdiff_t site) const = 0;

  /// Forces on all particles [N], shape 3 x sites; overwritten.
  virtual void force(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& f) = 0;

  /// M^-1 f [m/s^2], shape 3 x sites, 0 for prescribed coordinates; overwritten.
  virtual void acceleration(double t, const Field<Real>& x, const Field<Real>& v, Field<Real>& a);

  /// Writes prescribed positions and velocities at time t.
  virtual void constrain(double t, Field<Real>& x, Field<Real>& v) const;

  /// One update from a known acceleration; advances state.t by dt.
  virtual void apply(const KickDrift& update, const Field<Real>& a, double dt, State<Real>& state) const;

  /// `steps` updates, each from the acceleration at its beginning; advances state.t by steps dt.
  virtual void kick_drift(const KickDrift& update, double dt, long steps, State<Real>& state);

 private:
  Field<Real> scratch_;
};

/// True if all positions and velocities of particles are finite numbers.
template <class Real>
bool is_finite(const State<Real>& state) {
  // Infinity and NaN survive multiplication by zero, everything else does not.
  const auto zero = [](const Field<Real>& f) { return (f.array() * Real(0)).sum() == Real(0); };
  return zero(state.x) && zero(state.v);
}

}  // namespace mss

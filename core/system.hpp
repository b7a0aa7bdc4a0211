#pragma once

#include <Eigen/SparseCore>
#include <cstddef>
#include <functional>
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

/// Which derivative of the force a tangent holds.
enum class Tangent {
  exact,     ///< all of it; unsymmetric where springs damp while they turn
  elastic,   ///< without what damping adds as springs turn: symmetric, indefinite where springs are pressed
  projected  ///< the elastic one made positive semidefinite, spring by spring and cell by cell
};

/// The matrix a M + b C + c K, with C = -df/dv and K = -df/dx, that one step of an implicit method needs.
struct TangentSum {
  double mass = 0;       ///< a
  double damping = 0;    ///< b
  double stiffness = 0;  ///< c
  Tangent kind = Tangent::exact;
};

/// A coordinate that nothing prescribes.
struct Unknown {
  std::ptrdiff_t site;
  int axis;
};

/// Rows in compressed form; rows and columns are unknowns.
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor, int>;

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

  /// Zeroes prescribed coordinates of a field (a residual, a search direction), and only these.
  virtual void clear_prescribed(Field<Real>& field) const;

  /// The unknowns of implicit methods, in the order of a tangent's rows: by particle, then axis.
  virtual const std::vector<Unknown>& unknowns() = 0;

  /// A matrix with a place for every number a tangent may hold; all are zero.
  virtual SparseMatrix tangent_pattern() = 0;

  /// Rewrites the values of a matrix from tangent_pattern() in place.
  virtual void tangent(double t, const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                       SparseMatrix& matrix) = 0;

  /// out = (a M + b C + c K) p for all coordinates, prescribed ones included, without the matrix;
  /// overwritten. Not for Tangent::exact.
  virtual void tangent_product(double t, const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                               const Field<Real>& p, Field<Real>& out) = 0;

  /// The 3 x 3 blocks on the diagonal of a tangent, one per particle, prescribed coordinates included;
  /// resized and overwritten.
  virtual void tangent_diagonal(double t, const Field<Real>& x, const Field<Real>& v, const TangentSum& sum,
                                std::vector<Eigen::Matrix3d>& blocks) = 0;

  /// True if bodies collide at the end of steps: then whoever takes a step calls collide() after it.
  virtual bool collides() const { return false; }

  /// What collisions make of a step of dt that led from `before` to `state`. False if nothing changed.
  virtual bool collide(const State<Real>& before, double dt, State<Real>& state);

  /// True if particles may fall asleep: then whoever takes a step by accelerations calls settle() after it.
  virtual bool sleeps() const { return false; }

  /// Puts to sleep what rests and wakes what is disturbed. True if either happened: some have lost their
  /// velocity, or got an acceleration.
  virtual bool settle(State<Real>& state);

  /// True if steps would change nothing but the time.
  virtual bool all_asleep() const { return false; }

  /// Functions of the positions that become negative where the force has a kink [m]; none if there are none.
  /// Methods that choose their steps do well to end one there.
  virtual std::vector<double> kinks(const Field<Real>& x) const;

  /// Runs task(0) ... task(count - 1), on as many threads as forces are computed with. Tasks must not throw.
  virtual void parallel(std::ptrdiff_t count, const std::function<void(std::ptrdiff_t)>& task);

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

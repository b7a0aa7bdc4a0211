#pragma once

#include <vector>

#include "core/springs/solid_system.hpp"
#include "integrators/integrator.hpp"

namespace mss {

/// One free vibration about a state: K q = omega^2 M q.
struct Mode {
  double omega = 0;     ///< [rad/s]; 0 for rigid motions
  Field<double> shape;  ///< q, with q.M q = 1 [kg^-1/2]
};

struct Modes {
  Status status = Status::ok;  ///< not_positive_definite: the state is not stable
  std::vector<Mode> modes;     ///< ascending
};

/// The slowest vibrations of a body about a state, prescribed coordinates still: Lanczos with K + s M
/// inverted by CHOLMOD, repeated on what is left until no slower one is found, so that pairs of equal
/// frequency are both found. As many as requested, or as there are unknowns.
Modes slowest_modes(SolidSystem<double>& system, const State<double>& state, int count, Work& work);

/// The fastest one, by Lanczos through the matrix-free product, to nine digits: it limits the step of
/// explicit methods.
Modes fastest_mode(SolidSystem<double>& system, const State<double>& state, Work& work);

/// Stiffness and damping of a motion q with q.M q = 1.
struct RayleighQuotients {
  Status status = Status::ok;
  double stiffness = 0;  ///< q.K q [1/s^2]
  double damping = 0;    ///< q.C q [1/s]
};

/// Whether the motion is rigid, for a body whose frequencies are bounded by omega.
inline bool is_rigid(const RayleighQuotients& motion, double omega) {
  return motion.stiffness < 1e-10 * omega * omega;
}

/// Those of the motion for which q.K q + weight q.C q is largest, weight in [1/s] and of either sign.
RayleighQuotients largest_quotient(SolidSystem<double>& system, const State<double>& state, double weight,
                                   Work& work);

}  // namespace mss

#pragma once

#include <memory>
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
  /// Largest |M^-1/2 (K q - omega^2 M q)| / (2 omega^2) of those that are not rigid: each omega is that near,
  /// relative to it, to one of the body's (Parlett, The Symmetric Eigenvalue Problem, section 4.5).
  double error = 0;
};

/// How slow vibrations are searched for.
enum class ModeSearch {
  automatic,  ///< multigrid for bodies of cells of one size with more than 2000 particles that are at most
              ///< five times as long as thin, or have more than 100000; factored for others and where it
              ///< stalls
  factored,   ///< Lanczos with the inverse of K + s M by CHOLMOD
  multigrid   ///< LOBPCG with a multigrid V-cycle of K + s M (lobpcg.hpp); for bodies of cells of one size
};

/// The slowest vibrations of a body about a state, prescribed coordinates still; as many as requested, or as
/// there are unknowns; all of them densely where that is cheapest. Each search is repeated from another start
/// on what is orthogonal to what it has found until nothing slower is there, so that none of several equal
/// frequencies is missed. Throws InputError if the system has no tangents, or for a search that is not for
/// it.
Modes slowest_modes(SolidSystem<double>& system, const State<double>& state, int count, Work& work,
                    ModeSearch search = ModeSearch::automatic);

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

class ScaledTangent;

/// Those of the motion for which q.K q + weight q.C q is largest, weight in [1/s] and of either sign; by
/// Lanczos. The tangent is the body's.
RayleighQuotients largest_quotient(ScaledTangent& tangent, const SpectralBound& bound, double weight,
                                   Work& work);

}  // namespace mss
